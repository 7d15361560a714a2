import assert from "node:assert/strict";
import { test } from "node:test";
import { isStale, savingText, staleText } from "../src/actions/project";
import type { ProjectFacts } from "../src/link/protocol";

const FACTS: ProjectFacts = { name: "a.feelproj", state: "saved", trouble: null, stale: {}, gone: [], aside: 0 };

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
});
