import assert from "node:assert/strict";
import { test } from "node:test";
import { ask, filmPath, filmPlaces, frameWay, hitAt, isAway } from "../src/actions/cards";
import { askOfLine, guidePath, isGuiding, toggleGuide } from "../src/actions/lines";
import type { Workbench } from "../src/actions/workbench";
import type { CardAnswer, Document } from "../src/link/protocol";
import { IDENTITY, translation } from "../src/math/matrix";
import type { Box } from "../src/math/vectors";
import { Store } from "../src/model/store";

const DOCUMENT = { moved: {}, gripped: [], guiding: null, cards: [], sequence: [] } as unknown as Document;
const WAY: CardAnswer["ways"][number] = {
  parts: [1],
  poses: [[...IDENTITY], [...translation([0, 0, 5])]],
  clearance: null,
  legs: [],
  length: 5,
  rotation: 0,
  gaps: [],
  places: { "2": [...translation([7, 0, 0])] },
  hit: { share: 0.5, part: 0, point: [0, 0, 2] },
};

/** A workbench that notes the commands that it is to run, and what the camera is to see. */
function bench(document: Partial<Document> = {}) {
  const store = new Store();
  store.document.value = { ...DOCUMENT, moved: { "1": [...translation([9, 9, 9])] }, ...document };
  const parts = { lower: [0, 0, 0].map(() => [0, 0, 0]), upper: [0, 0, 0].map(() => [1, 1, 1]) };
  store.manifest.value = { parts } as unknown as NonNullable<typeof store.manifest.value>;
  store.answers.value = new Map([[4, { id: 4, ways: [WAY], blockers: [], reaches: [], room: null, facts: [] }]]);
  const ran: unknown[][] = [];
  const seen: Box[] = [];
  const wb = {
    store,
    ran,
    seen,
    hand: { pivot: [1, 0, 0] },
    run: async (...request: unknown[]) => {
      ran.push(request);
      return true;
    },
    look: (change: (camera: { fit(box: Box): void }) => void) => change({ fit: (box) => seen.push(box) }),
    redraw: () => {},
    stage: { setRoom: () => {} },
  };
  return wb as unknown as Workbench & { ran: unknown[][]; seen: Box[] };
}

const FILM = { card: 4, step: 0, share: 1, is_playing: false };

test("a film of a removal in the sequence has all parts where they were", () => {
  const wb = bench();
  const places = filmPlaces(wb, FILM);
  // The moving part begins at home, not where it lies now, and another one lies where the line has it.
  assert.deepEqual([...places.keys()].sort(), [1, 2]);
  assert.deepEqual([places.get(1)?.[11], places.get(1)?.[3], places.get(2)?.[3]], [5, 0, 7]);
  assert.equal(filmPlaces(wb, null).get(1)?.[3], 9);
  assert.deepEqual(filmPath(wb, FILM), [
    [0.5, 0.5, 0.5],
    [0.5, 0.5, 5.5],
  ]);
});

test("the whole way and its parts are looked at", () => {
  const wb = bench();
  frameWay(wb, WAY);
  assert.deepEqual(wb.seen, [{ lower: [0, 0, 0], upper: [1, 1, 6] }]);
});

test("where a way meets something is told there alone", () => {
  assert.equal(hitAt(WAY, 0.5)?.part, 0);
  assert.equal(hitAt(WAY, 0.6), null);
});

test("the hand grips the parts of a way before it guides, unless it holds others", async () => {
  let wb = bench();
  await toggleGuide(wb, { line: 3 }, [1]);
  assert.deepEqual(wb.ran, [
    ["grip", { parts: [1] }],
    ["guide", { line: 3 }],
  ]);
  wb = bench({ gripped: [1] });
  await toggleGuide(wb, { card: 4, step: 0 }, [1]);
  assert.deepEqual(wb.ran, [["guide", { card: 4, step: 0 }]]);
  wb = bench({ gripped: [0] });
  await toggleGuide(wb, { line: 3 }, [1]);
  assert.deepEqual([wb.ran, wb.store.notices.value.length], [[], 1]);
  const guiding = { card: null, line: 3, step: 0, parts: [1], way: [[...IDENTITY], [...translation([0, 0, 2])]] };
  wb = bench({ gripped: [1], guiding });
  await toggleGuide(wb, { line: 3 }, [1]);
  assert.deepEqual(wb.ran, [["guide_end"]]);
  assert.ok(!isGuiding(guiding, { line: 4 }) && !isGuiding(guiding, { card: 3, step: 0 }));
  assert.deepEqual(guidePath(wb, guiding), [
    [1, 0, 0],
    [1, 0, 2],
  ]);
});

test("a question about a line opens its answer", async () => {
  const wb = bench();
  await askOfLine(wb, "way_check", 3);
  assert.deepEqual(wb.ran, [["way_check", { id: 3 }]]);
});

test("a refused question opens no card, and a part that is away is known to be", async () => {
  const store = new Store();
  store.document.value = { cards: [{ id: 7 }], out: [3], gripped: [4] } as unknown as Document;
  store.card.value = 5;
  const wb = { store, run: () => Promise.resolve(false) } as unknown as Workbench;
  await ask(wb, "removal", [3]);
  assert.equal(store.card.value, 5, "another card stays closed");
  assert.deepEqual(
    [2, 3, 4].map((part) => isAway(wb, part)),
    [false, true, true],
  );
});
