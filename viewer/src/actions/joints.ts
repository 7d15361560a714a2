// Joints: moves them as far as contact lets them, shows their worst position, and opens mechanisms.

import type { JointPlace } from "../link/protocol";
import { type JointNumber, numberOf, partsOf } from "../model/joints";
import { chooseFile } from "./choosing";
import type { Workbench } from "./workbench";

/** A slider that rests so long after a key is where it was to go. */
const SETTLE_MS = 350;
/** Characters of a file: more are not read. */
const MOST_BYTES = 100_000;

/** What the mover needs of a workbench. */
export interface MoverLink {
  /** Shows a joint at a value, as far as contact lets it; null: where it stands. */
  to(name: string, value: number | null): Promise<JointPlace>;
  /** Puts it there, as a step of undo. */
  move(name: string, value: number): Promise<unknown>;
  fail(error: unknown): void;
}

interface Timers {
  set(run: () => void, delay_ms: number): number;
  clear(timer: number): void;
}

const TIMERS: Timers = {
  set: (run, delay_ms) => setTimeout(run, delay_ms) as unknown as number,
  clear: (timer) => clearTimeout(timer),
};

/** Moves one joint at a time. One question is on its way, and of those that wait only the newest of each joint counts: a
 * slow link or a slow server is behind, and never jammed. */
export class JointMover {
  /** The joint that is moved and not put down yet; null: none. */
  name: string | null = null;
  private wanted: number | null = null;
  private placed: number | null = null;
  /** Where it is to go, or has got to if no answer is on its way. */
  private aim: number | null = null;
  /** Joints to be put down before that one, and where they were to go: another was moved before they got there. */
  private owed: { readonly name: string; readonly value: number }[] = [];
  private isAsking = false;
  private isSettling = false;
  private timer: number | null = null;
  private readonly resting: (() => void)[] = [];

  constructor(
    private readonly link: MoverLink,
    private readonly told: (place: JointPlace) => void = () => {},
    private readonly timers: Timers = TIMERS,
  ) {}

  /** The joint is to go to a value. */
  to(name: string, value: number): void {
    this.stopTimer();
    if (this.name !== null && this.name !== name) this.owe();
    this.owed = this.owed.filter((each) => each.name !== name);
    this.name = name;
    this.wanted = this.aim = value;
    this.isSettling = false;
    void this.ask();
  }

  /** Where a joint is to go, while it moves; null: it stands. */
  wantedOf(name: string): number | null {
    return this.name === name ? this.aim : (this.owed.find((each) => each.name === name)?.value ?? null);
  }

  /** Ends once no joint moves any more, and each is put down. */
  rest(): Promise<void> {
    return new Promise((resolve) => {
      this.resting.push(resolve);
      this.tellRest();
    });
  }

  private tellRest(): void {
    if (this.isAsking || this.name !== null || this.owed.length > 0) return;
    for (const resolve of this.resting.splice(0)) resolve();
  }

  private owe(): void {
    if (this.name !== null && this.aim !== null) this.owed.push({ name: this.name, value: this.aim });
    this.placed = null;
  }

  /** It is put down where it has got to: at once, or after it has rested. */
  settle(isLater = false): void {
    this.stopTimer();
    if (this.name === null) return;
    if (isLater) {
      this.timer = this.timers.set(() => this.settle(), SETTLE_MS);
      return;
    }
    this.isSettling = true;
    void this.ask();
  }

  /** It goes back to where it was. Whether there was anything to cancel. */
  cancel(): boolean {
    this.stopTimer();
    const { name } = this;
    if (name === null) return false;
    this.name = this.wanted = this.placed = null;
    this.isSettling = false;
    void this.link.to(name, null).then(this.told, (error) => this.link.fail(error));
    this.tellRest();
    return true;
  }

  private async ask(): Promise<void> {
    if (this.isAsking) return;
    this.isAsking = true;
    try {
      if (this.owed.length > 0) await this.putOwed();
      while (this.name !== null && this.wanted !== null) {
        const [name, value] = [this.name, this.wanted];
        this.wanted = null;
        const place = await this.link.to(name, value);
        if (this.name !== name) {
          // It was cancelled meanwhile, and the answer came late: it is shown where it stands.
          if (this.name === null) this.told(await this.link.to(name, null));
          await this.putOwed();
          continue;
        }
        this.placed = place.value;
        if (this.wanted === null) this.aim = place.value;
        this.told(place);
      }
      if (this.isSettling && this.name !== null && this.placed !== null) {
        const [name, value] = [this.name, this.placed];
        this.name = this.placed = null;
        this.isSettling = false;
        await this.link.move(name, value);
      }
    } catch (error) {
      this.name = this.wanted = this.placed = null;
      this.isSettling = false;
      this.link.fail(error);
    } finally {
      this.isAsking = false;
    }
    if (this.owed.length > 0 || this.wanted !== null || (this.isSettling && this.name !== null && this.placed !== null))
      void this.ask();
    else this.tellRest();
  }

  private async putOwed(): Promise<void> {
    for (let next = this.owed[0]; next; next = this.owed[0]) {
      try {
        const place = await this.link.to(next.name, next.value);
        this.told(place);
        await this.link.move(next.name, place.value);
      } catch (error) {
        this.link.fail(error);
      }
      this.owed = this.owed.filter((each) => each !== next);
    }
  }

  private stopTimer(): void {
    if (this.timer !== null) this.timers.clear(this.timer);
    this.timer = null;
  }
}

const movers = new WeakMap<Workbench, JointMover>();

/** The mover of a workbench. */
export function moverOf(wb: Workbench): JointMover {
  const known = movers.get(wb);
  if (known) return known;
  const { store } = wb;
  const mover = new JointMover(
    {
      to: (name, value) => wb.ask("joint_to", { name, value }),
      // What stands there already is no step of undo.
      move: (name, value) =>
        wb.document?.mechanism?.values[name] === value
          ? wb.ask("joint_to", { name, value: null })
          : wb.run("joint_move", { name, value }),
      fail: (error) => {
        store.joints_shown.value = null;
        wb.tell(error);
      },
    },
    (place) => {
      const before = store.joint_place.peek();
      store.joint_place.value = place;
      const { name, stop, value } = place;
      if (stop && !(before?.stop && before.name === name && before.value === value))
        wb.say(stopText(place, (part) => wb.path(part)));
    },
  );
  movers.set(wb, mover);
  return mover;
}

/** Why a joint stops. */
export function stopText({ name, met, why }: JointPlace, path: (part: number) => string): string {
  if (met) return `${name} stops: ${path(met.part)} meets ${path(met.other)}`;
  return why || `${name} is at its limit`;
}

/** The joint by which a part of the picture can be dragged; null: none, or it cannot be moved now. */
export function draggableBy(wb: Workbench, part: number): JointNumber | null {
  const document = wb.document;
  if (!document?.mechanism || wb.store.is_read_only.peek() || wb.store.people.is_barred.peek()) return null;
  if (document.gripped.length > 0 || wb.store.film.peek()) return null;
  return numberOf(document.mechanism, part);
}

/** Puts a joint to a value that was typed; ends once it stands. */
export function typeJoint(wb: Workbench, name: string, value: number): Promise<void> {
  const mover = moverOf(wb);
  mover.to(name, value);
  mover.settle();
  return mover.rest();
}

/** Shows the worst position of a joint, see-through; a second call ends that. */
export function toggleWorst(wb: Workbench, name: string): void {
  const { joint_ghost } = wb.store;
  joint_ghost.value = joint_ghost.peek() === name ? null : name;
  wb.redraw();
}

/** Selects the parts of a joint, and looks at them. */
export function showJoint(wb: Workbench, number: JointNumber): void {
  const mechanism = wb.document?.mechanism;
  if (!mechanism) return;
  const parts = partsOf(mechanism, number);
  wb.select(parts);
  wb.fit(parts);
}

/** Selects the two parts that stop a joint, and looks at them. */
export function showMet(wb: Workbench, met: { readonly part: number; readonly other: number }): void {
  wb.select([met.part, met.other]);
  wb.fit([met.part, met.other]);
}

/** Lets the user choose a mechanism. */
export function chooseMechanism(wb: Workbench): void {
  chooseFile(".toml", (file) => openMechanism(wb, file));
}

export const isMechanism = (file: Pick<File, "name">): boolean => /\.toml$/i.test(file.name);

/** Whether a TOML file has rules for clash checks, and no mechanism. */
export const isRules = (text: string): boolean =>
  /^[ \t]*\[\[(rule|exclude)\]\]/m.test(text) && !/^[ \t]*\[\[joint\]\]/m.test(text);

/** Opens a mechanism that was chosen or dropped; rules for clash checks, too. */
export async function openMechanism(wb: Workbench, file: File): Promise<void> {
  if (file.size > MOST_BYTES) {
    wb.store.notify("error", `${file.name} is too long for a mechanism: name parts by patterns.`);
    return;
  }
  try {
    const text = await file.text();
    if (isRules(text)) {
      if (await wb.run("clash_settings", { rules: text })) wb.store.panel.value = "findings";
      return;
    }
    if (await wb.run("mechanism_open", { name: file.name, text })) wb.store.panel.value = "mechanism";
  } catch (error) {
    wb.tell(error);
  }
}

/** Keeps the position as steps of the sequence. */
export async function keepPosition(wb: Workbench): Promise<void> {
  if (await wb.run("joint_step")) wb.say("The position is in the sequence");
}

/** Takes the parts of a joint in the hand, on the joint. */
export async function takeJoint(wb: Workbench, name: string): Promise<void> {
  if (await wb.run("joint_take", { name })) wb.say("In the hand, on the joint: E puts it down");
}
