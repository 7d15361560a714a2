// The link to the server: one socket, opened again when it breaks.
//
// States: the newest wins, and each is acknowledged on arrival. Events are numbered: none is lost or repeated. Commands,
// questions and jobs are answered by number. Requests without an answer fail when the link breaks, because nobody knows
// whether they were done; the next welcome has the present state.

import { decodeFrame, encodeFrame } from "./frames";
import type { FilePurpose, FileToSend, OpenMockup } from "./openings";
import {
  type CommandRequest,
  type FromPage,
  type FromServer,
  type Here,
  type Jobs,
  type Joints,
  NOT_ALLOWED,
  type People,
  type Pose,
  PROTOCOL_VERSION,
  type Questions,
  RELOAD,
  type Seen,
  type ServerEvent,
  type Source,
  type State,
  TOO_MANY_PAGES,
  type TurnWish,
  type Welcome,
} from "./protocol";
import { BROWSER_TIMERS } from "./turns";

/** The error, its place and a remedy. */
export class LinkError extends Error {
  constructor(
    readonly what: string,
    readonly where = "",
    readonly advice = "",
  ) {
    super(advice ? `${what}. ${advice}` : what);
    this.name = "LinkError";
  }
}

export type LinkStatus = "connecting" | "open" | "lost" | "refused" | "full" | "outdated";

export interface LinkListener {
  onStatus(status: LinkStatus): void;
  /** Nothing comes any more over a link that is open; or something comes again, or the link broke. */
  onSilence(is_silent: boolean): void;
  /** Everything, after each connection: earlier state no longer counts. */
  onWelcome(welcome: Welcome): void;
  onState(state: State): void;
  onEvent(event: ServerEvent): void;
  /** Who is there, and who has the tool. */
  onPeople(people: People): void;
  /** Where another person points and looks. */
  onSeen(seen: Seen): void;
  /** Where the joints of the mechanism are shown, until the document says. */
  onJoints?(joints: Joints): void;
}

/** The part of a WebSocket that the link uses. */
export interface Socket {
  binaryType: string;
  onopen: ((event: never) => void) | null;
  onmessage: ((event: { data: string | ArrayBuffer }) => void) | null;
  onclose: ((event: { code: number }) => void) | null;
  send(data: string | ArrayBuffer): void;
  close(code?: number): void;
}

export interface LinkOptions {
  url: string;
  token: string;
  listener: LinkListener;
  open?: (url: string) => Socket;
  wait?: (callback: () => void, delay_ms: number) => number;
  stopWaiting?: (handle: number) => void;
  now?: () => number;
  /** Calls back every so often until the result is called. */
  every?: (callback: () => void, period_ms: number) => () => void;
}

/** Where the hand wants to be: the content of a pose message. */
export interface Wish {
  readonly pose: Pose;
  readonly source: Source;
  /** When the input that led to it happened (`performance.now()`). */
  readonly time_ms: number;
}

/** A job under way. */
export interface Job<Answer = unknown> {
  readonly id: number;
  readonly result: Promise<Answer>;
  cancel(): void;
}

interface Waiting {
  resolve(result: unknown): void;
  reject(error: LinkError): void;
  onProgress?: ((share: number, stage: string) => void) | undefined;
}

const FIRST_DELAY_MS = 200;
/** Slowly enough that a cut of two seconds is over within another one. */
const DELAY_GROWTH = 1.5;
const MOST_DELAY_MS = 5000;
/** The server waits two seconds for hello: one that came later was refused for that, and not for its content. */
const LATE_MS = 1500;
/** Of a picture in one message; a multiple of 4, so that each piece is base64 by itself. */
const SHOT_CHARACTERS = 1 << 19;
/** So often the link looks whether anything came. */
const LOOK_MS = 1000;
/** After so long without a message it asks whether anybody is there. */
const QUIET_MS = 2000;
/** And so long after that question nobody is. */
const SILENT_MS = 4000;
const LOST = new LinkError("the connection broke before the answer came", "", "Check the result, and try again");

export class Link {
  status: LinkStatus = "connecting";
  private readonly options: Required<LinkOptions>;
  private socket: Socket | null = null;
  private session: string | null = null;
  private last_event = 0;
  private delay_ms = FIRST_DELAY_MS;
  private retry: number | null = null;
  private next_id = 1;
  private next_seq = 1;
  private isClosed = false;
  private isLate = false;
  private is_silent = false;
  private heard_ms = 0;
  private looked_ms = 0;
  private pinged_ms: number | null = null;
  private endLooks: (() => void) | null = null;
  private readonly waiting = new Map<number, Waiting>();

  constructor(options: LinkOptions) {
    this.options = {
      open: (url) => new WebSocket(url) as unknown as Socket,
      wait: BROWSER_TIMERS.set,
      stopWaiting: BROWSER_TIMERS.clear,
      now: () => performance.now(),
      every: (callback, period_ms) => {
        const timer = setInterval(callback, period_ms);
        return () => clearInterval(timer);
      },
      ...options,
    };
  }

  connect(): void {
    if (this.socket || this.isClosed) return;
    this.retry = null;
    const asked_ms = this.options.now();
    const socket = this.options.open(this.options.url);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      // A page that was busy, compiling its shaders on a slow machine.
      this.isLate = this.options.now() - asked_ms > LATE_MS;
      this.send(socket, this.hello());
    };
    socket.onmessage = (event) => {
      if (socket === this.socket) this.receive(event.data);
    };
    socket.onclose = (event) => {
      if (socket === this.socket) this.lose(event.code);
    };
  }

  /** Tries at once instead of after the delay. */
  retryNow(): void {
    if (this.retry === null && this.status !== "full") return;
    if (this.retry !== null) this.options.stopWaiting(this.retry);
    this.connect();
  }

  close(): void {
    this.isClosed = true;
    if (this.retry !== null) this.options.stopWaiting(this.retry);
    this.socket?.close(1000);
    this.socket = null;
    this.watch(false);
    this.failAll();
  }

  /** Sends the hand's wish; its number, or null where the link is down. */
  pose(wish: Wish): number | null {
    const socket = this.open;
    if (!socket) return null;
    const seq = this.next_seq++;
    const { pose, source, time_ms } = wish;
    this.send(socket, { kind: "pose", seq, time_ms, source, pose: Float64Array.from(pose) });
    return seq;
  }

  /** Changes the document. Rejects with a `LinkError` where the server refuses. */
  command(...[name, args]: CommandRequest): Promise<unknown> {
    return this.request("command", name, args).result;
  }

  /** Asks what changes nothing. */
  ask<Name extends keyof Questions>(name: Name, args: Questions[Name]["args"]): Promise<Questions[Name]["answer"]> {
    return this.request<Questions[Name]["answer"]>("ask", name, args).result;
  }

  /** Starts what takes a while. */
  job<Name extends keyof Jobs>(
    name: Name,
    args: Jobs[Name]["args"],
    onProgress?: (share: number, stage: string) => void,
  ): Job<Jobs[Name]["answer"]> {
    const { id, result } = this.request<Jobs[Name]["answer"]>("job", name, args, onProgress);
    const cancel = (): void => {
      if (this.waiting.has(id) && this.socket) this.send(this.socket, { kind: "cancel", id });
    };
    return { id, result, cancel };
  }

  /** Announces files; resolves with their number. */
  async sendFiles(purpose: FilePurpose, files: readonly FileToSend[]): Promise<number> {
    const { result } = this.expect<{ files: number }>((id) => ({ kind: "send_files", id, purpose, files }), "open");
    return (await result).files;
  }

  /** Sends the next bytes of an announced file; resolves once they are kept. */
  async sendPiece(files: number, file: number, data: Uint8Array): Promise<void> {
    await this.expect((id) => ({ kind: "file_piece", id, files, file, data }), "open").result;
  }

  /** Opens another mock-up. Its progress is in the document. */
  async openMockup(what: Omit<OpenMockup, "kind" | "id">): Promise<void> {
    await this.expect((id) => ({ kind: "open_mockup", id, ...what }), "open").result;
  }

  /** Answers the server's wish for a picture, in pieces that a message may have. */
  shot(id: number, name: string, png_base64: string): void {
    const socket = this.open;
    if (!socket) return;
    for (let from = 0; ; from += SHOT_CHARACTERS) {
      const more = from + SHOT_CHARACTERS < png_base64.length;
      const piece = png_base64.slice(from, from + SHOT_CHARACTERS);
      this.send(socket, { kind: "shot", id, name, png_base64: piece, more });
      if (!more) return;
    }
  }

  /** Tells the name of the person at this page. */
  name(name: string): void {
    const socket = this.open;
    if (socket) this.send(socket, { kind: "name", name });
  }

  /** Tells where the person at this page points and looks. */
  here(here: Omit<Here, "kind">): void {
    const socket = this.open;
    if (socket) this.send(socket, { kind: "here", ...here });
  }

  /** Takes the tool, asks for it, or gives it. Rejects with a `LinkError` where that cannot be. */
  async turn(wish: TurnWish, to: number | null = null): Promise<void> {
    await this.expect((id) => ({ kind: "turn", id, wish, to }), "tool").result;
  }

  /** Answers the server's wish for figures. */
  benchmarked(id: number, figures: Record<string, unknown>): void {
    const socket = this.open;
    if (socket) this.send(socket, { kind: "benchmarked", id, figures });
  }

  /** The socket of a connection that was welcomed; null: there is none. */
  private get open(): Socket | null {
    return this.status === "open" ? this.socket : null;
  }

  private hello() {
    const { token } = this.options;
    return {
      kind: "hello",
      protocol: PROTOCOL_VERSION,
      token,
      session: this.session,
      last_event: this.last_event,
    } as const;
  }

  /** protocol.py defines the answers. */
  private request<Answer>(
    kind: "command" | "ask" | "job",
    name: string,
    args: object = {},
    onProgress?: (share: number, stage: string) => void,
  ): { id: number; result: Promise<Answer> } {
    return this.expect((id) => ({ kind, id, name, args: { ...args } }), name, onProgress);
  }

  /** Sends a message that a reply with its number answers. */
  private expect<Answer>(
    message: (id: number) => FromPage,
    name: string,
    onProgress?: (share: number, stage: string) => void,
  ): { id: number; result: Promise<Answer> } {
    const id = this.next_id++;
    const socket = this.open;
    if (!socket) {
      const error = new LinkError("there is no connection to the engine", name, "The page reconnects by itself");
      return { id, result: Promise.reject(error) };
    }
    const result = new Promise<Answer>((resolve, reject) => {
      this.waiting.set(id, { resolve: resolve as Waiting["resolve"], reject, onProgress });
    });
    this.send(socket, message(id));
    return { id, result };
  }

  private send(socket: Socket, message: FromPage): void {
    socket.send(encodeFrame(message));
  }

  /** Looks for silence from now on, or no longer. */
  private watch(isOpen: boolean): void {
    this.endLooks?.();
    this.endLooks = null;
    this.heard();
    if (!isOpen) return;
    this.looked_ms = this.heard_ms;
    this.endLooks = this.options.every(() => this.look(), LOOK_MS);
  }

  private heard(): void {
    this.heard_ms = this.options.now();
    this.pinged_ms = null;
    this.setSilent(false);
  }

  private look(): void {
    const now = this.options.now();
    const isAwake = now - this.looked_ms < 2 * LOOK_MS;
    this.looked_ms = now;
    // A page that was asleep or hidden has not listened: its silence says nothing.
    if (!isAwake) this.pinged_ms = null;
    if (this.pinged_ms !== null) {
      if (now - this.pinged_ms >= SILENT_MS) this.setSilent(true);
    } else if (this.socket && now - this.heard_ms >= QUIET_MS) {
      this.pinged_ms = now;
      this.send(this.socket, { kind: "ping", id: this.next_id++ });
    }
  }

  private setSilent(is_silent: boolean): void {
    if (is_silent === this.is_silent) return;
    this.is_silent = is_silent;
    this.options.listener.onSilence(is_silent);
  }

  private receive(data: string | ArrayBuffer): void {
    this.heard();
    let message: FromServer;
    try {
      message = decodeFrame(data);
    } catch {
      // The other side is not a server of this protocol: a new connection starts from a whole document.
      this.restart();
      return;
    }
    switch (message.kind) {
      case "state":
        if (this.socket) this.send(this.socket, { kind: "ack", seq: message.seq });
        // Wishes of others count as well: an answer to theirs is none to ours.
        this.next_seq = Math.max(this.next_seq, message.pose_seq + 1);
        this.options.listener.onState(message);
        break;
      case "event":
        this.receiveEvent(message);
        break;
      case "people":
        this.options.listener.onPeople(message);
        break;
      case "seen":
        this.options.listener.onSeen(message);
        break;
      case "joints":
        this.options.listener.onJoints?.(message);
        break;
      case "progress":
        this.waiting.get(message.id)?.onProgress?.(message.share, message.stage);
        break;
      case "reply":
        this.receiveReply(message);
        break;
      case "welcome":
        this.session = message.session;
        this.isLate = false;
        this.last_event = message.event;
        this.delay_ms = FIRST_DELAY_MS;
        this.options.listener.onWelcome(message);
        this.setStatus("open");
        this.watch(true);
        break;
    }
  }

  private receiveEvent(event: ServerEvent): void {
    if (event.n <= this.last_event) return;
    this.last_event = event.n;
    this.options.listener.onEvent(event);
  }

  private receiveReply(reply: Extract<FromServer, { kind: "reply" }>): void {
    if (reply.id === null) return;
    const waiting = this.waiting.get(reply.id);
    this.waiting.delete(reply.id);
    if (reply.ok) waiting?.resolve(reply.result);
    else waiting?.reject(new LinkError(reply.error.what, reply.error.where, reply.error.do));
  }

  private restart(): void {
    const socket = this.socket;
    this.lose(1006);
    socket?.close(1000);
  }

  private lose(code: number): void {
    this.socket = null;
    this.failAll();
    if (code === RELOAD) this.setStatus("outdated");
    else if (code === TOO_MANY_PAGES) this.setStatus("full");
    else if (code === NOT_ALLOWED && !this.isLate) this.setStatus("refused");
    else {
      this.setStatus("lost");
      this.retry = this.options.wait(() => this.connect(), this.delay_ms);
      this.delay_ms = Math.min(DELAY_GROWTH * this.delay_ms, MOST_DELAY_MS);
    }
    this.watch(false);
  }

  private failAll(): void {
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const each of waiting) each.reject(LOST);
  }

  private setStatus(status: LinkStatus): void {
    if (status === this.status) return;
    this.status = status;
    this.options.listener.onStatus(status);
  }
}

const TOKEN_KEY = "feeler.token";

/**
 * The token of the address's fragment (`#t=...`), which is taken out of the address and kept for reloads of this tab.
 *
 * Null where there was none: the page was opened by another address than the one that was printed.
 */
export function takeToken(
  location: Pick<Location, "hash" | "pathname" | "search">,
  history: Pick<History, "replaceState">,
  storage: Pick<Storage, "getItem" | "setItem">,
): string | null {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return storage.getItem(TOKEN_KEY);
  storage.setItem(TOKEN_KEY, token);
  history.replaceState(null, "", location.pathname + location.search);
  return token;
}
