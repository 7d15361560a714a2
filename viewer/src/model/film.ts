// Films of ways: where parts are at a share of a way that was found. Pure.

import type { CardAnswer, FilmWay, Gap } from "../link/protocol";
import { carry, IDENTITY, multiply, orthonormal, type Pose } from "../math/matrix";
import { distance, type Vec3 } from "../math/vectors";

export type Way = CardAnswer["ways"][number] | FilmWay;

/** Where the parts of a line begin; null of a card's way, which begins where the parts lie now. */
export const startsOf = (way: Way): FilmWay["starts"] | null => ("starts" in way ? (way as FilmWay).starts : null);

/** The subject of a film: the ways of a card, or the sequence of removals. */
export type FilmOf = number | "sequence";

/** A film that is open: its ways one after the other, and how far it is. */
export interface Film {
  readonly card: FilmOf;
  /** The way that plays, from 0. */
  readonly step: number;
  /** Of that way, 0 to 1. */
  readonly share: number;
  readonly is_playing: boolean;
}

const M_PER_S = 0.15;
const LEAST_S = 1.5;
const MOST_S = 12;

/** Travel of the fastest of some points up to each pose: shares from 0 to 1. */
export function sharesOf(poses: readonly Pose[], points: readonly Vec3[]): number[] {
  const gone = [0];
  for (let k = 1; k < poses.length; k++) {
    const [from, to] = [poses[k - 1] as Pose, poses[k] as Pose];
    const step = Math.max(0, ...points.map((point) => distance(carry(from, point), carry(to, point))));
    gone.push((gone[k - 1] as number) + step);
  }
  const total = gone.at(-1) as number;
  return total > 0 ? gone.map((each) => each / total) : gone.map((_, k) => k / Math.max(1, gone.length - 1));
}

/** The motion of the parts at a share of a way. */
export function motionAt(poses: readonly Pose[], shares: readonly number[], share: number): Pose {
  if (share >= 1) return [...(poses.at(-1) ?? IDENTITY)];
  const next = shares.findIndex((each) => each > share);
  const from = poses[Math.max(0, next - 1)] ?? IDENTITY;
  const to = poses[next];
  if (next <= 0 || !to) return [...from];
  const [low, high] = [shares[next - 1] as number, shares[next] as number];
  const part = (share - low) / (high - low);
  return orthonormal(from.map((value, k) => value + part * ((to[k] as number) - value)));
}

/** Seconds that a way takes in a film, by its length in metres. */
export const secondsOf = (way: Pick<Way, "length">): number =>
  Math.min(MOST_S, Math.max(LEAST_S, way.length / M_PER_S));

/** A film some seconds later, of its own time: on to the next way at the end of one; it stands at the end of the last. */
export function advanced(film: Film, ways: readonly Pick<Way, "length">[], seconds: number): Film {
  let { step, share } = film;
  let rest = seconds;
  for (let way = ways[step]; way; way = ways[step]) {
    const left = (1 - share) * secondsOf(way);
    if (rest < left) return { ...film, step, share: share + rest / secondsOf(way) };
    rest -= left;
    if (step + 1 >= ways.length) return { ...film, step, share: 1, is_playing: false };
    step++;
    share = 0;
  }
  return { ...film, is_playing: false };
}

/** The moment of a film, seconds from its start. */
export function timeOf(film: Pick<Film, "step" | "share">, ways: readonly Pick<Way, "length">[]): number {
  const before = ways.slice(0, film.step).reduce((sum, way) => sum + secondsOf(way), 0);
  const way = ways[film.step];
  return before + (way ? film.share * secondsOf(way) : 0);
}

/** How far a film is at some seconds; of two ways, the later one begins. */
export function placeAt(ways: readonly Pick<Way, "length">[], seconds: number): Pick<Film, "step" | "share"> {
  let rest = Math.max(0, seconds);
  for (const [step, way] of ways.entries()) {
    const length = secondsOf(way);
    if (rest < length) return { step, share: rest / length };
    rest -= length;
  }
  return { step: Math.max(0, ways.length - 1), share: 1 };
}

/** The gaps of all ways, by their share of the whole film. */
export function gapsOf(ways: readonly (Pick<Way, "length"> & { readonly gaps: readonly Gap[] })[]): Gap[] {
  const total = ways.reduce((sum, way) => sum + secondsOf(way), 0);
  return ways.flatMap((way, step) =>
    way.gaps.map((gap) => ({ ...gap, share: timeOf({ step, share: gap.share }, ways) / total })),
  );
}

/** world_from_part of all parts that a film moves: those of earlier ways are at their ends, of later lines at their
 * starts. */
export function placesAt(
  film: Film,
  ways: readonly Way[],
  starts: Readonly<Record<string, Pose>>,
  pointsOf: (parts: readonly number[]) => Vec3[],
): Map<number, Pose> {
  const places = new Map<number, Pose>();
  const startOf = (way: Way, part: number): Pose => [...((startsOf(way) ?? starts)[part] ?? IDENTITY)];
  for (const [k, way] of ways.entries()) {
    if (k > film.step) {
      if (startsOf(way)) for (const part of way.parts) if (!places.has(part)) places.set(part, startOf(way, part));
      continue;
    }
    const share = k < film.step ? 1 : film.share;
    const poses = way.poses.map((pose) => [...pose]);
    const motion = motionAt(poses, share < 1 ? sharesOf(poses, pointsOf(way.parts)) : [], share);
    for (const part of way.parts) places.set(part, multiply(motion, startOf(way, part)));
  }
  return places;
}

/** The gap that was looked for nearest to a share of the way; null: none was. */
export function gapAt(gaps: readonly Gap[], share: number): Gap | null {
  let best: Gap | null = null;
  for (const gap of gaps) if (!best || Math.abs(gap.share - share) < Math.abs(best.share - share)) best = gap;
  return best;
}

/** The tightest place of a way; null: nothing came near. */
export function tightest(gaps: readonly Gap[]): Gap | null {
  let best: Gap | null = null;
  for (const gap of gaps) if (gap.gap !== null && (best === null || gap.gap < (best.gap ?? 0))) best = gap;
  return best;
}
