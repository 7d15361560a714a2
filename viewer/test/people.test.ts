import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { mock, test } from "node:test";
import { beginTyping, refuseKey } from "../src/actions/typed-move";
import { Workbench } from "../src/actions/workbench";
import { moveTo, ToolError } from "../src/app/api";
import { marksOf } from "../src/app/marks";
import { partStates } from "../src/app/part-states";
import { Presence } from "../src/app/presence";
import { isOfTyping } from "../src/input/keys";
import { Link, LinkError, type Socket } from "../src/link/link";
import type { Camera, Here, People, Seen, TurnWish } from "../src/link/protocol";
import type { Vec3 } from "../src/math/vectors";
import type { Hand } from "../src/model/hand";
import { colourOf, PERSON_COLOURS, PeopleState } from "../src/model/people";
import { Store } from "../src/model/store";
import { OTHERS } from "../src/scene/parts";
import { PartState, type Stage } from "../src/scene/stage";
import { initials } from "../src/ui/words";
import { contrast } from "./contrast";

const CAMERA: Camera = { position: [1, 0, 0], target: [0, 0, 0], up: [0, 0, 1], fov_rad: 0.8 };

const person = (id: number, name = `Guest ${id}`, is_away = false) => ({ id, name, colour: id - 1, is_away });

const people = (turn: Partial<People["turn"]> = {}, count = 2): People => ({
  kind: "people",
  you: 1,
  people: Array.from({ length: count }, (_, k) => person(k + 1)),
  turn: { kind: null, person: null, is_free: true, asked: [], ...turn },
});

const seen = (id: number, selection: number[] = [], point: Vec3 | null = null): Seen => ({
  kind: "seen",
  person: id,
  point,
  selection,
  camera: CAMERA,
});

test("who has the tool bars others, until it is free", () => {
  const state = new PeopleState();
  state.take(people());
  assert.deepEqual([state.is_barred.value, state.is_mine.value, state.holder.value], [false, false, ""]);
  state.take(people({ kind: "page", person: 2, is_free: false }));
  assert.deepEqual([state.is_barred.value, state.holder.value], [true, "Guest 2"]);
  state.tried();
  state.take(people({ kind: "page", person: 2, is_free: false, asked: [1] }));
  assert.deepEqual([state.has_tried.value, state.has_asked.value, state.asking.value], [true, true, []]);
  state.take(people({ kind: "page", person: 2, is_free: true }));
  assert.deepEqual([state.is_barred.value, state.has_tried.value], [false, false]);
  state.take(people({ kind: "page", person: 1, is_free: false, asked: [2] }));
  assert.deepEqual([state.is_mine.value, state.asking.value.map(({ id }) => id)], [true, [2]]);
  state.take(people({ kind: "script", is_free: false }));
  assert.deepEqual([state.is_barred.value, state.holder.value], [true, "A script"]);
  state.forget();
  assert.equal(state.is_barred.value, false);
});

test("what others show goes with them, and a moving pointer gives parts no other state", () => {
  const state = new PeopleState();
  state.take(people({}, 3));
  state.takeSeen(seen(2, [4]));
  state.takeSeen(seen(3, [1, 2]));
  const first = state.selections.value;
  assert.deepEqual(first, [[4], [1, 2]]);
  state.takeSeen(seen(2, [4], [1, 2, 3]));
  assert.equal(state.selections.value, first);
  state.take({ ...people({}, 3), people: [person(1), person(2, "Ben", true), person(3)] });
  assert.deepEqual(state.selections.value, [[], [1, 2]], "who is away shows nothing");
  state.take(people({}, 1));
  assert.deepEqual([state.selections.value, state.seen.value.size], [[], 0]);
});

test("what others selected is in the byte of a part, beside everything else", () => {
  const document = { hidden: [0], ghost: [], gripped: [], isolated: false, out: [] };
  assert.deepEqual(
    [...partStates(5, document, new Set([1]), null, [[0, 1, 99, -1], [2], [3, 1], [4]])],
    [PartState.hidden | OTHERS[0], PartState.selected | OTHERS[2], OTHERS[1], OTHERS[2], 0],
  );
  const others = OTHERS.reduce((all, each) => all | each, 0);
  assert.equal(others & (1 | 2 | PartState.hit | PartState.selected | PartState.away | 64), 0);
});

test("others are marked where they point, and the tool by the name of who moves it", () => {
  const store = new Store();
  const hand = { pivot: [0, 0, 0], center: [0, 0, 1], wish: null } as unknown as Hand;
  store.people.take({ ...people({}, 3), people: [person(1), person(2, "a\u202eb"), person(3, "away", true)] });
  store.people.takeSeen(seen(2, [], [1, 2, 3]));
  store.people.takeSeen(seen(3, [], [1, 2, 3]));
  const [mark, ...more] = marksOf(store, null, hand).people;
  assert.deepEqual([mark?.at, mark?.colour, mark?.isTool, more.length], [[1, 2, 3], PERSON_COLOURS[1], false, 0]);
  assert.ok(mark?.name.startsWith("\u2068"), "a name of another direction turns nothing else");
});

test("white letters on a person's colour are read, and the colour is seen on the panels of both themes", () => {
  const style = readFileSync(new URL("../../viewer/src/ui/styles/people.css", import.meta.url), "utf8");
  for (const [k, colour] of PERSON_COLOURS.entries()) {
    assert.ok(contrast(colour, 0xffffff) >= 4.5);
    for (const panel of [0x1b212b, 0xfbfcfd]) assert.ok(contrast(colour, panel) >= 3);
    assert.match(style, new RegExp(`mark-person-${k} {\\s*background: #${colour.toString(16)};`));
  }
  assert.equal(new Set(PERSON_COLOURS).size, PERSON_COLOURS.length);
  assert.equal(colourOf(PERSON_COLOURS.length + 1), PERSON_COLOURS[1]);
});

test("initials are whole letters", () => {
  assert.deepEqual(["Ann", "Guest 2", "\u{1f600}x y z", "ßa"].map(initials), ["A", "G2", "\u{1f600}Y", "SS"]);
});

function bench() {
  const store = new Store();
  const told: Omit<Here, "kind">[] = [];
  const turns: TurnWish[] = [];
  const link = {
    here: (here: Omit<Here, "kind">) => told.push(here),
    turn: async (wish: TurnWish) => {
      turns.push(wish);
    },
  } as unknown as Link;
  const hand = { wish: null } as unknown as Hand;
  const stage = { camera: { toJSON: () => CAMERA } } as unknown as Stage;
  const wb = new Workbench({ store, stage, hand, link, redraw() {}, fetchFile: async () => new Blob() });
  return { wb, store, told, turns };
}

test("a page tells where it is at most ten times a second, only what is new, and nothing while it is alone", () => {
  mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
  try {
    const { wb, store, told } = bench();
    const presence = new Presence(wb);
    const move = (x: number): void => {
      store.pointed.value = [x, 0, 0];
      presence.changed();
    };
    move(1);
    mock.timers.tick(10_000);
    assert.equal(told.length, 0);
    presence.share(true);
    for (let k = 0; k < 1000; k++) {
      move(k);
      mock.timers.tick(1);
    }
    assert.ok(told.length <= 10 && told.length >= 8, `${told.length}`);
    mock.timers.tick(100);
    assert.deepEqual(told.at(-1)?.point, [999, 0, 0]);
    // What stays as it is, is said again every two seconds: others know that the page is there.
    told.length = 0;
    for (let k = 0; k < 60; k++) {
      presence.changed();
      mock.timers.tick(100);
    }
    assert.equal(told.length, 3);
    presence.share(false);
    move(5);
    mock.timers.tick(10_000);
    assert.equal(told.length, 3);
  } finally {
    mock.timers.reset();
  }
});

test("a refused move is told calmly, and others as before", () => {
  const { wb, store } = bench();
  const refusal = new LinkError("Ann has the tool", "tool", "ask for it");
  store.people.take(people({ kind: "page", person: 2, is_free: false }));
  wb.tell(refusal);
  assert.deepEqual([store.people.has_tried.value, store.notices.value.length], [true, 0]);
  store.people.take(people());
  wb.tell(refusal);
  assert.deepEqual([store.people.has_tried.value, store.notices.value.length], [false, 1]);
});

test("an answer to the wish of another page is none to ours", () => {
  const sent: (string | ArrayBuffer)[] = [];
  const socket: Socket = {
    binaryType: "",
    onopen: null,
    onmessage: null,
    onclose: null,
    send: (data) => sent.push(data),
    close() {},
  };
  const nothing = (): void => {};
  const listener = {
    onStatus: nothing,
    onSilence: nothing,
    onWelcome: nothing,
    onState: nothing,
    onEvent: nothing,
    onPeople: nothing,
    onSeen: nothing,
  };
  const link = new Link({ url: "ws://127.0.0.1:1/", token: "t", listener, open: () => socket, every: () => nothing });
  link.connect();
  socket.onopen?.(undefined as never);
  const say = (message: object): void => socket.onmessage?.({ data: JSON.stringify(message) });
  say({ kind: "welcome", session: "s", event: 0, document: {} });
  const wish = { pose: Array(16).fill(0), source: "mouse", time_ms: 0 } as const;
  assert.equal(link.pose(wish), 1);
  say({ kind: "state", seq: 1, pose_seq: 500 });
  assert.equal(link.pose(wish), 501);
  say({ kind: "state", seq: 2, pose_seq: 3 });
  assert.equal(link.pose(wish), 502);
  link.name("Ann");
  link.here({ point: null, selection: [1], camera: CAMERA, is_moving: false });
  link.turn("give", 2).catch(nothing);
  assert.deepEqual(
    sent.slice(-3).map((text) => JSON.parse(String(text)) as unknown),
    [
      { kind: "name", name: "Ann" },
      { kind: "here", point: null, selection: [1], camera: CAMERA, is_moving: false },
      { kind: "turn", id: 1, wish: "give", to: 2 },
    ],
  );
});

test("who asked for the tool is told that it is kept, and only then", () => {
  const holds = (asked: number[], person = 2) => people({ kind: "page", person, is_free: false, asked }, 3);
  const state = new PeopleState();
  const told = (...turns: People[]): string[] => turns.map((each) => state.take(each));
  assert.deepEqual(told(holds([1, 3]), holds([])), ["", "Guest 2 keeps the tool for now. You can ask again."]);
  assert.deepEqual(told(holds([1]), holds([], 3)), ["", ""], "somebody else was given it");
  assert.deepEqual(told(holds([1]), holds([], 1)), ["", ""], "it was given");
  assert.deepEqual(told(holds([3]), holds([])), ["", ""], "another one asked");
});

test("a script that moves the tool of another is refused at once, by name, also on the way", async () => {
  const store = new Store();
  const hand = { isLocked: false, isWaiting: true, sentSeq: 1, move() {} };
  const wb = { store, hand } as unknown as Workbench;
  const move = () => moveTo(wb, () => () => {}, Array(16).fill(0));
  store.people.take(people({ kind: "script", is_free: false }));
  await assert.rejects(move(), (error) => error instanceof ToolError && error.message === "A script has the tool");
  store.people.take(people());
  const moved = move();
  store.people.take(people({ kind: "page", person: 2, is_free: false }));
  await assert.rejects(moved, { name: "ToolError", message: "Guest 2 has the tool" });
});

test("after a refused G the keys of a movement say why, and do nothing else", () => {
  const store = new Store();
  const wb = new Workbench({
    store,
    stage: {} as Stage,
    hand: { pose: [], center: [0, 0, 0], isLocked: true } as unknown as Hand,
    link: null,
    redraw() {},
    fetchFile: () => Promise.reject(new Error()),
  });
  const press = (key: string): boolean => refuseKey(wb, isOfTyping(key), key);
  store.people.take(people({ kind: "page", person: 2, is_free: false }));
  assert.equal(press("X"), false, "nothing was refused");
  beginTyping(wb, "move");
  assert.equal(store.typed.value, null);
  for (const key of ["X", "Y", "Z", "5", ".", "-", "ArrowUp", "Backspace", "X"]) {
    store.spoken.value = "";
    store.people.has_tried.value = false;
    assert.equal(press(key), true, key);
    assert.deepEqual([store.spoken.value, store.people.has_tried.value], ["Guest 2 has the tool", true], key);
  }
  assert.equal(press("Escape"), true);
  assert.equal(press("X"), false, "Esc ended it");
  beginTyping(wb, "turn");
  assert.equal(press("H"), false, "another key is another command");
  assert.equal(press("X"), false);
});
