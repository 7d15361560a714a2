import type { Vec3 } from "./vectors";

/** A measure as it is drawn: 1 point, 2 points of a line, or 3 of an angle with its corner in the middle. */
export interface MeasureMark {
  id: string | number;
  points: Vec3[];
  text: string;
  isSelected: boolean;
}

/** What is drawn besides the shapes. World metres, newtons. A figure's text is the page's: it knows the unit chosen. */
export interface Marks {
  /** (p, 8): point 3, normal 3, gap, share of the force in N. */
  planes: Float32Array | null;
  /** The force on the hand, N, and where it acts. */
  force: { at: Vec3; vector: Vec3; text: string } | null;
  /** (c, 7): distance, point on the tool 3, point on the mock-up 3. One text a row. */
  clearances: { rows: Float32Array; texts: string[] } | null;
  distance: { from: Vec3; to: Vec3; text: string } | null;
  measures: MeasureMark[];
  snap: { point: Vec3; type: "vertex" | "edge" | "face" } | null;
}
