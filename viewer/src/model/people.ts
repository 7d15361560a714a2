// The people on the same project: who they are, where they point and look, and who has the tool.

import { batch, computed, signal } from "@preact/signals";
import type { People, Person, Seen, Turn } from "../link/protocol";
import { isSame } from "../math/same";

/** White letters on them are read in both themes, and they differ from panels of both. In the order of the style sheet. */
export const PERSON_COLOURS = [0xca2f8a, 0x1c8235, 0x8f51d6, 0xbd4e2c, 0x1e71cf, 0x72760d] as const;

/** The number of a person's colour in the table. */
export const numberOf = (colour: number): number => colour % PERSON_COLOURS.length;

/** The colour, 0xRRGGBB. */
export const colourOf = (colour: number): number => PERSON_COLOURS[numberOf(colour)] ?? PERSON_COLOURS[0];

const FREE: Turn = { kind: null, person: null, is_free: true, asked: [] };

/** All of it, for scripts. */
export interface PeopleShown {
  readonly you: number;
  readonly people: readonly Person[];
  readonly turn: Turn;
  readonly seen: readonly Seen[];
}

export class PeopleState {
  readonly you = signal(0);
  readonly people = signal<readonly Person[]>([]);
  readonly turn = signal<Turn>(FREE);
  /** What others show, by their number. */
  readonly seen = signal<ReadonlyMap<number, Seen>>(new Map());
  /** Somebody here wanted to move the tool, which another one has. */
  readonly has_tried = signal(false);

  readonly others = computed(() => this.people.value.filter((each) => each.id !== this.you.value));
  readonly is_mine = computed(() => this.turn.value.person === this.you.value);
  /** Somebody else has the tool. */
  readonly is_barred = computed(() => !this.turn.value.is_free && !this.is_mine.value);
  readonly has_asked = computed(() => this.turn.value.asked.includes(this.you.value));
  /** The name of who has the tool, for the beginning of a sentence; "": nobody. */
  readonly holder = computed(() => {
    const { kind, person } = this.turn.value;
    if (kind === null) return "";
    if (kind !== "page") return kind === "script" ? "A script" : "The device";
    return this.nameOf(person ?? 0);
  });
  /** Those who asked the holder. */
  readonly asking = computed(() =>
    this.is_mine.value ? this.people.value.filter(({ id }) => this.turn.value.asked.includes(id)) : [],
  );
  /** What each other person selected, in the order of `others`; those who are away count with nothing. */
  readonly selections = computed(() => {
    const next = this.others.value.map(({ id, is_away }) =>
      is_away ? [] : (this.seen.value.get(id)?.selection ?? []),
    );
    // Pointers move all the time: parts get other states only where a selection changed.
    if (!isSame(next, this.last_selections)) this.last_selections = next;
    return this.last_selections;
  });

  private last_selections: readonly (readonly number[])[] = [];

  /** Takes the news. The result: what to say to the person here, who asked for the tool that its holder keeps; or "". */
  take({ you, people, turn }: People): string {
    const before = this.turn.peek();
    const wasAsking = this.you.peek() === you && before.asked.includes(you);
    batch(() => {
      this.you.value = you;
      this.people.value = people;
      this.turn.value = turn;
      const there = new Set(people.map(({ id }) => id));
      const seen = [...this.seen.peek()].filter(([id]) => there.has(id));
      if (seen.length < this.seen.peek().size) this.seen.value = new Map(seen);
      if (!this.is_barred.value) this.has_tried.value = false;
    });
    const isKept = before.kind === turn.kind && before.person === turn.person && turn.person !== you;
    if (!wasAsking || turn.asked.includes(you) || !isKept || turn.kind === null) return "";
    return `${this.holder.peek()} keeps the tool for now. You can ask again.`;
  }

  takeSeen(seen: Seen): void {
    this.seen.value = new Map(this.seen.peek()).set(seen.person, seen);
  }

  /** The link is down: nothing is known of others. */
  forget(): void {
    batch(() => {
      this.people.value = [];
      this.turn.value = FREE;
      this.seen.value = new Map();
      this.has_tried.value = false;
    });
  }

  tried(): void {
    this.has_tried.value = true;
  }

  nameOf(person: number): string {
    return this.people.value.find(({ id }) => id === person)?.name ?? "Somebody";
  }

  toJSON(): PeopleShown {
    const [you, people, turn] = [this.you.peek(), this.people.peek(), this.turn.peek()];
    return { you, people, turn, seen: [...this.seen.peek().values()] };
  }
}
