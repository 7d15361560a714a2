// Replays the sequence in a page without a server: the places of a line's parts along its recorded way.

import type { Document, SequenceLine } from "../link/protocol";
import { IDENTITY, invert, multiply, orthonormal, type Pose, position } from "../math/matrix";
import { distance } from "../math/vectors";
import type { Store } from "./store";

const M_PER_S = 0.25;
const LEAST_S = 1;
const MOST_S = 20;

/** Where the parts of a line were when it began: where the lines before it left them, else where they were loaded. */
export function startsOf(sequence: readonly SequenceLine[], line: SequenceLine): Map<number, Pose> {
  const places = new Map<number, Pose>();
  for (const each of sequence) {
    if (each.id === line.id) break;
    const end = each.way.at(-1);
    if (end) for (const part of each.parts) places.set(part, carriedTo(each, end, places.get(part)));
  }
  return new Map(line.parts.map((part) => [part, places.get(part) ?? [...IDENTITY]]));
}

/** world_from_part of a part that began at `start`, when the hand is at `pose`. */
function carriedTo(line: SequenceLine, pose: Pose, start: Pose = [...IDENTITY]): Pose {
  const first = line.way[0] ?? IDENTITY;
  return multiply(multiply(pose, invert(first)), start);
}

/** How long a line takes, at an even speed. */
export function secondsOf(line: SequenceLine): number {
  return Math.min(MOST_S, Math.max(LEAST_S, lengthsOf(line).reduce((sum, each) => sum + each, 0) / M_PER_S));
}

/** The hand's pose at a share of the way, by its length. */
export function poseAt(line: SequenceLine, share: number): Pose {
  const lengths = lengthsOf(line);
  let rest = share * lengths.reduce((sum, each) => sum + each, 0);
  for (const [k, length] of lengths.entries()) {
    const [from, to] = [line.way[k], line.way[k + 1]];
    if (!from || !to) break;
    if (rest <= length && length > 0) {
      const part = rest / length;
      return orthonormal(from.map((value, i) => value + part * ((to[i] ?? 0) - value)));
    }
    rest -= length;
  }
  return [...(line.way.at(-1) ?? IDENTITY)];
}

const lengthsOf = (line: SequenceLine): number[] =>
  line.way.slice(1).map((pose, k) => distance(position(pose), position(line.way[k] ?? pose)));

/** The document with the parts of a line at a share of its way. */
export function replayed(document: Document, line: SequenceLine, starts: Map<number, Pose>, share: number): Document {
  const pose = poseAt(line, share);
  const moved = { ...document.moved };
  for (const [part, start] of starts) moved[part] = carriedTo(line, pose, start);
  return { ...document, moved };
}

/** Moves the parts while the document replays a line. */
export class OfflineReplay {
  private line: SequenceLine | null = null;
  private starts = new Map<number, Pose>();
  private begun_ms = 0;

  constructor(private readonly store: Store) {}

  /** Once a frame; whether another is wanted. */
  frame(now_ms: number): boolean {
    const document = this.store.document.peek();
    const line = document?.sequence.find((each) => each.id === document.replaying) ?? null;
    if (!document || !line) {
      this.line = null;
      return false;
    }
    if (line !== this.line) {
      this.line = line;
      this.starts = startsOf(document.sequence, line);
      this.begun_ms = now_ms;
    }
    const share = Math.min(1, (now_ms - this.begun_ms) / 1000 / secondsOf(line));
    const next = replayed(document, line, this.starts, share);
    this.store.document.value = share < 1 ? next : { ...next, replaying: null };
    return true;
  }
}
