// Films of ways: where parts are at a share of a way that was found. Pure.

import type { CardAnswer, Gap } from "../link/protocol";
import { carry, IDENTITY, multiply, orthonormal, type Pose } from "../math/matrix";
import { distance, type Vec3 } from "../math/vectors";

type Way = CardAnswer["ways"][number];

/** A film that is open: the ways of a card one after the other, and how far it is. */
export interface Film {
  readonly card: number;
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

/** A film some seconds later: on to the next way at the end of one; it stands at the end of the last. */
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

/** world_from_part of all parts that a film moves: those of earlier ways are at their ends. */
export function placesAt(
  film: Film,
  ways: readonly Way[],
  starts: Readonly<Record<string, Pose>>,
  pointsOf: (parts: readonly number[]) => Vec3[],
): Map<number, Pose> {
  const places = new Map<number, Pose>();
  for (const [k, way] of ways.slice(0, film.step + 1).entries()) {
    const share = k < film.step ? 1 : film.share;
    const poses = way.poses.map((pose) => [...pose]);
    const motion = motionAt(poses, share < 1 ? sharesOf(poses, pointsOf(way.parts)) : [], share);
    for (const part of way.parts) places.set(part, multiply(motion, starts[part] ?? IDENTITY));
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
