// Findings: which are shown, in which order and groups, and what is said of them.

import assert from "node:assert/strict";
import test from "node:test";
import { signal } from "@preact/signals";
import { findingTints, partStates } from "../src/app/part-states";
import type { FindingRows, Findings } from "../src/link/protocol";
import { FindingState } from "../src/model/finding-state";
import {
  ALL,
  type FindingFilter,
  FindingList,
  neighbour,
  type ShownFindings,
  sentence,
  shownFindings,
  wayText,
  withOthers,
} from "../src/model/findings";

interface Given {
  a?: string;
  b?: string;
  verdict?: string;
  rule?: string;
  group?: string;
  severity?: number;
  status?: number;
  kind?: number;
  depth?: number;
  error?: number;
  gap?: number;
  translation?: [number, number, number];
}

function listOf(given: Record<string, Given>, notes: Record<string, string> = {}): FindingList {
  const words = { paths: [] as string[], verdicts: [] as string[], rules: [] as string[], groups: [] as string[] };
  const numberOf = (list: string[], word: string): number => {
    if (!list.includes(word)) list.push(word);
    return list.indexOf(word);
  };
  const rows = Object.values(given);
  const pairs = rows.flatMap(({ a = "x/a", b = "x/b" }) => [numberOf(words.paths, a), numberOf(words.paths, b)]);
  const labels = rows.flatMap(({ verdict = "clash", rule = "default", group = "g" }) => [
    numberOf(words.verdicts, verdict),
    numberOf(words.rules, rule),
    numberOf(words.groups, group),
  ]);
  const codes = rows.flatMap(({ severity = 1, status = 0, kind = 1, verdict }) => [
    severity,
    status,
    kind,
    verdict === "contact" ? 1 : 0,
  ]);
  const sizes = rows.flatMap(({ depth = NaN, error = NaN, gap = NaN }) => [depth, error, gap, NaN]);
  const places = rows.flatMap(({ translation = [NaN, NaN, NaN] }) => [1, 2, 3, NaN, NaN, NaN, ...translation]);
  return new FindingList({
    kind: "findings",
    version: "v",
    words: new TextEncoder().encode(JSON.stringify({ ...words, ids: Object.keys(given), notes })),
    part_of_path: Uint32Array.from(words.paths, (path, part) => (path === "nowhere" ? 0xffffffff : part)),
    pairs: Uint32Array.from(pairs),
    labels: Uint32Array.from(labels),
    codes: Uint8Array.from(codes),
    sizes: Float32Array.from(sizes),
    places: Float32Array.from(places),
  } satisfies FindingRows);
}

const FACTS: Findings = {
  version: "v",
  count: 5,
  counts: {},
  hidden: {},
  status: { p1: "approved" },
  notes: {},
  own_groups: [],
  members: {},
  is_touching_hidden: true,
  check: null,
  stale: {},
};
const LIST = listOf(
  {
    b1: { a: "engine/bracket_2", depth: 0.009, group: "brackets" },
    p2: { a: "engine/pump", depth: 0.004, group: "pumps", status: 1 },
    p1: { a: "engine/pump", b: "nowhere", depth: 0.001, group: "pumps", rule: "fits" },
    b2: { a: "engine/bracket_1", verdict: "contact", group: "brackets" },
    s1: { a: "engine/seat", verdict: "contact", group: "seats" },
  },
  { b1: "ask ada" },
);

const shown = (filter: Partial<FindingFilter> = {}, facts: Partial<Findings> = {}, folded: string[] = []) =>
  shownFindings(LIST, { ...FACTS, ...facts }, { ...ALL, ...filter }, new Set(folded));
const ids = ({ rows }: ShownFindings): string[] => [...rows].map((row) => LIST.ids[row] ?? "");
const names = ({ groups }: ShownFindings): string[] => groups.map(({ name, count }) => `${name} ${count}`);

test("findings stand worst first, what only touches is hidden until it is asked for", () => {
  assert.deepEqual(ids(shown()), ["b1", "p2", "p1"]);
  assert.deepEqual(names(shown()), ["brackets 1", "pumps 2"]);
  assert.deepEqual(ids(shown({}, { is_touching_hidden: false })), ["b1", "b2", "p2", "p1", "s1"]);
  assert.deepEqual(names(shown({ grouping: "verdict" }, { is_touching_hidden: false })), ["clash 3", "contact 2"]);
});

test("words, verdict, status, part and notes filter", () => {
  assert.deepEqual(ids(shown({ query: "approved pump" })), ["p1"]);
  assert.deepEqual(ids(shown({ query: "FITS" })), ["p1"]);
  assert.deepEqual(ids(shown({ query: "ada" })), ["b1"]);
  assert.deepEqual(ids(shown({ query: "ada" }, { notes: { b1: "" } })), [], "the note was taken away");
  assert.deepEqual(ids(shown({ status: "active" })), ["p2"]);
  assert.deepEqual(ids(shown({ verdict: "contact" }, { is_touching_hidden: false })), ["b2", "s1"]);
  assert.deepEqual(ids(shown({ part: LIST.paths.indexOf("engine/pump") })), ["p2", "p1"]);
});

test("other orders keep the worst first among equals", () => {
  assert.deepEqual(ids(shown({ order: "part", grouping: "none" }, { is_touching_hidden: false })), [
    "b2",
    "b1",
    "p2",
    "p1",
    "s1",
  ]);
  assert.deepEqual(ids(shown({ order: "status", grouping: "none" })), ["b1", "p2", "p1"]);
});

test("groups fold, and stay in the steps of N and P", () => {
  const open = shown();
  assert.deepEqual([...open.lines], [-1, 0, -2, 1, 2]);
  const folded = shown({}, {}, [open.groups[0]?.key ?? ""]);
  assert.deepEqual([...folded.lines], [-1, -2, 1, 2]);
  assert.deepEqual(ids(folded), ["b1", "p2", "p1"]);
});

test("groups of ours come first, also empty ones", () => {
  const facts = {
    own_groups: [
      { id: 7, name: "for ada" },
      { id: 8, name: "later" },
    ],
    members: { p1: 7 },
  };
  assert.deepEqual(names(shown({}, facts)), ["for ada 1", "later 0", "brackets 1", "pumps 1"]);
  assert.deepEqual(ids(shown({ query: "for" }, facts)), ["p1"]);
  assert.deepEqual(names(shown({ query: "for" }, facts)), ["for ada 1"]);
});

test("next and previous go round, and begin at an end", () => {
  const { rows } = shown();
  const step = (from: string | null, by: 1 | -1) => LIST.ids[neighbour(rows, LIST.rowOf(from), by)];
  assert.equal(step(null, 1), "b1");
  assert.equal(step(null, -1), "p1");
  assert.equal(step("b1", 1), "p2");
  assert.equal(step("p1", 1), "b1");
  assert.equal(step("b1", -1), "p1");
  assert.equal(neighbour(new Int32Array(0), 0, 1), -1);
});

test("a sentence is as sure as its figure", () => {
  const said = (given: Given) => sentence(listOf({ one: { a: "m/shaft", b: "m/housing", ...given } }).finding(0), "mm");
  assert.equal(said({ depth: 0.0733, error: 0 }), "shaft is 73.3 mm deep in housing");
  assert.equal(said({ depth: 0.0733, kind: 3 }), "shaft is at most 73.3 mm deep in housing");
  assert.equal(said({ depth: 0.002, kind: 2 }), "shaft is about 2 mm deep in housing");
  assert.equal(said({ depth: 0.002, error: 0.001 }), "shaft is 2 mm to 3 mm deep in housing");
  assert.equal(said({ gap: 0.0005, verdict: "clearance" }), "shaft is 0.5 mm from housing");
  assert.equal(said({ gap: 0, verdict: "contact" }), "shaft touches housing");
  assert.equal(said({ depth: 1e-7, error: 0, verdict: "contact" }), "shaft touches housing");
  assert.equal(said({ depth: 1e-4, error: 0, verdict: "contact" }), "shaft is 0.1 mm deep (allowed) in housing");
  assert.equal(said({ verdict: "duplicate" }), "shaft has the same surface as housing");
  assert.equal(said({}), "shaft collides with housing");
  assert.equal(
    said({ verdict: "contained", translation: [0, 0, 0.03] }),
    "Of shaft and housing, one is inside the other, 30 mm from coming out",
  );
});

test("a note that somebody else changed meanwhile keeps both", () => {
  assert.equal(withOthers("mine", "", ""), "mine");
  assert.equal(withOthers("mine", "old", "old"), "mine");
  assert.equal(withOthers("", "old", "old"), "", "taken away");
  assert.equal(withOthers("mine", "", "theirs"), "theirs\nmine");
  assert.equal(withOthers("old", "old", "theirs"), "theirs", "nothing was typed");
  assert.equal(withOthers("", "old", "theirs"), "theirs");
  assert.equal(withOthers("same", "", "same"), "same");
});

test("a finding in the picture: its parts are seen, all else is faint, and leaving it restores all", () => {
  const document = { hidden: [0, 3], ghost: [1], gripped: [], isolated: false, out: [4] };
  const before = partStates(5, document, new Set());
  assert.deepEqual([...before], [1, 2, 0, 1, 2], "what is out is seen through");
  const focus = { parts: [0, 2], cover: 2 };
  const HIDDEN = 1;
  const GHOST = 2;
  const states = [...partStates(5, document, new Set(), focus)];
  assert.deepEqual(states, [0, GHOST, GHOST, GHOST | HIDDEN, GHOST], "the cover is faint, too");
  assert.deepEqual(partStates(5, document, new Set(), null), before);
});

test("the parts of a finding have two colours, one that is not here has none", () => {
  const state = new FindingState(signal(null));
  const finding = listOf({ one: { a: "m/a", b: "nowhere" } }).finding(0);
  const tints = findingTints({ finding, parts: [0], cover: null, points: [], arrow: null });
  assert.deepEqual([...tints.keys()], [0]);
  assert.deepEqual([...findingTints(null)], []);
  assert.equal(state.row.value, -1);
});

test("a hundred thousand findings are filtered and sorted", () => {
  const given: Record<string, Given> = {};
  for (let k = 0; k < 100_000; k++) given[`id ${k}`] = { group: `group ${k % 900}`, depth: 1 / (k + 1) };
  // As many parts as there are of an engine.
  const list = listOf(given);
  const facts = { ...FACTS, count: list.count };
  const found = shownFindings(list, facts, { ...ALL, query: "group 7" }, new Set());
  assert.ok(found.rows.length > 10_000 && found.groups.length > 100);
  assert.ok(list.count > found.rows.length);
});

test("a way out is as sure as the depth is", () => {
  const given = { depth: 0.01, translation: [0, 0, 0.01] as [number, number, number] };
  const said = (more: Given): string => wayText(listOf({ f: { ...given, ...more } }).finding(0), "mm");
  assert.equal(said({ kind: 1 }), "out by 10 mm", "as the sentence: is 10 mm deep");
  assert.equal(said({ kind: 3 }), "out by at most 10 mm");
  assert.equal(said({ kind: 2 }), "out by at most 10 mm");
  assert.equal(said({ kind: 1, translation: [0, 0, 0.012] }), "out by at most 12 mm", "a shorter one may exist");
});
