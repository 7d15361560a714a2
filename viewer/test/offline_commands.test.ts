import assert from "node:assert/strict";
import { test } from "node:test";
import type { CommandRequest, Document } from "../src/link/protocol";
import { IDENTITY } from "../src/math/matrix";
import { OfflineCommands } from "../src/model/offline-commands";

const DOCUMENT = {
  mockup: { name: "engine", hash: "ab", triangles: 10, parts: 4 },
  absent: [],
  unit: "mm",
  hidden: [3],
  ghost: [],
  explode: 0,
  isolated: false,
  sections: [],
  findings: { groups: [], status: {}, is_touching_hidden: true },
} as unknown as Document;

function after(...commands: CommandRequest[]): Document {
  const offline = new OfflineCommands();
  let document = DOCUMENT;
  for (const each of commands) document = offline.applied(document, each) ?? assert.fail(each[0]);
  return document;
}

test("parts are hidden, shown and made ghosts as by the server", () => {
  assert.deepEqual(after(["hide", { parts: [1, 3] }]).hidden, [1, 3]);
  assert.deepEqual(after(["hide", { parts: [1] }], ["show", { parts: [3] }]).hidden, [1]);
  assert.deepEqual(after(["hide_all"]).hidden, [0, 1, 2, 3]);
  assert.deepEqual(after(["hide_all"], ["show_all"]).hidden, []);
  const ghost = after(["ghost", { parts: [2, 0], is_on: true }], ["ghost", { parts: [0], is_on: false }]);
  assert.deepEqual(ghost.ghost, [2]);
});

test("isolating the same parts again brings back what was seen before", () => {
  const isolated = after(["isolate", { parts: [1] }]);
  assert.deepEqual([isolated.hidden, isolated.isolated], [[0, 2, 3], true]);
  const other = after(["isolate", { parts: [1] }], ["isolate", { parts: [2] }], ["isolate", { parts: [2] }]);
  assert.deepEqual([other.hidden, other.isolated], [[3], false]);
  const shown = after(["isolate", { parts: [1] }], ["show_all"], ["isolate", { parts: [1] }]);
  assert.deepEqual(shown.hidden, [0, 2, 3], "after all were shown it isolates anew");
});

test("singled out parts are solid and in sight, and all others ghosts", () => {
  const before: CommandRequest = ["ghost", { parts: [1, 2], is_on: true }];
  const { hidden, ghost } = after(before, ["single_out", { parts: [2, 3] }]);
  assert.deepEqual([hidden, ghost], [[], [0, 1]]);
});

test("parts that were left out are not hidden with all others", () => {
  const document = { ...DOCUMENT, hidden: [], absent: [0, 2] };
  const offline = new OfflineCommands();
  assert.deepEqual(offline.applied(document, ["hide_all"])?.hidden, [1, 3]);
  assert.deepEqual(offline.applied(document, ["isolate", { parts: [3] }])?.hidden, [1]);
});

test("cuts are made, moved, switched and removed", () => {
  const add: CommandRequest = ["section_add", { normal: [0, 0, 1], offset: 0.1 }];
  const two = after(
    add,
    add,
    ["section_move", { id: 2, normal: [1, 0, 0], offset: 0.5 }],
    ["section_switch", { id: 1, is_on: false }],
  );
  assert.deepEqual(two.sections, [
    { id: 1, normal: [0, 0, 1], offset: 0.1, is_on: false },
    { id: 2, normal: [1, 0, 0], offset: 0.5, is_on: true },
  ]);
  assert.deepEqual(after(add, ["section_remove", { id: 1 }]).sections, []);
});

test("what needs the engine is refused", () => {
  const refused: CommandRequest[] = [
    ["grip", { parts: [1] }],
    ["place", { pose: IDENTITY }],
    ["undo"],
    ["measure_add", { type: "angle", triangles: [1, 2] }],
    ["measure_add", { type: "point" }],
  ];
  for (const each of refused) assert.equal(new OfflineCommands().applied(DOCUMENT, each), null, each[0]);
});
