import assert from "node:assert/strict";
import { test } from "node:test";
import { base64 } from "../src/actions/exports";
import { measureArgs, nearestEdge } from "../src/actions/measures";
import { marksOf } from "../src/app/marks";
import { answerTints, BLOCKING, partStates, REACHED, reachTints, withLit } from "../src/app/part-states";
import type { CardAnswer, Document, Manifest, State } from "../src/link/protocol";
import { IDENTITY } from "../src/math/matrix";
import type { Vec3 } from "../src/math/vectors";
import { touchedParts } from "../src/model/contact";
import { patched, shownMockup } from "../src/model/document";
import { axisAlong, drawnSections, offsetRange, senseOf } from "../src/model/sections";
import { DEFAULTS, loadSettings } from "../src/model/settings";
import { Store } from "../src/model/store";
import { startTyped, withAxis, withKey } from "../src/model/typed-move";
import { PartState } from "../src/scene/stage";
import { depthText, shortened, spokenState, touchedText } from "../src/ui/words";

const DOCUMENT: Document = {
  mockup: { name: "engine", hash: "ab", triangles: 10, parts: 4 },
  loading: null,
  failed: null,
  tool: null,
  tools: [],
  record: null,
  project: null,
  absent: [],
  held_version: 0,
  unit: "mm",
  mode: "stop",
  hidden: [],
  ghost: [],
  explode: 0,
  isolated: false,
  sections: [],
  section_box: null,
  pose: [...IDENTITY],
  gripped: [],
  moved: {},
  out: [],
  sequence: [],
  replaying: null,
  guiding: null,
  measures: [],
  viewpoints: [],
  findings: null,
  cards: [],
  clash: { clearance: 0.002, contact: 0, rules: "" },
  task_times: { name: "", given: 0 },
  task_catalogue: { name: "", tools: 0 },
  requirements: [],
  material: null,
  doubts: [],
  mechanism: null,
  joint_ranges: [],
  on_joint: null,
};

const STATE: State = {
  kind: "state",
  seq: 1,
  pose_seq: 1,
  engine_us: 200,
  age_ms: 1,
  rate_hz: 250,
  mode: "stop",
  is_free: true,
  blocked: false,
  force: [0, 0, 0],
  torque: [0, 0, 0],
  depth: 0,
  depth_kind: "exact",
  hit_count: 0,
  hit_more: 0,
  contact_more: 0,
  distance: null,
  parts: [],
  pose: Float64Array.from(IDENTITY),
  wish: Float64Array.from(IDENTITY),
  hits: new Uint32Array(0),
  tool_hits: new Uint32Array(0),
  planes: new Float32Array(0),
  plane_parts: new Uint32Array(0),
  clearance: new Float32Array(0),
  clearance_parts: new Uint32Array(0),
};

test("the tree has the parts of the scene, and stays as it is where the same ones are left out again", () => {
  const store = new Store();
  const parts = { paths: ["a", "", "c"], triangles: [1, 0, 1], lower: [], upper: [], small: [] };
  store.manifest.value = { parts } as unknown as Manifest;
  store.document.value = { ...DOCUMENT, absent: [1] };
  const tree = store.tree.value;
  assert.deepEqual(
    tree.nodes.map((node) => node.part),
    [0, 2],
  );
  assert.equal(store.part_count.value, 2);
  // As after a reconnect.
  store.document.value = { ...DOCUMENT, absent: [1], hidden: [2] };
  assert.equal(store.tree.value, tree);
  store.document.value = { ...DOCUMENT, absent: [] };
  assert.equal(store.tree.value.nodes.length, 3);
});

test("a patch changes its fields and shares the rest", () => {
  const after = patched(DOCUMENT, { hidden: [1, 2], unit: "in" });
  assert.deepEqual(after.hidden, [1, 2]);
  assert.equal(after.unit, "in");
  assert.equal(after.pose, DOCUMENT.pose);
  assert.deepEqual(DOCUMENT.hidden, []);
  assert.equal(patched(after, { findings: null }).findings, null);
});

test("the store follows the document", () => {
  const store = new Store();
  assert.equal(store.has_hand.value, false);
  store.document.value = patched(DOCUMENT, { hidden: [3], unit: "cm", gripped: [1] });
  assert.ok(store.hidden.value.has(3));
  assert.equal(store.unit.value, "cm");
  assert.equal(store.has_hand.value, true);
  assert.equal(store.is_read_only.value, true, "until the link is open");
  store.connection.value = "open";
  assert.equal(store.is_read_only.value, false);
});

test("notices of the same text stand once, and not more than three", () => {
  const store = new Store();
  for (const text of ["a", "b", "c", "d", "e", "a"]) store.notify("warning", text);
  assert.deepEqual(
    store.notices.value.map((notice) => notice.text),
    ["d", "e", "a"],
  );
  store.dismiss(store.notices.value[0]?.id ?? -1);
  assert.equal(store.notices.value.length, 2);
});

test("what was refused for a reason that is over goes, and other notices stay", () => {
  const store = new Store();
  store.notify("error", "a", "while loading");
  store.notify("error", "b", "hide");
  store.notify("warning", "c");
  store.dismissOf("while loading");
  assert.deepEqual(
    store.notices.value.map((notice) => notice.text),
    ["b", "c"],
  );
});

test("a mock-up is not shown while another one is loading", () => {
  const loading = { stage: "reading", share: 0.5 };
  assert.equal(shownMockup(DOCUMENT)?.name, "engine");
  assert.equal(shownMockup(patched(DOCUMENT, { loading })), null);
  assert.equal(shownMockup(null), null);
});

test("of notices that only inform the newest stands", () => {
  const store = new Store();
  store.notify("error", "a");
  for (const text of ["b", "c"]) store.notify("info", text);
  assert.deepEqual(
    store.notices.value.map((notice) => notice.text),
    ["a", "c"],
  );
  for (const { id } of store.notices.value) store.dismiss(id);
});

test("each part's byte says how it is drawn", () => {
  const document = patched(DOCUMENT, { hidden: [0], ghost: [0, 1], gripped: [2, 9] });
  assert.deepEqual(
    [...partStates(4, document, new Set([1, 3]))],
    [PartState.hidden | PartState.ghost, PartState.ghost | PartState.selected, PartState.away, PartState.selected],
  );
});

test("a section that is dragged is drawn where it is dragged to, one that is off not at all", () => {
  const sections = [
    { id: 1, normal: [1, 0, 0], offset: 0.1, is_on: true },
    { id: 2, normal: [0, 1, 0], offset: 0.2, is_on: false },
    { id: 3, normal: [0, 0, 1], offset: 0.3, is_on: true },
  ] as const;
  const drawn = drawnSections(
    sections.map((each) => ({ ...each, normal: [...each.normal] })),
    { id: 3, normal: [0, 0, 1], offset: 0.5 },
  );
  assert.deepEqual(drawn, [
    { id: 1, normal: [1, 0, 0], offset: 0.1 },
    { id: 3, normal: [0, 0, 1], offset: 0.5 },
  ]);
});

test("a cut keeps what is farther along the view, and its range is that of the mock-up", () => {
  assert.deepEqual(axisAlong([0.2, -0.9, 0.1]), [0, -1, 0]);
  assert.deepEqual(axisAlong([0, 0, 1]), [0, 0, 1]);
  assert.deepEqual(offsetRange([-1, -2, -3], [4, 5, 6], [0, -1, 0]), [-5, 2]);
  assert.deepEqual(offsetRange([-1, -2, -3], [4, 5, 6], [1, 0, 0]), [-1, 4]);
  assert.deepEqual([senseOf([0, -1, 0]), senseOf([0.1, 0, 0.9])], [-1, 1]);
});

test("a measure asks for what its type needs", () => {
  const pick = (part: number) =>
    ({
      part,
      triangle: 10 + part,
      point: [part, 0, 0],
      edge: [
        [0, 0, 0],
        [part, 1, 0],
      ],
    }) as Parameters<typeof measureArgs>[1][number];
  assert.deepEqual(measureArgs("point", [pick(1), pick(2)]), {
    type: "point",
    points: [
      [1, 0, 0],
      [2, 0, 0],
    ],
  });
  assert.deepEqual(measureArgs("edge", [pick(1)]), {
    type: "edge",
    points: [
      [0, 0, 0],
      [1, 1, 0],
    ],
  });
  assert.deepEqual(measureArgs("angle", [pick(1), pick(2)]), { type: "angle", triangles: [11, 12] });
  assert.deepEqual(measureArgs("parts", [pick(1), pick(2)]), { type: "parts", parts: [1, 2] });
  assert.deepEqual(
    nearestEdge(
      [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
      ],
      [0.6, 0.3, 0],
    ),
    [
      [1, 0, 0],
      [0, 1, 0],
    ],
  );
});

const IDLE = { pivot: [0, 0, 0] as Vec3, center: [0, 0, 0] as Vec3, wish: null };

test("figures of marks are in the unit chosen and name the part; what touches has no figure", () => {
  const store = new Store();
  store.document.value = patched(DOCUMENT, { unit: "in" });
  const state: State = {
    ...STATE,
    clearance: Float32Array.from([0.0254, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]),
    clearance_parts: Uint32Array.from([4, 5]),
    distance: { value: 0.0254, tool_point: [0, 0, 0], mockup_point: [0, 0, 1], part: 4 },
    force: [0, 0, 2],
    planes: Float32Array.from([1, 0, 0, 0, 0, 1, -0.001, 1.5, 3, 0, 0, 0, 0, 1, -0.001, 0.5]),
  };
  const marks = marksOf(store, state, IDLE);
  assert.deepEqual(marks.clearances?.texts, ["1 in to part 4", ""]);
  assert.deepEqual(marks.touches, [{ at: [0, 0, 0], text: "touches part 5" }], "it rests there, hand or no hand");
  assert.equal(marks.distance, null, "it is one of the rows");
  assert.deepEqual(marks.force, { at: [1.5, 0, 0], vector: [0, 0, 2], text: "2 N" });
  assert.equal(
    marksOf(store, { ...state, clearance_parts: Uint32Array.from([5, 6]) }, IDLE).distance?.text,
    "1 in to part 4",
  );
  assert.equal(marksOf(store, null, IDLE).force, null);
});

test("a band leads from the tool to a hand that contact holds back, and from nowhere else", () => {
  const store = new Store();
  store.document.value = DOCUMENT;
  const [pose, wish] = [Float64Array.from(IDENTITY), Float64Array.from(IDENTITY)];
  wish[11] = -0.0125;
  const state: State = { ...STATE, pose, wish, blocked: true };
  const held = { pivot: [0, 0, 1] as Vec3, center: [0, 0, 0.9875] as Vec3, wish: [...wish] };
  assert.deepEqual(marksOf(store, state, held).band, {
    from: [0, 0, 1],
    to: [0, 0, 0.9875],
    text: "12.5 mm held back",
  });
  assert.equal(marksOf(store, { ...state, blocked: false }, held).band, null);
  assert.equal(marksOf(store, state, { ...held, wish: null }).band, null, "nobody moves the hand");
});

test("what is typed stands at the tool", () => {
  const store = new Store();
  store.document.value = DOCUMENT;
  assert.equal(marksOf(store, STATE, IDLE).typed, null);
  const begun = startTyped("move", IDENTITY, [0, 0, 0], "world");
  store.typed.value = withKey(withKey(withAxis(begun, 0), "5"), "0");
  assert.deepEqual(marksOf(store, STATE, IDLE).typed, { at: [0, 0, 0], text: "Move X 50 mm" });
});

test("the tool touches what it rests on, after the hand has let go as well", () => {
  const resting = (value: number, mode: State["mode"]): State => ({
    ...STATE,
    mode,
    distance: { value, tool_point: [0, 0, 0], mockup_point: [0, 0, 0], part: 3 },
  });
  assert.deepEqual(touchedParts(resting(1e-6, "stop")), [3]);
  assert.deepEqual(touchedParts(resting(1e-5, "stop")), []);
  assert.deepEqual(touchedParts(resting(2e-5, "glide")), [3], "it keeps a skin");
  assert.equal(
    spokenState(resting(1e-6, "stop"), "mm", () => "lid"),
    "touching, lid",
  );
  assert.deepEqual([...withLit(new Uint8Array(4), resting(1e-6, "stop"))], [0, 0, 0, PartState.hit]);
});

test("long names are cut in their middle", () => {
  assert.equal(shortened("cover", 22), "cover");
  assert.equal(shortened("cover_screw_outer_left_002", 22), "cover_screw…r_left_002");
  assert.equal([...shortened("x".repeat(400), 22)].length, 22);
});

test("what is spoken names the contacts, the parts and the depth", () => {
  const nameOf = (part: number): string => ["fuel pump", "bracket", "pipe", "bolt"][part] ?? "?";
  const touching: State = { ...STATE, is_free: false, parts: [0], planes: new Float32Array(32), depth: 0.0012 };
  assert.equal(spokenState(touching, "mm", nameOf), "4 contacts, fuel pump, 1.2 mm deep");
  const bound: State = { ...touching, depth_kind: "bound" };
  assert.equal(spokenState(bound, "mm", nameOf), "4 contacts, fuel pump, at most 1.2 mm deep");
  const stuck: State = { ...touching, depth_kind: "estimate" };
  assert.equal(spokenState(stuck, "mm", nameOf), "4 contacts, fuel pump, no way out found");
  assert.equal(depthText({ ...touching, depth: 0 }, "mm"), "");
  const inside: State = { ...STATE, is_free: false, depth: 0.008 };
  assert.equal(spokenState(inside, "mm", nameOf), "inside, 8 mm deep");
  assert.equal(
    spokenState({ ...STATE, parts: [0, 1, 2, 3] }, "mm", nameOf),
    "touching, fuel pump, bracket, pipe, 1 more",
  );
  assert.equal(spokenState(STATE, "mm", nameOf), "free");
  const near = {
    ...STATE,
    distance: { value: 0.003, tool_point: [0, 0, 0], mockup_point: [0, 0, 0], part: 1 },
  } as State;
  assert.equal(spokenState(near, "mm", nameOf), "free, 3 mm to bracket");
  assert.equal(touchedText(["a", "b", "c", "d", "e"]), "touches a, b, c and 2 more");
});

test("settings of another kind, or none, are the defaults", () => {
  const kept = (text: string | null) => loadSettings(() => ({ getItem: () => text }));
  assert.deepEqual(kept(null), DEFAULTS);
  assert.deepEqual(kept("no JSON"), DEFAULTS);
  assert.deepEqual(kept('"text"'), DEFAULTS);
  const some = kept('{"volume": 0.2, "style": 7, "unknown": true}');
  assert.deepEqual(some, { ...DEFAULTS, volume: 0.2 });
});

test("base64 is that of any length", () => {
  for (const count of [0, 1, 2, 3, 8192, 20_001]) {
    const bytes = Uint8Array.from({ length: count }, (_, k) => (k * 37) & 255);
    assert.equal(base64(bytes), Buffer.from(bytes).toString("base64"));
  }
});

test("what stops a part is red while its card is open, and nothing where there is a way", () => {
  const blockers = [{ part: 3 }, { part: 1 }] as unknown as CardAnswer["blockers"];
  const none = { reaches: [], blockers, ways: [] };
  assert.deepEqual(
    [...answerTints(none)],
    [
      [3, BLOCKING],
      [1, BLOCKING],
    ],
  );
  assert.equal(answerTints({ ...none, ways: [{}] as unknown as CardAnswer["ways"] }).size, 0);
  assert.equal(answerTints(undefined).size, 0);
});

test("heads are green where a hand turns the tool, amber where none fits or the swing is too small, else red", () => {
  const row = (part: number | null, is_reachable: boolean, has_hand: boolean | null, swing_deg: number) =>
    ({ part, is_reachable, has_hand, swing_deg }) as CardAnswer["reaches"][number];
  const tints = reachTints([
    row(0, true, true, 90),
    row(1, true, null, 90),
    row(2, true, false, 90),
    row(3, false, null, 20),
    row(4, false, null, 0),
    row(null, true, true, 90),
  ]);
  assert.deepEqual(
    [...tints],
    [
      [0, REACHED.yes],
      [1, REACHED.yes],
      [2, REACHED.partly],
      [3, REACHED.partly],
      [4, REACHED.no],
    ],
  );
});
