import assert from "node:assert/strict";
import { test } from "node:test";
import { isStale, savingText, staleText } from "../src/actions/project";
import type { ProjectFacts } from "../src/link/protocol";
import type { Finding } from "../src/model/finding-list";
import { checkSince, findingRevision, revisionText, sinceText } from "../src/model/stale";

const FACTS: ProjectFacts = {
  name: "a.feelproj",
  state: "saved",
  trouble: null,
  stale: {},
  gone: [],
  aside: 0,
  left: [],
};

test("the state of saving has words", () => {
  assert.equal(savingText(FACTS), "Saved");
  assert.equal(savingText({ ...FACTS, state: "saving" }), "Saving");
  assert.equal(savingText({ ...FACTS, state: "failed" }), "Not saved");
  assert.equal(savingText({ ...FACTS, state: "read only" }), "Project is read only");
});

test("what a revision changed is counted by kind", () => {
  assert.equal(isStale(null), false);
  assert.equal(isStale(FACTS), false);
  assert.equal(isStale({ ...FACTS, gone: ["a"] }), true);
  const stale = { 1: "moved", 2: "changed", 7: "changed", 9: "new" } as const;
  assert.equal(staleText({ ...FACTS, stale, gone: ["a/b"] }), "2 changed, 1 moved, 1 new, 1 gone");
  const left = [{ pattern: "pipe*", of: "rule", part: "hose", was: "pipe_1" }] as const;
  assert.equal(isStale({ ...FACTS, left }), true);
  assert.equal(staleText({ ...FACTS, left }), "1 left by a pattern");
});

test("a result names the parts that differ since", () => {
  const nameOf = (part: number): string => ["pump", "lid", "bolt", "gear", "shaft"][part] ?? "";
  const [moved, changed, added] = [{ change: "moved" }, { change: "changed" }, { change: "new" }] as const;
  assert.equal(revisionText({}, nameOf), "");
  assert.equal(revisionText({ 0: moved }, nameOf), "of an earlier revision: pump moved since");
  assert.equal(
    sinceText({ 0: moved, 1: changed, 2: added, 4: moved }, nameOf),
    "pump moved, lid changed, bolt is new and 1 more",
  );
  assert.equal(sinceText({ 0: moved, 1: changed }, nameOf, [3, 1, null]), "lid changed");
  assert.equal(sinceText({ 0: moved }, nameOf, [2]), "");
  const finding = { part_a: null, part_b: 0, path_a: "a/bolt", path_b: "a/pump" } as Finding;
  assert.equal(
    findingRevision(finding, { 0: moved }, ["a/bolt"], nameOf),
    "of an earlier revision: bolt gone, pump moved since",
  );
  assert.equal(findingRevision(finding, {}, [], nameOf), "", "of another mock-up");
  assert.equal(checkSince({ 0: moved }, ["a/bolt"], nameOf), "1 part gone, pump moved");
  assert.equal(checkSince({}, ["a/bolt"], nameOf), "", "checked since");
});
