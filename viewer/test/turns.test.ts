import assert from "node:assert/strict";
import { test } from "node:test";
import { Turns } from "../src/link/turns";

/** What was begun, in order; each is answered by hand. */
function setUp() {
  const begun: string[] = [];
  const answers = new Map<string, () => void>();
  const timers: (() => void)[] = [];
  const movement = { is_open: false, ends: 0 };
  const turns = new Turns(
    {
      isOpen: () => movement.is_open,
      end: () => {
        movement.is_open = false;
        movement.ends++;
        ask("place", { isFirst: true });
      },
    },
    { set: (callback) => timers.push(callback), clear: (handle) => timers.splice(handle - 1, 1, () => {}) },
  );
  const ask = (name: string, { isOfDocument = false, isFirst = false } = {}): Promise<string> => {
    const work = (): Promise<string> => {
      begun.push(name);
      return new Promise((resolve, reject) => {
        answers.set(name, () => (name === "wrong" ? reject(new Error(name)) : resolve(name)));
      });
    };
    return isFirst ? turns.first(work) : turns.take(work, isOfDocument);
  };
  const answer = async (name: string): Promise<void> => {
    answers.get(name)?.();
    await new Promise(setImmediate);
  };
  return { turns, begun, ask, answer, movement, timers };
}

test("what depends on nothing goes out at once, before the one before is answered", async () => {
  const { turns, begun, ask, answer } = setUp();
  const first = ask("hide");
  ask("show");
  assert.deepEqual(begun, ["hide", "show"]);
  assert.ok(turns.isBusy);
  await answer("hide");
  assert.equal(await first, "hide");
  await answer("show");
  assert.ok(!turns.isBusy);
});

test("what is made of the document waits for all before it, and what comes later waits behind it", async () => {
  const { begun, ask, answer } = setUp();
  ask("mode", { isOfDocument: true });
  assert.deepEqual(begun, ["mode"], "nothing is before it");
  ask("mode again", { isOfDocument: true });
  ask("undo");
  assert.deepEqual(begun, ["mode"]);
  await answer("mode");
  assert.deepEqual(begun, ["mode", "mode again", "undo"]);
});

test("one that fails holds nobody up", async () => {
  const { begun, ask, answer } = setUp();
  const wrong = ask("wrong");
  const next = ask("next", { isOfDocument: true });
  await Promise.all([assert.rejects(wrong, /wrong/), answer("wrong")]);
  assert.deepEqual(begun, ["wrong", "next"]);
  await answer("next");
  assert.equal(await next, "next");
});

test("a movement that is not put down yet comes before what was asked for after it", async () => {
  const { turns, begun, ask, movement } = setUp();
  movement.is_open = true;
  ask("undo");
  ask("undo again");
  assert.deepEqual(begun, []);
  movement.is_open = false;
  ask("place", { isFirst: true });
  turns.go();
  assert.deepEqual(begun, ["place", "undo", "undo again"]);
});

test("a movement that does not end is ended", async () => {
  const { turns, begun, ask, movement, timers } = setUp();
  movement.is_open = true;
  ask("undo");
  ask("redo");
  assert.equal(timers.length, 1);
  timers[0]?.();
  assert.deepEqual(begun, ["place", "undo", "redo"]);
  assert.equal(movement.ends, 1);
  // The next one has all its time again.
  movement.is_open = true;
  ask("hide");
  assert.equal(timers.length, 2);
  movement.is_open = false;
  turns.go();
  timers[1]?.();
  assert.equal(movement.ends, 1);
});
