// What the page shows of findings: the list, its filter, the current one, and how it is looked at.

import { computed, type ReadonlySignal, signal } from "@preact/signals";
import type { Document, Findings } from "../link/protocol";
import { isSame } from "../math/same";
import type { Vec3 } from "../math/vectors";
import { ALL, type Finding, type FindingFilter, type FindingList, NONE_SHOWN, shownFindings } from "./findings";

/** A finding in the picture: its parts in two colours, all else faint. It changes no document, and undo knows nothing. */
export interface Focus {
  readonly finding: Finding;
  readonly parts: readonly number[];
  /** The part around the other one: it is see-through. */
  readonly cover: number | null;
  readonly points: readonly Vec3[];
  /** From a point, the way out of the other part. */
  readonly arrow: readonly [Vec3, Vec3] | null;
}

/** A dialog for "ignore like this". */
export interface Ignoring {
  readonly name: string;
  readonly a: string;
  readonly b: string;
  /** How many findings it hides; null: not known yet. */
  readonly count: number | null;
  readonly trouble: string | null;
}

export class FindingState {
  /** The rows; null: none are open, or they are on their way. */
  readonly list = signal<FindingList | null>(null);
  readonly failed = signal<string | null>(null);
  /** The id of the current one. */
  readonly current = signal<string | null>(null);
  /** Chosen in the list, with Shift and Ctrl: rows of `list`. */
  readonly chosen = signal<ReadonlySet<number>>(new Set());
  readonly filter = signal<FindingFilter>(ALL);
  readonly folded = signal<ReadonlySet<string>>(new Set());
  readonly focus = signal<Focus | null>(null);
  readonly ignoring = signal<Ignoring | null>(null);
  readonly are_settings_open = signal(false);
  readonly are_requirements_open = signal(false);
  readonly facts: ReadonlySignal<Findings | null>;
  /** The findings of the present list: while another one is on its way there are none. */
  readonly shown = computed(() => {
    const [list, findings] = [this.list.value, this.facts.value];
    if (!list || findings?.version !== list.version) return NONE_SHOWN;
    return shownFindings(list, findings, this.filter.value, this.folded.value);
  });
  /** The current one's row; -1: none. */
  readonly row = computed(() => this.list.value?.rowOf(this.current.value) ?? -1);
  /** The check was of parts that lie elsewhere now. */
  readonly is_stale: ReadonlySignal<boolean>;

  constructor(document: ReadonlySignal<Document | null>) {
    this.facts = computed(() => document.value?.findings ?? null);
    this.is_stale = computed(() => {
      const [check, now] = [document.value?.findings?.check, document.value];
      if (!check || !now) return false;
      const before = [Object.entries(check.moved), check.out, check.gripped];
      return !isSame(before, [Object.entries(now.moved), now.out, now.gripped]);
    });
  }

  private looks = 0;
  private is_asking = false;

  /** A look at a finding begins, before the server has said from where; the number is for `isLook`. */
  beginLook(): number {
    this.is_asking = true;
    return ++this.looks;
  }

  /** Whether the look of that number still counts. */
  isLook(number: number): boolean {
    const is_mine = number === this.looks;
    if (is_mine) this.is_asking = false;
    return is_mine;
  }

  /** All looks as before. */
  endLook(): void {
    this.looks++;
    this.is_asking = false;
    this.focus.value = null;
  }

  /** A finding is looked at, or is about to be. */
  get isLooking(): boolean {
    return this.is_asking || this.focus.peek() !== null;
  }

  set(changes: Partial<FindingFilter>): void {
    this.filter.value = { ...this.filter.peek(), ...changes };
  }

  /** Folds a group, or opens it. */
  fold(key: string): void {
    const folded = new Set(this.folded.peek());
    if (!folded.delete(key)) folded.add(key);
    this.folded.value = folded;
  }
}
