import assert from "node:assert/strict";
import { test } from "node:test";
import type { CardAnswer, TaskAnswer, TaskStepFacts } from "../src/link/protocol";
import {
  clockText,
  endOf,
  goneParts,
  lanesOf,
  minutesText,
  parseSeconds,
  seatedStep,
  shortNames,
  sightText,
  ticksOf,
} from "../src/model/task";

const step = (person: number, start: number, seconds: number, more: Partial<TaskStepFacts> = {}): TaskStepFacts => ({
  verb: "undo",
  part: 0,
  tool: "",
  swing_deg: null,
  strokes: 0,
  tool_way: [],
  person,
  start,
  seconds,
  spread: 0,
  after: [],
  because: "",
  arithmetic: "",
  is_typed: false,
  ...more,
});

const task = (...steps: TaskStepFacts[]): TaskAnswer => ({
  steps,
  seconds: 1,
  spread: 0,
  bound: 1,
  people: 2,
  is_complete: true,
  blocked: [],
  notes: [],
});

test("steps are in lanes by person, in order of their start", () => {
  const plan = task(step(1, 5, 10), step(0, 0, 20), step(1, 0, 5));
  assert.deepEqual(
    lanesOf(plan).map(({ person, bars }) => [person, bars.map(({ number }) => number)]),
    [
      [0, [1]],
      [1, [2, 0]],
    ],
  );
  assert.equal(endOf(plan), 20);
  assert.ok(endOf(task()) > 0);
});

test("the axis has few marks, from 0 to the end", () => {
  for (const end of [0.001, 7, 59, 60, 1000, 36000, 1e6]) {
    const ticks = ticksOf(end);
    assert.equal(ticks[0], 0);
    assert.ok(ticks.length <= 8 && (ticks.at(-1) as number) <= end * 1.001, String(end));
  }
  assert.deepEqual(ticksOf(90).map(minutesText), ["0", "0.25", "0.5", "0.75", "1", "1.25", "1.5"]);
});

test("times are read as people type them", () => {
  const typed = { "90": 90, "90 s": 90, "1.5 min": 90, "1,5min": 90, "1:30": 90, "2h": 7200, ".5": 0.5 };
  for (const [text, seconds] of Object.entries(typed)) assert.equal(parseSeconds(text), seconds, text);
  for (const text of ["", "-1", "1e3", "min", "1:2:3", "2000000", "1:75", "99999:00", "constructor", "1 toString"])
    assert.equal(parseSeconds(text), null, text);
  assert.deepEqual([4.25, 59.4, 185, 3720].map(clockText), ["4.25 s", "59 s", "3 min 5 s", "1 h 2 min"]);
});

test("a tool is in its seat at the beginning of its step, and what is out before is gone", () => {
  const tooled = step(0, 0, 1, { tool_way: [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]] as never });
  const way = (parts: number[]) => ({ parts }) as unknown as CardAnswer["ways"][number];
  const answer = { task: task(step(0, 0, 1), tooled), ways: [way([3]), way([0, 1])] } as unknown as CardAnswer;
  assert.equal(seatedStep(answer, 0, 0), null);
  assert.equal(seatedStep(answer, 1, 0), 1);
  assert.equal(seatedStep(answer, 1, 0.9), null);
  assert.equal(seatedStep(undefined, 0, 0), null);
  const cards = [
    { id: 7, question: "task" as const, edits: { off: ["c"], times: [], before: [], table: "", catalogue: "" } },
  ];
  const film = { card: 7, step: 1, share: 0, is_playing: false };
  const answers = new Map([[7, answer]]);
  assert.deepEqual(goneParts(film, cards, answers, ["a", "b", "c", "d"]), [2, 3]);
  assert.deepEqual(goneParts({ ...film, card: 8 }, cards, answers, []), []);
  assert.deepEqual(goneParts(null, cards, answers, []), []);
});

test("what is seen of a fastener is said as a share that is never rounded to all or nothing", () => {
  assert.deepEqual([0, 1e-3, 0.5, 0.999, 1].map(sightText), [
    "Not visible from any side",
    "1 % of it is visible",
    "50 % of it is visible",
    "99 % of it is visible",
    "Fully visible",
  ]);
});

test("names of parts tell them apart, and no longer than that", () => {
  const paths = ["g/fuel/nut_1", "g/vent/nut_1", "g/vent/pipe", "h/vent/nut_1", "nut_2", "g/fuel/nut_1"];
  assert.deepEqual([...shortNames(paths).values()], ["fuel/nut_1", "g/vent/nut_1", "pipe", "h/vent/nut_1", "nut_2"]);
  assert.deepEqual(
    [...shortNames(["a", "b/a", ""])],
    [
      ["a", "a"],
      ["b/a", "b/a"],
      ["", ""],
    ],
  );
});
