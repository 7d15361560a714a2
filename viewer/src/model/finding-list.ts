// The findings of a clash check by columns, as they came, and one of them as an object. Pure.

import { decodeBinary } from "../link/frames";
import type { FindingRows, FindingStatus, FindingWords } from "../link/protocol";
import type { Vec3 } from "../math/vectors";

export const STATUSES: readonly FindingStatus[] = ["new", "active", "reviewed", "approved", "resolved"];
export const SEVERITIES = ["critical", "major", "minor"] as const;
export type Severity = (typeof SEVERITIES)[number];
/** Kinds of depth; "": not stated. Of a bound, the depth is at most that. */
export const KINDS = ["", "measured", "estimate", "bound", "exact"] as const;
export type Kind = (typeof KINDS)[number];

const NO_PART = 0xffffffff;
const SIZES = 4;
const PLACES = 9;

/** One finding. Metres; what is not known is null. */
export interface Finding {
  readonly row: number;
  readonly id: string;
  readonly path_a: string;
  readonly path_b: string;
  /** Null: the part is not in this mock-up, or was left out. */
  readonly part_a: number | null;
  readonly part_b: number | null;
  readonly verdict: string;
  readonly rule: string;
  readonly severity: Severity;
  readonly kind: Kind;
  readonly depth: number | null;
  readonly depth_error: number | null;
  readonly gap: number | null;
  readonly volume: number | null;
  readonly point_a: Vec3 | null;
  readonly point_b: Vec3 | null;
  /** Moves the first part out of the second. */
  readonly translation: Vec3 | null;
  readonly is_touching: boolean;
}

export class FindingList {
  readonly version: string;
  readonly ids: readonly string[];
  readonly paths: readonly string[];
  readonly verdicts: readonly string[];
  readonly rules: readonly string[];
  readonly groups: readonly string[];
  private readonly row_of: ReadonlyMap<string, number>;
  private readonly notes: Readonly<Record<string, string>>;

  constructor(private readonly rows: FindingRows) {
    const words = JSON.parse(new TextDecoder().decode(rows.words)) as FindingWords;
    this.version = rows.version;
    this.ids = words.ids;
    this.paths = words.paths;
    this.verdicts = words.verdicts;
    this.rules = words.rules;
    this.groups = words.groups;
    this.notes = words.notes;
    this.row_of = new Map(words.ids.map((id, row) => [id, row]));
  }

  /** The list in a frame of the server. Throws `FrameError`. */
  static decoded(frame: ArrayBuffer): FindingList {
    return new FindingList(decodeBinary(frame) as unknown as FindingRows);
  }

  get count(): number {
    return this.ids.length;
  }

  /** The row of an id; -1: there is none. */
  rowOf(id: string | null): number {
    return id === null ? -1 : (this.row_of.get(id) ?? -1);
  }

  verdictOf(row: number): number {
    return this.rows.labels[3 * row] ?? 0;
  }

  ruleOf(row: number): number {
    return this.rows.labels[3 * row + 1] ?? 0;
  }

  groupOf(row: number): number {
    return this.rows.labels[3 * row + 2] ?? 0;
  }

  /** The paths of both parts, as indices. */
  pathsOf(row: number): readonly [number, number] {
    return [this.rows.pairs[2 * row] ?? 0, this.rows.pairs[2 * row + 1] ?? 0];
  }

  /** The part of a path by its index; null: it is not here. */
  partOf(path: number): number | null {
    const part = this.rows.part_of_path[path] ?? NO_PART;
    return part === NO_PART ? null : part;
  }

  severityOf(row: number): number {
    return this.rows.codes[4 * row] ?? 1;
  }

  /** The status that the finding came with, as an index. */
  statusOf(row: number): number {
    return this.rows.codes[4 * row + 1] ?? 0;
  }

  noteOf(row: number): string {
    return this.notes[this.ids[row] ?? ""] ?? "";
  }

  isTouching(row: number): boolean {
    return this.rows.codes[4 * row + 3] === 1;
  }

  finding(row: number): Finding {
    const { rows } = this;
    const [a, b] = this.pathsOf(row);
    const place = (from: number): Vec3 | null => {
      const at = PLACES * row + from;
      const point: Vec3 = [rows.places[at] ?? NaN, rows.places[at + 1] ?? NaN, rows.places[at + 2] ?? NaN];
      return point.every(Number.isFinite) ? point : null;
    };
    const size = (column: number): number | null => {
      const value = rows.sizes[SIZES * row + column] ?? NaN;
      return Number.isFinite(value) ? value : null;
    };
    return {
      row,
      id: this.ids[row] ?? "",
      path_a: this.paths[a] ?? "",
      path_b: this.paths[b] ?? "",
      part_a: this.partOf(a),
      part_b: this.partOf(b),
      verdict: this.verdicts[this.verdictOf(row)] ?? "",
      rule: this.rules[this.ruleOf(row)] ?? "",
      severity: SEVERITIES[this.severityOf(row)] ?? "major",
      kind: KINDS[rows.codes[4 * row + 2] ?? 0] ?? "",
      depth: size(0),
      depth_error: size(1),
      gap: size(2),
      volume: size(3),
      point_a: place(0),
      point_b: place(3),
      translation: place(6),
      is_touching: this.isTouching(row),
    };
  }
}
