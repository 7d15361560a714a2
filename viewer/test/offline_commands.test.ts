import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { CommandRequest, Document } from "../src/link/protocol";
import { IDENTITY } from "../src/math/matrix";
import { OfflineCommands } from "../src/model/offline-commands";

const DOCUMENT = {
  mockup: { name: "engine", hash: "ab", triangles: 10, parts: 5 },
  absent: [],
  unit: "mm",
  hidden: [],
  ghost: [],
  explode: 0,
  isolated: false,
  sections: [],
  measures: [],
  replaying: null,
  findings: {
    version: "00ff",
    count: 0,
    counts: {},
    hidden: {},
    status: {},
    notes: {},
    own_groups: [],
    members: {},
    is_touching_hidden: true,
    check: null,
    stale: {},
  },
} as unknown as Document;

interface Case {
  readonly name: string;
  readonly absent?: readonly number[];
  readonly commands: readonly CommandRequest[];
  readonly fields: Partial<Document>;
}

// The server does the same with them: `tests/test_workbench_commands.py` reads this file too.
const CASES: readonly Case[] = JSON.parse(
  readFileSync(new URL("../../testdata/workbench/offline_commands.json", import.meta.url), "utf8"),
);

for (const { name, absent = [], commands, fields } of CASES) {
  test(`as the server: ${name}`, () => {
    const offline = new OfflineCommands();
    let document: Document = { ...DOCUMENT, absent };
    for (const each of commands) document = offline.applied(document, each) ?? assert.fail(each[0]);
    const found = Object.keys(fields).map((field) => [field, document[field as keyof Document]]);
    assert.deepEqual(Object.fromEntries(found), fields);
  });
}

test("a line of the sequence is replayed, and findings that only touch are shown", () => {
  const offline = new OfflineCommands();
  assert.equal(offline.applied(DOCUMENT, ["sequence_replay", { id: 3 }])?.replaying, 3);
  const shown = offline.applied(DOCUMENT, ["finding_filter", { is_touching_hidden: false }]);
  assert.equal(shown?.findings?.is_touching_hidden, false);
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
