// Marks: contact planes, forces, clearances, measures, the snap marker, and their labels.

import { type IUniform, Scene } from "three";
import { add, cross, distance, length, normalize, perpendicular, scale, type Vec3 } from "../math/vectors";
import type { CameraRig } from "./camera";
import type { Anchor } from "./labels";
import { Discs, Lines, type Tint } from "./strokes";
import { channels } from "./theme";

/** A measure as it is drawn: 1 point, 2 points of a line, or 3 of an angle with its corner in the middle. */
export interface MeasureMark {
  id: string | number;
  points: Vec3[];
  text: string;
  isSelected: boolean;
}

/** The marks. World metres, newtons. The page makes the text of labels, because it knows the chosen unit. */
export interface Marks {
  /** (p, 8): point 3, normal 3, gap, share of the force in N. */
  planes: Float32Array | null;
  /** The force on the hand, N, and where it acts. */
  force: { at: Vec3; vector: Vec3; text: string } | null;
  /** (c, 7): distance, point on the tool 3, point on the mock-up 3. One text a row. */
  clearances: { rows: Float32Array; texts: string[] } | null;
  distance: { from: Vec3; to: Vec3; text: string } | null;
  /** What is touched, at a point of the contact. */
  touches: { at: Vec3; text: string }[];
  /** From the tool to the hand that contact holds back. */
  band: { from: Vec3; to: Vec3; text: string } | null;
  /** What is being typed, at the hand. */
  typed: { at: Vec3; text: string } | null;
  measures: MeasureMark[];
  snap: { point: Vec3; type: "vertex" | "edge" | "face" } | null;
  /** A way: its path, where it is tightest now, and the free swing of a tool about a fastener. */
  way: {
    path: Vec3[];
    gap: { point: Vec3; text: string } | null;
    fan: { centre: Vec3; rim: Vec3[]; isGood: boolean } | null;
  } | null;
  /** A finding that is looked at: the points of both parts, and the way that separates them. */
  finding: {
    points: readonly Vec3[];
    arrow: readonly [Vec3, Vec3] | null;
    text: string;
    /** How long the way is. */
    arrow_text: string;
  } | null;
  /** Where other people point, or (`isTool`) the tool that one of them moves. `colour`: 0xRRGGBB, of that number. */
  people: { id: number; at: Vec3; name: string; colour: number; number: number; isTool: boolean }[];
}

export const NO_MARKS: Marks = {
  planes: null,
  force: null,
  clearances: null,
  distance: null,
  touches: [],
  band: null,
  typed: null,
  measures: [],
  snap: null,
  way: null,
  finding: null,
  people: [],
};

// Orange for contacts, blue for near parts, yellow for measures: distinct without seeing red.
const HIT: Tint = [1.0, 0.58, 0.12, 0.95];
const NEAR: Tint = [0.33, 0.66, 1.0, 0.95];
const MEASURE: Tint = [0.98, 0.86, 0.35, 0.95];
const CHOSEN: Tint = [1.0, 1.0, 1.0, 1.0];
const WAY: Tint = [0.25, 0.85, 0.8, 0.9];
const SWING: Tint = [0.45, 0.85, 0.4, 0.9];
// Red, as in the pictures of reports: no other mark is.
const FINDING: Tint = [0.95, 0.2, 0.2, 0.95];
const SNAP: Tint = [1.0, 1.0, 1.0, 0.95];

// Sizes in CSS pixels: marks are as large from afar as from near.
const DISC_RADIUS = 16;
const LEAST_ARROW = 18;
const LONGEST_ARROW = 90;
const HEAD = 11;
const SNAP_RADIUS = 7;
const PERSON_RADIUS = 10;
// An arrow of this force is half of the longest: the eye tells 1 N from 5 N, and 50 N still fits.
const HALF_FORCE_N = 8;
const ARC_STEPS = 24;
const DASH = 12;
const MOST_DASHES = 80;
const BAND_SHARES = [0.5, 0.25, 0.75, 0.1, 0.9, 0, 1];

/** The length of a force's arrow, CSS pixels: grows with the force, and never beyond the longest. */
export function arrowLength(force: number): number {
  return LEAST_ARROW + (LONGEST_ARROW - LEAST_ARROW) * (force / (force + HALF_FORCE_N));
}

/** The arc of the angle at `corner` from `a` to `b`, `radius` metres away: points in order. Empty where a leg has no length. */
export function arc(a: Vec3, corner: Vec3, b: Vec3, radius: number): Vec3[] {
  const first = normalize(add(a, scale(corner, -1)));
  const second = normalize(add(b, scale(corner, -1)));
  const normal = normalize(cross(first, second), perpendicular(first));
  if (length(first) === 0 || length(second) === 0) return [];
  const across = cross(normal, first);
  const angle = Math.atan2(
    length(cross(first, second)),
    first[0] * second[0] + first[1] * second[1] + first[2] * second[2],
  );
  return Array.from({ length: ARC_STEPS + 1 }, (_, k) => {
    const turn = (angle * k) / ARC_STEPS;
    return add(corner, add(scale(first, radius * Math.cos(turn)), scale(across, radius * Math.sin(turn))));
  });
}

export class MarkLayer {
  readonly scene = new Scene();
  anchors: Anchor[] = [];
  readonly #lines: Lines;
  readonly #discs: Discs;
  #marks: Marks = NO_MARKS;

  constructor(uniforms: Record<string, IUniform>, middle: Vec3) {
    this.#lines = new Lines(uniforms, middle, 0.4);
    this.#discs = new Discs(uniforms, middle, 0.4);
    this.scene.add(this.#discs.mesh, this.#lines.mesh);
  }

  get isEmpty(): boolean {
    return !this.#lines.mesh.visible && !this.#discs.mesh.visible;
  }

  set(marks: Marks): void {
    this.#marks = marks;
  }

  /** Builds the strokes for the camera: sizes in pixels become metres at each mark's depth. */
  build(camera: CameraRig): void {
    const {
      planes,
      force,
      clearances,
      distance: nearest,
      touches,
      band,
      typed,
      measures,
      snap,
      way,
      finding,
      people,
    } = this.#marks;
    this.#lines.clear();
    this.#discs.clear();
    this.anchors = [];
    const pixel = (at: Vec3) => camera.metresPerPixel(Math.max(camera.project(at).depth, 1e-6));
    if (planes) this.#addPlanes(planes, pixel);
    if (clearances) {
      for (let row = 0; row < clearances.texts.length; row++) {
        const [from, to] = [vec(clearances.rows, 7 * row + 1), vec(clearances.rows, 7 * row + 4)];
        this.#addSpan(from, to, NEAR, 1.4, clearances.texts[row] as string, `clearance ${row}`, "near", 2 - row / 100);
      }
    }
    if (nearest) this.#addSpan(nearest.from, nearest.to, NEAR, 2.2, nearest.text, "distance", "near", 3);
    if (force && length(force.vector) > 0) {
      const size = length(force.vector);
      const tip = add(force.at, scale(force.vector, (arrowLength(size) * pixel(force.at)) / size));
      this.#lines.addArrow(force.at, tip, HEAD * pixel(force.at), HIT, 3);
      this.anchors.push({ key: "force", point: tip, text: force.text, kind: "hit", rank: 4 });
    }
    touches.forEach(({ at, text }, k) => {
      this.anchors.push({ key: `touch ${k}`, point: at, text, kind: "hit", rank: 5 });
    });
    if (band) this.#addBand(band, camera, pixel);
    if (typed) this.anchors.push({ key: "typed", point: typed.at, text: typed.text, kind: "hand", rank: 8 });
    for (const measure of measures) this.#addMeasure(measure, pixel);
    if (way) this.#addWay(way, pixel);
    if (finding) this.#addFinding(finding, camera, pixel);
    for (const person of people) this.#addPerson(person, camera, pixel(person.at));
    if (snap) this.#addSnap(snap.point, snap.type, camera, pixel(snap.point));
    this.#lines.commit();
    this.#discs.commit();
  }

  setSections(count: number): void {
    this.#lines.setSections(count);
    this.#discs.setSections(count);
  }

  dispose(): void {
    this.#lines.dispose();
    this.#discs.dispose();
  }

  #addPlanes(planes: Float32Array, pixel: (at: Vec3) => number): void {
    for (let at = 0; at + 8 <= planes.length; at += 8) {
      const point = vec(planes, at);
      const normal = normalize(vec(planes, at + 3), [0, 0, 1]);
      const share = planes[at + 7] as number;
      const across = perpendicular(normal);
      const radius = DISC_RADIUS * pixel(point);
      const tint = share > 0 ? HIT : NEAR;
      this.#discs.add(point, scale(across, radius), scale(cross(normal, across), radius), tint, 0);
      if (share <= 0) continue;
      const tip = add(point, scale(normal, arrowLength(share) * 0.8 * pixel(point)));
      this.#lines.addArrow(point, tip, 0.7 * HEAD * pixel(point), HIT, 2);
    }
  }

  #addSpan(
    from: Vec3,
    to: Vec3,
    tint: Tint,
    width: number,
    text: string,
    key: string,
    kind: Anchor["kind"],
    rank: number,
  ): void {
    this.#lines.add(from, to, tint, width);
    for (const end of [from, to]) this.#lines.add(end, end, tint, 3.2 * width);
    this.anchors.push({ key, point: scale(add(from, to), 0.5), text, kind, rank });
  }

  /** A dashed band, taut in its middle. */
  #addBand(
    { from, to, text }: { from: Vec3; to: Vec3; text: string },
    camera: CameraRig,
    pixel: (at: Vec3) => number,
  ): void {
    const middle = scale(add(from, to), 0.5);
    const dashes = Math.max(1, Math.min(MOST_DASHES, Math.round(distance(from, to) / pixel(middle) / DASH)));
    const at = (share: number) => add(scale(from, 1 - share), scale(to, share));
    const width = (share: number) => 4.5 - 3 * Math.sin(Math.PI * share);
    for (let k = 0; k < dashes; k++) {
      const [start, end] = [k / dashes, (k + 0.55) / dashes];
      this.#lines.add(at(start), at(end), HIT, width(start), width(end));
    }
    for (const end of [from, to]) this.#lines.add(end, end, HIT, 9);
    // Its figure is told as long as some of it is in the picture.
    const isSeen = (point: Vec3) => {
      const { x, y, isAhead } = camera.project(point);
      return isAhead && x > 0 && y > 0 && x < camera.width && y < camera.height;
    };
    const point = BAND_SHARES.map(at).find(isSeen) ?? middle;
    this.anchors.push({ key: "band", point, text, kind: "hit", rank: 6 });
  }

  #addMeasure(measure: MeasureMark, pixel: (at: Vec3) => number): void {
    const tint = measure.isSelected ? CHOSEN : MEASURE;
    const { points } = measure;
    for (let k = 0; k < points.length; k++) {
      const point = points[k] as Vec3;
      this.#lines.add(point, point, tint, 7);
      if (k > 0) this.#lines.add(points[k - 1] as Vec3, point, tint, 2);
    }
    let label = points.reduce((sum, p) => add(sum, scale(p, 1 / points.length)), [0, 0, 0] as Vec3);
    if (points.length === 3) {
      const [a, corner, b] = points as [Vec3, Vec3, Vec3];
      const radius = Math.min(40 * pixel(corner), 0.6 * Math.min(distance(a, corner), distance(b, corner)));
      const bow = arc(a, corner, b, radius);
      for (let k = 1; k < bow.length; k++) this.#lines.add(bow[k - 1] as Vec3, bow[k] as Vec3, tint, 2);
      label = bow[bow.length >> 1] ?? corner;
    }
    const rank = measure.isSelected ? 5 : 2;
    if (points.length > 0)
      this.anchors.push({ key: `measure ${measure.id}`, point: label, text: measure.text, kind: "measure", rank });
  }

  #addWay({ path, gap, fan }: NonNullable<Marks["way"]>, pixel: (at: Vec3) => number): void {
    for (let k = 1; k < path.length; k++) this.#lines.add(path[k - 1] as Vec3, path[k] as Vec3, WAY, 2);
    const [before, end] = [path.at(-2), path.at(-1)];
    if (before && end && distance(before, end) > 0) this.#lines.addArrow(before, end, HEAD * pixel(end), WAY, 2);
    if (gap) {
      this.#lines.add(gap.point, gap.point, NEAR, 7);
      this.anchors.push({ key: "way gap", point: gap.point, text: gap.text, kind: "near", rank: 5 });
    }
    if (!fan) return;
    const tint = fan.isGood ? SWING : HIT;
    for (let k = 1; k < fan.rim.length; k++) this.#lines.add(fan.rim[k - 1] as Vec3, fan.rim[k] as Vec3, tint, 3);
    for (const end of [fan.rim[0], fan.rim.at(-1)]) if (end) this.#lines.add(fan.centre, end, tint, 1.5);
  }

  /** A ring around each point, a line between them, and the arrow, as long as the way is, or long enough to be seen. */
  #addFinding(finding: NonNullable<Marks["finding"]>, camera: CameraRig, pixel: (at: Vec3) => number): void {
    const { points, arrow, text, arrow_text } = finding;
    for (const point of points) {
      const radius = SNAP_RADIUS * pixel(point);
      this.#discs.add(point, scale(camera.right, radius), scale(camera.top, radius), FINDING, 0.65);
      this.#lines.add(point, point, FINDING, 4);
    }
    const [one, other] = points;
    if (one && other) this.#lines.add(one, other, FINDING, 1.6);
    if (arrow) {
      const [from, to] = arrow;
      const way = add(to, scale(from, -1));
      const size = length(way);
      const tip = add(from, scale(way, Math.max(size, LEAST_ARROW * pixel(from)) / size));
      this.#lines.addArrow(from, tip, HEAD * pixel(from), FINDING, 2.6);
      this.anchors.push({ key: "finding way", point: tip, text: arrow_text, kind: "hit", rank: 5 });
    }
    if (one && text !== "") this.anchors.push({ key: "finding", point: one, text, kind: "hit", rank: 6 });
  }

  /** A dot in a ring, with a name. */
  #addPerson(person: Marks["people"][number], camera: CameraRig, pixel: number): void {
    const { id, at, name, colour, number, isTool } = person;
    const tint: Tint = [...channels(colour), 1];
    if (!isTool) {
      const radius = PERSON_RADIUS * pixel;
      this.#discs.add(at, scale(camera.right, radius), scale(camera.top, radius), tint, 0.6);
      this.#lines.add(at, at, CHOSEN, 10);
      this.#lines.add(at, at, tint, 7);
    }
    this.anchors.push({ key: `person ${id} ${isTool}`, point: at, text: name, kind: `person-${number}`, rank: 7 });
  }

  /** A ring for a point of a face, a dot besides for an edge, a cross besides for a vertex; it faces the eye. */
  #addSnap(point: Vec3, type: "vertex" | "edge" | "face", camera: CameraRig, pixel: number): void {
    const [across, up] = [scale(camera.right, SNAP_RADIUS * pixel), scale(camera.top, SNAP_RADIUS * pixel)];
    this.#discs.add(point, across, up, SNAP, 0.7);
    if (type === "edge") this.#lines.add(point, point, SNAP, 4);
    if (type !== "vertex") return;
    for (const arm of [across, up])
      this.#lines.add(add(point, scale(arm, -1.6)), add(point, scale(arm, 1.6)), SNAP, 1.6);
  }
}

function vec(data: Float32Array, at: number): Vec3 {
  return [data[at] as number, data[at + 1] as number, data[at + 2] as number];
}
