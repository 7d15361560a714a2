// Which findings are shown, in which order, and what is said of one. Pure.

import type { FindingStatus, Findings } from "../link/protocol";
import { formatLength, type Unit } from "../math/units";
import { type Finding, type FindingList, STATUSES } from "./finding-list";

export { type Finding, FindingList, STATUSES } from "./finding-list";

export type FindingOrder = "depth" | "part" | "status";
export type Grouping = "group" | "part" | "rule" | "verdict" | "none";

/** What the list shows. Empty texts and -1 show all. */
export interface FindingFilter {
  readonly query: string;
  readonly verdict: string;
  readonly status: string;
  /** A part of the mock-up. */
  readonly part: number;
  readonly order: FindingOrder;
  readonly grouping: Grouping;
}

export const ALL: FindingFilter = {
  query: "",
  verdict: "",
  status: "",
  part: -1,
  order: "depth",
  grouping: "group",
};

export interface FindingGroup {
  /** Unique, and the same as long as the group is. */
  readonly key: string;
  readonly name: string;
  readonly count: number;
  /** A group that somebody made. */
  readonly own: number;
}

/** The shown findings. */
export interface ShownFindings {
  readonly groups: readonly FindingGroup[];
  /** All shown rows, group by group. */
  readonly rows: Int32Array;
  /** The lines of the list: a row, or -1 less the index of a group; the rows of folded groups are left out. */
  readonly lines: Int32Array;
}

export const NONE_SHOWN: ShownFindings = { groups: [], rows: new Int32Array(0), lines: new Int32Array(0) };

/** The status of a row. */
export const statusOf = (list: FindingList, findings: Findings, row: number): FindingStatus =>
  findings.status[list.ids[row] ?? ""] ?? STATUSES[list.statusOf(row)] ?? "new";

/** The note to save, where somebody else may have written `now` since `own` was begun on `before`: both are kept. */
export function withOthers(own: string, before: string, now: string): string {
  if (own === before || now === own) return now;
  if (now === before || now === "") return own;
  return own === "" ? now : `${now}\n${own}`;
}

export const noteOf = (list: FindingList, findings: Findings, row: number): string =>
  findings.notes[list.ids[row] ?? ""] ?? list.noteOf(row);

/** The rows that the filter leaves, sorted and in groups. */
export function shownFindings(
  list: FindingList,
  findings: Findings,
  filter: FindingFilter,
  folded: ReadonlySet<string>,
): ShownFindings {
  const rows = sorted(list, findings, filter.order, left(list, findings, filter));
  const nameOf = namer(list, findings, filter.grouping);
  if (!nameOf) return { groups: [], rows, lines: rows };
  const by_key = new Map<string, { name: string; own: number; rows: number[] }>();
  for (const row of rows) {
    const { key, name, own } = nameOf(row);
    const group = by_key.get(key);
    if (group) group.rows.push(row);
    else by_key.set(key, { name, own, rows: [row] });
  }
  // Groups that people made come first, even empty ones.
  if (filter.grouping === "group") {
    for (const { id, name } of findings.own_groups) {
      const key = `own ${id}`;
      if (!by_key.has(key) && isOpen(filter)) by_key.set(key, { name, own: id, rows: [] });
    }
  }
  const found = [...by_key].sort(([, a], [, b]) => Number(b.own > 0) - Number(a.own > 0));
  const groups = found.map(([key, { name, own, rows: members }]) => ({ key, name, own, count: members.length }));
  const all = new Int32Array(rows.length);
  const lines = new Int32Array(rows.length + groups.length);
  let [at, line] = [0, 0];
  for (const [k, [key, { rows: members }]] of found.entries()) {
    lines[line++] = -1 - k;
    all.set(members, at);
    at += members.length;
    if (folded.has(key)) continue;
    lines.set(members, line);
    line += members.length;
  }
  return { groups, rows: all, lines: lines.subarray(0, line) };
}

/** Nothing is filtered. */
const isOpen = ({ query, verdict, status, part }: FindingFilter): boolean =>
  query.trim() === "" && verdict === "" && status === "" && part < 0;

function left(list: FindingList, findings: Findings, filter: FindingFilter): Int32Array {
  const words = filter.query.toLowerCase().split(/\s+/).filter(Boolean);
  const matches = words.map((word) => matcher(list, findings, word));
  const rows = new Int32Array(list.count);
  let count = 0;
  for (let row = 0; row < list.count; row++) {
    if (findings.is_touching_hidden && list.isTouching(row)) continue;
    if (filter.verdict !== "" && list.verdicts[list.verdictOf(row)] !== filter.verdict) continue;
    if (filter.status !== "" && statusOf(list, findings, row) !== filter.status) continue;
    if (filter.part >= 0 && !list.pathsOf(row).some((path) => list.partOf(path) === filter.part)) continue;
    if (!matches.every((match) => match(row))) continue;
    rows[count++] = row;
  }
  return rows.subarray(0, count);
}

/** Whether a row has a word in its paths, verdict, rule, group, status or note. Each text is looked at once. */
function matcher(list: FindingList, findings: Findings, word: string): (row: number) => boolean {
  const has = (text: string): boolean => text.toLowerCase().includes(word);
  const [paths, verdicts, rules] = [list.paths.map(has), list.verdicts.map(has), list.rules.map(has)];
  const groups = list.groups.map(has);
  const own = new Set(findings.own_groups.filter(({ name }) => has(name)).map(({ id }) => id));
  const statuses = new Set<string>(STATUSES.filter(has));
  return (row) => {
    const [a, b] = list.pathsOf(row);
    if (paths[a] || paths[b] || verdicts[list.verdictOf(row)] || rules[list.ruleOf(row)]) return true;
    const member = findings.members[list.ids[row] ?? ""];
    if (member === undefined ? groups[list.groupOf(row)] : own.has(member)) return true;
    return statuses.has(statusOf(list, findings, row)) || has(noteOf(list, findings, row));
  };
}

/** Rows come the worst first; other orders keep that among equals. */
function sorted(list: FindingList, findings: Findings, order: FindingOrder, rows: Int32Array): Int32Array {
  if (order === "depth") return rows;
  if (order === "status") {
    const places = Uint8Array.from({ length: list.count }, (_, row) => STATUSES.indexOf(statusOf(list, findings, row)));
    return rows.slice().sort((a, b) => (places[a] ?? 0) - (places[b] ?? 0) || a - b);
  }
  const by_name = list.paths.map((_, path) => path).sort((a, b) => compare(list.paths[a] ?? "", list.paths[b] ?? ""));
  const places = new Uint32Array(list.paths.length);
  for (const [place, path] of by_name.entries()) places[path] = place;
  const placeOf = (row: number): number => Math.min(...list.pathsOf(row).map((path) => places[path] ?? 0));
  const of_rows = Float64Array.from({ length: list.count }, (_, row) => placeOf(row));
  return rows.slice().sort((a, b) => (of_rows[a] ?? 0) - (of_rows[b] ?? 0) || a - b);
}

const compare = (a: string, b: string): number => (a < b ? -1 : a > b ? 1 : 0);

type Name = { readonly key: string; readonly name: string; readonly own: number };

function namer(list: FindingList, findings: Findings, grouping: Grouping): ((row: number) => Name) | null {
  const plain = (key: string, name: string): Name => ({ key, name, own: 0 });
  switch (grouping) {
    case "none":
      return null;
    case "part":
      return (row) => {
        const name = list.paths[list.pathsOf(row)[0]] ?? "";
        return plain(`part ${name}`, name);
      };
    case "rule":
      return (row) => {
        const name = list.rules[list.ruleOf(row)] ?? "";
        return plain(`rule ${name}`, ruleText(name) || "no rule");
      };
    case "verdict":
      return (row) => {
        const name = list.verdicts[list.verdictOf(row)] ?? "";
        return plain(`verdict ${name}`, name);
      };
    case "group": {
      const names = new Map(findings.own_groups.map(({ id, name }) => [id, name]));
      return (row) => {
        const own = findings.members[list.ids[row] ?? ""];
        if (own !== undefined) return { key: `own ${own}`, name: names.get(own) ?? "", own };
        const name = list.groups[list.groupOf(row)] ?? "";
        return plain(`group ${name}`, name);
      };
    }
  }
}

/** The two parts, as far as this mock-up has them. */
export const partsOf = (finding: Finding): number[] => [finding.part_a, finding.part_b].filter((part) => part !== null);

/** The row `step` further on, cyclically; -1 if there is none. */
export function neighbour(rows: Int32Array, current: number, step: 1 | -1): number {
  if (rows.length === 0) return -1;
  const at = rows.indexOf(current);
  if (at < 0) return rows.at(step > 0 ? 0 : -1) ?? -1;
  return rows[(at + step + rows.length) % rows.length] ?? -1;
}

/** The line of a row in the list; -1: it is folded away, or filtered. */
export const lineOf = (shown: ShownFindings, row: number): number => shown.lines.indexOf(row);

const lastStep = (path: string): string => path.split("/").at(-1) || "a part";
/** The rule of pairs that no rule names says nothing. */
const ruleText = (rule: string): string => (rule === "default" ? "" : rule);

/** A depth is told as one figure if its error is less than this share of it. */
const DEPTH_SHARE = 2e-3;

/** "at most 2 mm", "about 2 mm", "2 mm to 3 mm": as sure as the depth is. */
export function depthText(finding: Finding, unit: Unit): string {
  const { depth, depth_error, kind } = finding;
  if (!depth) return "";
  const least = formatLength(depth, unit);
  if (kind === "bound") return `at most ${least}`;
  const most = depth_error === null ? least : formatLength(depth + depth_error, unit);
  const range = most !== least && (depth_error ?? 0) > DEPTH_SHARE * depth ? `${least} to ${most}` : least;
  return kind === "estimate" ? `about ${range}` : range;
}

/** "out by 3 mm" where that is the depth itself, else "out by at most 3 mm": a shorter way may exist. */
export function wayText({ translation, depth, kind }: Finding, unit: Unit): string {
  if (!translation) return "";
  const long = Math.hypot(...translation);
  const is_shortest =
    depth !== null && kind !== "bound" && kind !== "estimate" && Math.abs(long - depth) <= DEPTH_SHARE * depth;
  return `out by ${is_shortest ? "" : "at most "}${formatLength(long, unit)}`;
}

/** Contacts that overlap less than this, in metres, touch: flush faces do so by rounding. */
const TOUCHING_M = 1e-6;

/** Whether the parts overlap by more than rounding, but at most by the `contact` of their rule. */
const isAllowed = ({ verdict, depth }: Finding): boolean => verdict === "contact" && (depth ?? 0) > TOUCHING_M;

/** How the first part lies to the second: "is 2 mm deep in", "touches". */
export function relation(finding: Finding, unit: Unit): string {
  const { verdict, gap } = finding;
  if (verdict === "duplicate") return "has the same surface as";
  if (verdict === "contained") return "and one inside the other:";
  if (isAllowed(finding)) return `is ${depthText(finding, unit)} deep (allowed) in`;
  if (finding.is_touching) return gap !== null && gap > 0 ? `is ${formatLength(gap, unit)} from` : "touches";
  const depth = depthText(finding, unit);
  if (depth !== "") return `is ${depth} deep in`;
  if (gap !== null && gap > 0) return `is ${formatLength(gap, unit)} from`;
  return "collides with";
}

export const nameA = (finding: Finding): string => lastStep(finding.path_a);
export const nameB = (finding: Finding): string => lastStep(finding.path_b);

/** "shaft is at most 2 mm deep in housing". */
export function sentence(finding: Finding, unit: Unit): string {
  const [a, b] = [nameA(finding), nameB(finding)];
  if (finding.verdict === "contained") {
    const way = finding.translation;
    const out = way ? `, ${formatLength(Math.hypot(...way), unit)} from coming out` : "";
    return `Of ${a} and ${b}, one is inside the other${out}`;
  }
  return `${a} ${relation(finding, unit)} ${b}`;
}

/** What the sentence does not say: "critical · rule fits". */
export function factsText(finding: Finding): string {
  const rule = ruleText(finding.rule);
  return [finding.severity === "major" ? "" : finding.severity, finding.verdict, rule === "" ? "" : `rule ${rule}`]
    .filter(Boolean)
    .join(" · ");
}
