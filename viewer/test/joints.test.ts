import assert from "node:assert/strict";
import { test } from "node:test";
import { isRules, JointMover, stopText } from "../src/actions/joints";
import type { JointPlace, JointRange, Mechanism } from "../src/link/protocol";
import { IDENTITY, translation } from "../src/math/matrix";
import { barOf, gapClass, gapText, isFixed, numberOf, partsOf, placesAt, spanOf, stepped } from "../src/model/joints";

const MECHANISM: Mechanism = {
  name: "m",
  numbers: [
    {
      ...{ name: "hinge", kind: "turn", link: 0, root: "hinge", group: "hinge" },
      ...{ axis: [0, 0, 1], point: [0, 0, 0], pitch: 0, limits: null },
    },
  ],
  links: [
    { name: "hinge", above: -1, parts: [1], pose: [...IDENTITY] },
    { name: "lock", above: 0, parts: [2, 3], pose: [...IDENTITY] },
  ],
  values: { hinge: 0 },
};

test("parts go with their links, and those that lie elsewhere stay there", () => {
  const away = [...translation([9, 0, 0])];
  const document = { moved: { "3": away, "4": away }, mechanism: MECHANISM, gripped: [], out: [] };
  const there = [...translation([0, 0, 1])];
  const places = placesAt(document, [there, there]);
  assert.deepEqual([places.get(1), places.get(2)], [there, there]);
  assert.deepEqual([places.get(3), places.get(4)], [away, away]);
  assert.equal(placesAt(document, null).has(1), false);
});

test("a part of a link that is fastened moves by the joint above it", () => {
  assert.equal(numberOf(MECHANISM, 3)?.name, "hinge");
  assert.equal(numberOf(MECHANISM, 4), null);
  const [hinge] = MECHANISM.numbers;
  assert.deepEqual(hinge && partsOf(MECHANISM, hinge), [1, 2, 3]);
});

const RANGE: JointRange = {
  ...{ name: "hinge", state: "done", share: 1, lower: 0, upper: 2, below: null, above: null, worst: null, trouble: "" },
  curve: [
    [0, null],
    [1, 0.003],
    [2, 0],
  ],
};

test("a joint says what stops it, and a limit only where it has one", () => {
  const place: JointPlace = { name: "crank", value: 1, stop: "limit", met: null, why: "", values: {} };
  const path = (part: number) => `part ${part}`;
  assert.equal(stopText(place, path), "crank is at its limit");
  assert.equal(
    stopText({ ...place, stop: "contact", met: { part: 1, other: 2, point: [0, 0, 0] } }, path),
    "crank stops: part 1 meets part 2",
  );
  assert.equal(stopText({ ...place, stop: "end", why: "it has no limit" }, path), "it has no limit");
});

test("the bar is coloured by the gap", () => {
  assert.deepEqual(
    barOf(RANGE, [-2, 2]).map(({ from, to, gap }) => [from, to, gap]),
    [
      [0.5, 0.625, 4],
      [0.625, 0.875, 2],
      [0.875, 1, 0],
    ],
  );
  assert.deepEqual([gapClass(0), gapClass(5e-4), gapClass(0.01), gapClass(0.02)], [0, 1, 3, 4]);
  const [hinge] = MECHANISM.numbers;
  assert.deepEqual(hinge && spanOf(hinge, RANGE, 3), [0, 3]);
});

/** A server that answers when it is told to, and stops at 1. */
function slow() {
  const asked: [string, number | null][] = [];
  const moved: [string, number][] = [];
  const answers: (() => void)[] = [];
  const link = {
    to: (name: string, value: number | null) => {
      asked.push([name, value]);
      return new Promise<JointPlace>((resolve) => {
        const place = Math.min(1, value ?? 0);
        answers.push(() =>
          resolve({ name, value: place, stop: place !== value ? "limit" : null, met: null, why: "", values: {} }),
        );
      });
    },
    move: async (name: string, value: number) => {
      moved.push([name, value]);
    },
    fail: (error: unknown) => assert.fail(String(error)),
  };
  const answer = async (): Promise<void> => {
    answers.shift()?.();
    await new Promise((resolve) => setImmediate(resolve));
  };
  return { asked, moved, answer, mover: new JointMover(link) };
}

test("one question is on its way, and of those that wait the newest counts", async () => {
  const { asked, moved, answer, mover } = slow();
  for (const value of [0.1, 0.2, 0.3, 3]) mover.to("hinge", value);
  assert.deepEqual(asked, [["hinge", 0.1]]);
  await answer();
  assert.deepEqual(asked.at(-1), ["hinge", 3]);
  mover.settle();
  assert.deepEqual(moved, [], "it is not there yet");
  await answer();
  assert.deepEqual(moved, [["hinge", 1]], "where contact let it");
  assert.equal(asked.length, 2);
  assert.equal(mover.name, null);
});

test("Esc puts it back, also while an answer is on its way", async () => {
  const { asked, moved, answer, mover } = slow();
  mover.to("hinge", 0.5);
  assert.equal(mover.cancel(), true);
  for (let k = 0; k < 4; k++) await answer();
  assert.deepEqual(asked.at(-1), ["hinge", null]);
  assert.deepEqual(moved, []);
  assert.equal(mover.cancel(), false);
});

test("keys that follow each other fast add up, and go on from where a stop let it", async () => {
  const { answer, mover } = slow();
  mover.to("hinge", 0.5);
  assert.equal(mover.wantedOf("hinge"), 0.5);
  mover.to("hinge", 3);
  assert.equal(mover.wantedOf("hinge"), 3, "no answer is there yet");
  await answer();
  assert.equal(mover.wantedOf("hinge"), 3);
  await answer();
  assert.equal(mover.wantedOf("hinge"), 1);
  assert.equal(mover.wantedOf("latch"), null);
  mover.settle();
  await answer();
  assert.equal(mover.wantedOf("hinge"), null);
});

test("a slider goes by steps, tenths and ends", () => {
  const key = (name: string, shiftKey = false): number | null => stepped({ key: name, shiftKey }, 1, 0.5, [0, 3]);
  assert.deepEqual(
    ["ArrowRight", "ArrowDown", "PageUp", "PageDown"].map((name) => key(name)),
    [1.5, 0.5, 3, 0],
  );
  assert.deepEqual([key("ArrowUp", true), key("Home"), key("End"), key("a")], [1.05, 0, 3, null]);
});

test("colours are told in the unit that is shown, and a joint between two stops is fixed", () => {
  assert.deepEqual([gapText(0, "mm"), gapText(1, "mm"), gapText(4, "cm")], ["contact", "< 1 mm", "2 cm or more"]);
  const met = { part: 0, other: 1, point: [0, 0, 0] as [number, number, number] };
  assert.equal(isFixed({ ...RANGE, upper: 0, below: met, above: met }), true);
  assert.equal(isFixed({ ...RANGE, upper: 0, below: met }), false);
});

test("a file of clash rules is not taken for a mechanism", () => {
  for (const text of ['version = 1\n[[rule]]\nname = "x"', "  [[exclude]]\r\nfasteners = true"])
    assert.ok(isRules(text));
  for (const text of ["", "[[joint]]\n[[rule]]", 'name = "[[rule]]"', "# [[rule]]"]) assert.equal(isRules(text), false);
});

test("values for several joints arrive one after the other, however late the first answer is", async () => {
  const { asked, moved, answer, mover } = slow();
  for (const [name, value] of [
    ["crank", 0.5],
    ["slide", 0.2],
    ["hinge", 3],
    ["slide", 0.4],
  ] as const) {
    mover.to(name, value);
    mover.settle();
  }
  assert.deepEqual(asked, [["crank", 0.5]]);
  assert.deepEqual(
    ["crank", "slide", "hinge"].map((name) => mover.wantedOf(name)),
    [0.5, 0.4, 3],
  );
  for (let k = 0; k < 8; k++) await answer();
  assert.deepEqual(moved, [
    ["crank", 0.5],
    ["hinge", 1],
    ["slide", 0.4],
  ]);
  assert.equal(mover.name, null);
});
