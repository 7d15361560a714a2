// The workbench, on which commands, pointers and panels act: it joins the store, the stage, the hand and the link.

import { type Job, type Link, LinkError } from "../link/link";
import type { CommandRequest, Document, Jobs, Questions, UpAxis } from "../link/protocol";
import { Turns } from "../link/turns";
import { carry, type Pose } from "../math/matrix";
import { type Box, corners, emptyBox, include, isEmpty, subtract, type Vec3 } from "../math/vectors";
import type { Hand } from "../model/hand";
import { OfflineCommands } from "../model/offline-commands";
import type { Store } from "../model/store";
import type { CameraRig } from "../scene/camera";
import type { Stage } from "../scene/stage";

/** How long the view glides. */
const GLIDE_MS = 250;

/** How a click changes the selection. */
export type SelectHow = "only" | "toggle" | "add";

/** Work of the page that takes a while. */
export interface LocalJob {
  is_cancelled: boolean;
  tell(share: number): void;
  end(): void;
}

export interface WorkbenchParts {
  readonly store: Store;
  readonly stage: Stage;
  readonly hand: Hand;
  /** Null: a page without a server. */
  readonly link: Link | null;
  /** Asks for a frame. */
  readonly redraw: () => void;
  /** Fetches a file written by a job. */
  readonly fetchFile: (name: string) => Promise<Blob>;
}

export class Workbench {
  readonly store: Store;
  readonly stage: Stage;
  readonly hand: Hand;
  readonly link: Link | null;
  readonly redraw: () => void;
  readonly fetchFile: (name: string) => Promise<Blob>;
  /** Fetches the swept volume of a card; null without a server. */
  fetchRoom: ((card: number) => Promise<ArrayBuffer>) | null = null;
  private readonly offline = new OfflineCommands();
  private readonly turns: Turns;
  /** The canvas, to which the focus goes back; null in tests. */
  canvas: HTMLElement | null = null;
  /** Opens or closes WebXR; null where the browser has none. */
  toggleXr: (() => void) | null = null;
  /** Asks for a SpaceMouse; null where the browser has no WebHID. */
  connectSpaceMouse: (() => void) | null = null;

  constructor(parts: WorkbenchParts) {
    this.store = parts.store;
    this.stage = parts.stage;
    this.hand = parts.hand;
    this.link = parts.link;
    this.redraw = parts.redraw;
    this.fetchFile = parts.fetchFile;
    const { hand } = parts;
    this.turns = new Turns({ isOpen: () => hand.isPutting, end: () => hand.finish() });
  }

  get document(): Document | null {
    return this.store.document.peek();
  }

  /** A change that was requested is not in the document yet. */
  get isBusy(): boolean {
    return this.turns.isBusy;
  }

  /** Sends a command in its turn; returns whether it was done. A refusal is a notice until the command is done. */
  async run(...request: CommandRequest): Promise<boolean> {
    const [command] = request;
    const refused = this.store.notices.peek().filter(({ of }) => of === command);
    try {
      await this.send(...request);
      for (const { id } of refused) this.store.dismiss(id);
      return true;
    } catch (error) {
      this.tell(error, command);
      return false;
    }
  }

  /** Sends the changes that `choose` makes of the document, once all earlier requests are in it; whether it was done. */
  runOf(choose: (document: Document) => readonly CommandRequest[]): Promise<boolean> {
    const work = async (): Promise<void> => {
      const { document } = this;
      if (document) await Promise.all(choose(document).map((request) => this.sendNow(request)));
    };
    return this.told(this.turns.take(work, true));
  }

  /** Ends once the hand rests and all requests up to now are in the document. */
  rest(): Promise<boolean> {
    return this.runOf(() => []);
  }

  /** The tool is put down at `pose`: before all that waits for it. */
  place(pose: Pose): Promise<boolean> {
    return this.told(this.turns.first(() => this.sendNow(["place", { pose }])));
  }

  /** Actions that waited for the tool to be put down go on. */
  goOn(): void {
    this.turns.go();
  }

  /** Sends a command in its turn; rejects if it is refused. Without a server, visibility is changed here. */
  send(...request: CommandRequest): Promise<unknown> {
    return this.turns.take(() => this.sendNow(request));
  }

  /** Whether it was done; what went wrong is shown. */
  async told(done: Promise<unknown>): Promise<boolean> {
    try {
      await done;
      return true;
    } catch (error) {
      this.tell(error);
      return false;
    }
  }

  private sendNow(request: CommandRequest): Promise<unknown> {
    if (this.link) return this.link.command(...request);
    const document = this.document;
    const looked = document && this.store.can_look.peek() ? this.offline.applied(document, request) : null;
    if (!looked) return Promise.reject(readOnly(request[0]));
    this.store.document.value = looked;
    return Promise.resolve(null);
  }

  ask<Name extends keyof Questions>(name: Name, args: Questions[Name]["args"]): Promise<Questions[Name]["answer"]> {
    return this.link?.ask(name, args) ?? Promise.reject(readOnly(name));
  }

  /** Starts a job and shows how far it is; null without a server. */
  job<Name extends keyof Jobs>(name: Name, args: Jobs[Name]["args"], title: string): Job<Jobs[Name]["answer"]> | null {
    if (!this.link) return null;
    const { jobs } = this.store;
    const job = this.link.job(name, args, (share) => {
      jobs.value = jobs.peek().map((each) => (each.id === job.id ? { ...each, share } : each));
    });
    jobs.value = [...jobs.peek(), { id: job.id, title, share: 0, cancel: () => job.cancel() }];
    const end = (): void => {
      jobs.value = jobs.peek().filter((each) => each.id !== job.id);
    };
    job.result.then(end, end);
    return job;
  }

  /** Shows work of the page itself among the jobs, until `end`. */
  local(title: string): LocalJob {
    const { jobs } = this.store;
    // Numbers of the server's jobs are positive.
    const id = Math.min(0, ...jobs.peek().map((each) => each.id)) - 1;
    const job: LocalJob = {
      is_cancelled: false,
      tell: (share) => {
        jobs.value = jobs.peek().map((each) => (each.id === id ? { ...each, share } : each));
      },
      end: () => {
        jobs.value = jobs.peek().filter((each) => each.id !== id);
      },
    };
    const cancel = (): void => {
      job.is_cancelled = true;
    };
    jobs.value = [...jobs.peek(), { id, title, share: 0, cancel }];
    return job;
  }

  /** Shows what went wrong; `of`: the command that was refused. */
  tell(error: unknown, of?: string): void {
    const { people } = this.store;
    if (error instanceof LinkError && error.where === "tool" && people.is_barred.peek()) {
      people.tried();
      return;
    }
    this.store.notify("error", saidOf(error), of);
  }

  /** The parts that a command is about: the selected ones, else the one under the pointer. */
  targets(): number[] {
    const selected = [...this.store.selection.peek()];
    if (selected.length > 0) return selected;
    const hover = this.store.hover.peek();
    return hover >= 0 ? [hover] : [];
  }

  select(parts: Iterable<number>, how: SelectHow = "only"): void {
    const { selection } = this.store;
    const next = new Set(how === "only" ? [] : selection.peek());
    const given = [...parts];
    const isTaking = how !== "toggle" || given.some((part) => !next.has(part));
    for (const part of given) {
      if (isTaking) next.add(part);
      else next.delete(part);
    }
    selection.value = next;
    if (given.length > 0 && next.size > 0)
      this.say(next.size === 1 ? this.path(given[0] ?? -1) : `${next.size} parts selected`);
    this.redraw();
  }

  path(part: number): string {
    return this.store.paths.peek()[part] ?? `part ${part}`;
  }

  /** Tells the live region. */
  say(text: string): void {
    this.store.spoken.value = text;
  }

  /** Frames the parts, or everything visible if there are none. */
  fit(parts: readonly number[] = this.visible([...this.store.selection.peek()])): void {
    const box = this.boxOf(parts);
    this.look((camera) => camera.fit(isEmpty(box) ? this.stage.visibleBox() : box));
  }

  /** One of the seven views. */
  view(n: number): void {
    this.look((camera) => camera.view(n, this.stage.visibleBox(), this.up));
  }

  /** Looks at everything from a side: its parts to the right, to the back and up. */
  viewFrom(side: Vec3): void {
    this.look((camera) => camera.viewFrom(side, this.stage.visibleBox(), this.up));
  }

  /** Changes the camera: it glides there, where the user and the system let it. */
  look(change: (camera: CameraRig) => void): void {
    const { store } = this;
    const isStill = store.is_motion_reduced.peek() || !store.settings.peek().has_glide || globalThis.document?.hidden;
    this.stage.camera.glide(change, isStill ? 0 : GLIDE_MS);
    this.redraw();
  }

  /** The tool comes into the middle of the picture, which keeps its scale. */
  lookAtTool(): void {
    const { pivot, pose, tool } = this.hand;
    const at = tool ?? pose;
    if (at) this.look((camera) => camera.translate(subtract(carry(at, pivot), camera.target)));
  }

  /** The vertical of the mock-up. */
  get up(): UpAxis {
    return this.store.manifest.peek()?.up ?? "z";
  }

  /** Those of the parts that are in sight. */
  visible(parts: readonly number[]): number[] {
    const { hidden, absent } = this.store;
    const unseen = new Set([...hidden.peek(), ...absent.peek()]);
    return parts.filter((part) => !unseen.has(part));
  }

  /** The box of parts at their present places, or at others; empty for none. */
  boxOf(parts: readonly number[], places?: Readonly<Record<string, readonly number[]>>): Box {
    const box = emptyBox();
    const manifest = this.store.manifest.peek();
    const moved = places ?? this.document?.moved ?? {};
    for (const part of parts) {
      const lower = manifest?.parts.lower[part];
      const upper = manifest?.parts.upper[part];
      if (!lower || !upper || !(lower[0] <= upper[0])) continue;
      const pose = moved[part];
      for (const corner of corners({ lower, upper })) include(box, pose ? carry(pose, corner) : corner);
    }
    return box;
  }

  /** The world point under a pixel, else the point at the target's depth there. */
  pointAt(x: number, y: number): Vec3 {
    const picked = this.stage.pick(x, y);
    if (picked) return picked.point;
    const { camera } = this.stage;
    const { origin, direction } = camera.ray(x, y);
    const far = camera.reach;
    return [origin[0] + direction[0] * far, origin[1] + direction[1] * far, origin[2] + direction[2] * far];
  }
}

/** What went wrong, for people. */
export function saidOf(error: unknown): string {
  const text = error instanceof Error ? error.message : String(error);
  // Names of commands and of rooms of the program say nothing to people; places in what they gave do.
  const where = error instanceof LinkError && !/^[a-z_]*(, [a-z_]*)*$/.test(error.where) ? ` (${error.where})` : "";
  return sentences(text) + where;
}

/** With capitals, as messages of the server have none; a word that may be a name stays. */
export const sentences = (text: string): string =>
  text.replace(/(^|[.] )([a-z])(?=[a-z]*[ ,])/g, (_, before: string, letter: string) => before + letter.toUpperCase());

const readOnly = (name: string): LinkError =>
  new LinkError("this page is read-only", name, "Open the mock-up by `feeler view`");
