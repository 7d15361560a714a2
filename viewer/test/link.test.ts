import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeBinary } from "../src/link/frames";
import { Link, type LinkError, type Socket, takeToken } from "../src/link/link";
import type { People, Seen, ServerEvent, State, Welcome } from "../src/link/protocol";

/** A server that a test plays by hand. */
class FakeSocket implements Socket {
  binaryType = "";
  onopen: ((event: never) => void) | null = null;
  onmessage: ((event: { data: string | ArrayBuffer }) => void) | null = null;
  onclose: ((event: { code: number }) => void) | null = null;
  readonly sent: Record<string, unknown>[] = [];
  readonly binary: ArrayBuffer[] = [];
  closed: number | undefined;

  send(data: string | ArrayBuffer): void {
    if (typeof data === "string") this.sent.push(JSON.parse(data));
    else this.binary.push(data);
  }

  close(code?: number): void {
    this.closed = code ?? 1000;
  }

  open(): void {
    this.onopen?.(undefined as never);
  }

  say(message: Record<string, unknown>): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }

  sayRaw(data: string | ArrayBuffer): void {
    this.onmessage?.({ data });
  }

  drop(code = 1006): void {
    this.onclose?.({ code });
  }

  last(): Record<string, unknown> {
    return this.sent.at(-1) ?? {};
  }
}

function setUp() {
  const sockets: FakeSocket[] = [];
  const delays: number[] = [];
  const clock = { now: 0 };
  const looks = new Set<() => void>();
  let waiting: (() => void) | null = null;
  const told = {
    status: [] as string[],
    silence: [] as boolean[],
    welcomes: [] as Welcome[],
    states: [] as State[],
    events: [] as ServerEvent[],
    people: [] as People[],
    seen: [] as Seen[],
  };
  const link = new Link({
    url: "ws://127.0.0.1:1/",
    token: "secret",
    listener: {
      onStatus: (status) => told.status.push(status),
      onSilence: (is_silent) => told.silence.push(is_silent),
      onWelcome: (welcome) => told.welcomes.push(welcome),
      onState: (state) => told.states.push(state),
      onEvent: (event) => told.events.push(event),
      onPeople: (people) => told.people.push(people),
      onSeen: (seen) => told.seen.push(seen),
    },
    open: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket;
    },
    wait: (callback, delay_ms) => {
      delays.push(delay_ms);
      waiting = callback;
      return 1;
    },
    stopWaiting: () => {
      waiting = null;
    },
    now: () => clock.now,
    every: (callback, period_ms) => {
      looks.add(callback);
      assert.equal(period_ms, 1000);
      return () => looks.delete(callback);
    },
  });
  const socket = (): FakeSocket => sockets.at(-1) ?? new FakeSocket();
  const welcome = (event = 0, session = "s"): void => {
    socket().open();
    socket().say({
      kind: "welcome",
      protocol: 1,
      session,
      document: {},
      held: null,
      event,
      device: false,
      recording: false,
      versions: {},
    });
  };
  const wake = (): void => {
    const callback = waiting;
    waiting = null;
    callback?.();
  };
  link.connect();
  const pass = (seconds: number): void => {
    for (let k = 0; k < seconds; k++) {
      clock.now += 1000;
      for (const look of [...looks]) look();
    }
  };
  return { link, sockets, socket, welcome, wake, delays, told, clock, looks, pass };
}

const notice = (n: number) => ({ kind: "event", type: "notice", n, level: "info", text: `${n}` });

test("the first message has the token, and nothing else goes out before it", () => {
  const { link, socket } = setUp();
  assert.equal(link.pose({ pose: Array(16).fill(0), source: "mouse", time_ms: 0 }), null);
  socket().open();
  assert.deepEqual(socket().sent, [{ kind: "hello", protocol: 1, token: "secret", session: null, last_event: 0 }]);
});

test("a broken link is opened again, later and later, at most every five seconds", () => {
  const { socket, wake, delays, told, welcome } = setUp();
  for (let k = 0; k < 8; k++) {
    socket().drop();
    wake();
  }
  const exact = [200, 300, 450, 675, 1012.5, 1518.75];
  assert.deepEqual(delays.slice(0, 6), exact);
  assert.ok(delays.slice(6).every((delay) => delay > 2000 && delay <= 5000));
  // A cut of two seconds is over within the next one, wherever in it the link noticed.
  const tries = exact.map((_delay, k) => exact.slice(0, k + 1).reduce((sum, each) => sum + each, 0));
  assert.ok(tries.some((at) => at > 2000 && at < 3000));
  welcome();
  socket().drop();
  assert.equal(delays.at(-1), 200, "a connection that was there starts anew");
  assert.deepEqual(told.status, ["lost", "open", "lost"]);
});

test("on return it says which session and which event it had", () => {
  const { socket, wake, welcome } = setUp();
  welcome(41, "abc");
  socket().say(notice(42));
  socket().drop();
  wake();
  socket().open();
  assert.deepEqual(socket().last(), { kind: "hello", protocol: 1, token: "secret", session: "abc", last_event: 42 });
});

test("events are told once and in order, also those that are said again after a break", () => {
  const { socket, wake, told } = setUp();
  socket().open();
  socket().say({
    kind: "welcome",
    protocol: 1,
    session: "s",
    document: {},
    held: null,
    event: 3,
    device: false,
    recording: false,
    versions: {},
  });
  for (const n of [3, 4, 5]) socket().say(notice(n));
  socket().drop();
  wake();
  socket().open();
  for (const n of [5, 6, 7]) socket().say(notice(n));
  assert.deepEqual(
    told.events.map((event) => event.n),
    [4, 5, 6, 7],
  );
});

test("what an old socket says after it was given up counts for nothing", () => {
  const { sockets, socket, wake, welcome, told } = setUp();
  welcome();
  const [old] = sockets;
  socket().drop();
  wake();
  old?.say(notice(9));
  old?.drop();
  assert.equal(told.events.length, 0);
  assert.equal(sockets.length, 2);
});

test("commands are answered by number, whatever the order", async () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const first = link.command("hide", { parts: [1] });
  const second = link.ask("ray", { origin: [0, 0, 0], direction: [0, 0, 1] });
  const [a, b] = socket().sent.slice(-2);
  assert.deepEqual([a?.kind, a?.name, b?.kind], ["command", "hide", "ask"]);
  socket().say({ kind: "reply", id: b?.id, ok: true, result: null });
  socket().say({
    kind: "reply",
    id: a?.id,
    ok: false,
    error: { what: "no part 1", where: "hide", do: "name another" },
  });
  assert.equal(await second, null);
  await assert.rejects(first, (error: LinkError) => {
    assert.equal(error.message, "no part 1. name another");
    return error.where === "hide";
  });
});

test("what waits when the link breaks fails, and so does what is asked meanwhile", async () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const waiting = link.command("grip", { parts: [1] });
  socket().drop();
  await assert.rejects(waiting, /broke before the answer/);
  await assert.rejects(link.command("release"), /no connection/);
});

test("a page too many says so, and tries again when it is asked to", () => {
  const { link, sockets, socket, told } = setUp();
  socket().open();
  socket().drop(4002);
  assert.deepEqual(told.status, ["full"]);
  assert.equal(sockets.length, 1, "not by itself");
  link.retryNow();
  assert.equal(sockets.length, 2);
});

test("files go out in pieces, each answered before it counts as sent", async () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const number = link.sendFiles("open", [{ name: "a.stl", bytes: 3 }]);
  const asked = socket().last() as { id: number };
  assert.deepEqual(asked, { kind: "send_files", id: asked.id, purpose: "open", files: [{ name: "a.stl", bytes: 3 }] });
  socket().say({ kind: "reply", id: asked.id, ok: true, result: { files: 7 } });
  assert.equal(await number, 7);
  const sent = link.sendPiece(7, 0, Uint8Array.of(1, 2, 3));
  const piece = decodeBinary(socket().binary[0] ?? new ArrayBuffer(8)) as { id: number; data: Uint8Array };
  assert.deepEqual([...piece.data], [1, 2, 3]);
  socket().say({
    kind: "reply",
    id: piece.id,
    ok: false,
    error: { what: "the disk is full", where: "open", do: "free some" },
  });
  await assert.rejects(sent, /the disk is full/);
});

test("a job tells how far it is, and can be given up", async () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const shares: number[] = [];
  const job = link.job("export_glb", {}, (share) => shares.push(share));
  socket().say({ kind: "progress", id: job.id, share: 0.5, stage: "writing" });
  job.cancel();
  assert.deepEqual(socket().last(), { kind: "cancel", id: job.id });
  socket().say({ kind: "reply", id: job.id, ok: true, result: { name: "a.glb" } });
  assert.deepEqual(await job.result, { name: "a.glb" });
  job.cancel();
  assert.equal(
    socket().sent.filter((message) => message.kind === "cancel").length,
    1,
    "what is done cannot be given up",
  );
  assert.deepEqual(shares, [0.5]);
});

test("each state is acknowledged as it comes", () => {
  const { socket, welcome, told } = setUp();
  welcome();
  for (const seq of [1, 2]) socket().say({ kind: "state", seq });
  assert.deepEqual(socket().sent.slice(1), [
    { kind: "ack", seq: 1 },
    { kind: "ack", seq: 2 },
  ]);
  assert.equal(told.states.length, 2);
});

test("wishes go out as binary frames with growing numbers", () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const wish = { pose: Array.from({ length: 16 }, (_, k) => k), source: "gizmo", time_ms: 12.5 } as const;
  assert.deepEqual([link.pose(wish), link.pose(wish)], [1, 2]);
  const frame = socket().binary[0] ?? new ArrayBuffer(8);
  const size = new DataView(frame).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(frame, 8, size)));
  assert.deepEqual([header.kind, header.seq, header.source, header.time_ms], ["pose", 1, "gizmo", 12.5]);
  assert.deepEqual([...new Float64Array(frame, 8 + size, 16)], wish.pose);
});

test("a page that is not allowed, or too old, does not try again", () => {
  for (const [code, status] of [
    [1008, "refused"],
    [4001, "outdated"],
  ] as const) {
    const { socket, told, delays } = setUp();
    socket().open();
    socket().drop(code);
    assert.deepEqual(told.status, [status]);
    assert.deepEqual(delays, []);
  }
});

test("a page that was too busy to say hello in time tries again, and only then", () => {
  const { socket, wake, told, delays, clock } = setUp();
  clock.now = 2500;
  socket().open();
  socket().drop(1008);
  assert.deepEqual([told.status, delays], [["lost"], [200]]);
  wake();
  clock.now += 100;
  socket().open();
  socket().drop(1008);
  assert.deepEqual([told.status, delays], [["lost", "refused"], [200]]);
});

test("a frame that is none closes the socket, and a new one is opened", () => {
  const { socket, sockets, wake, welcome, told } = setUp();
  welcome();
  const first = socket();
  first.sayRaw("{ no JSON");
  assert.equal(first.closed, 1000);
  assert.deepEqual(told.status, ["open", "lost"]);
  wake();
  assert.equal(sockets.length, 2);
});

test("a large picture goes out in pieces", () => {
  const { link, socket, welcome } = setUp();
  welcome();
  const png = "abcd".repeat(200_000);
  link.shot(3, "shot-3", png);
  const pieces = socket().sent.filter((message) => message.kind === "shot");
  assert.deepEqual(
    pieces.map((piece) => piece.more),
    [true, false],
  );
  assert.equal(pieces.map((piece) => piece.png_base64).join(""), png);
  assert.ok(
    pieces.every((piece) => String(piece.png_base64).length % 4 === 0 && JSON.stringify(piece).length < 1 << 20),
  );
});

test("a link that was closed stays closed", () => {
  const { link, sockets, wake } = setUp();
  link.close();
  link.connect();
  wake();
  assert.equal(sockets.length, 1);
});

test("the token is taken out of the address and kept for a reload of the tab", () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
  };
  const shown: unknown[] = [];
  const history = { replaceState: (_data: unknown, _unused: string, url?: string | URL | null) => shown.push(url) };
  assert.equal(takeToken({ hash: "#t=abc", pathname: "/", search: "?x" }, history, storage), "abc");
  assert.deepEqual(shown, ["/?x"]);
  assert.equal(takeToken({ hash: "", pathname: "/", search: "" }, history, storage), "abc");
  kept.clear();
  assert.equal(takeToken({ hash: "", pathname: "/", search: "" }, history, storage), null);
});

test("a server that hangs is noticed within seconds, and its return as well", () => {
  const { socket, welcome, told, pass, looks, link } = setUp();
  pass(60);
  assert.deepEqual(told.silence, [], "before the welcome there is nothing to hear");
  welcome();
  pass(2);
  assert.equal(socket().last().kind, "ping");
  const { id } = socket().last();
  pass(3);
  assert.deepEqual(told.silence, []);
  pass(1);
  assert.deepEqual(told.silence, [true], "six seconds after the last message");
  pass(30);
  assert.equal(socket().sent.filter(({ kind }) => kind === "ping").length, 1, "one question is enough");
  socket().say({ kind: "reply", id, ok: true, result: {} });
  assert.deepEqual([told.silence, told.status], [[true, false], ["open"]]);
  link.close();
  assert.equal(looks.size, 0);
});

test("what answers, slowly or to anything, is not silent; nor is it while the page slept", () => {
  const { socket, welcome, told, pass, clock, looks } = setUp();
  welcome();
  for (let k = 0; k < 20; k++) {
    pass(3);
    socket().say({ kind: "people", you: 1, people: [], turn: {} });
  }
  pass(3);
  for (let k = 0; k < 5; k++) {
    clock.now += 60_000;
    for (const look of [...looks]) look();
  }
  assert.deepEqual(told.silence, []);
  pass(5);
  assert.deepEqual(told.silence, [true], "awake again it asks anew");
  socket().drop();
  assert.deepEqual([told.silence.at(-1), looks.size], [false, 0], "the link is lost: that is what is said");
});
