// The steps of a task over time: lanes by person, the marks of the axis, and the words of times. Pure.

import type { Card, CardAnswer, TaskAnswer, TaskStepFacts } from "../link/protocol";
import type { Film } from "./film";

/** A step with its number in the answer. */
export interface Bar {
  readonly number: number;
  readonly step: TaskStepFacts;
}

/** The steps of one person, in order of their start. */
export interface Lane {
  readonly person: number;
  readonly bars: readonly Bar[];
}

const TICKS_S = [6, 15, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 28800];
const MOST_TICKS = 6;

/** The verbs that have a colour, in the order of the legend. */
export const VERBS = ["undo", "disconnect", "take out"] as const;

/** The class of the colour of a verb. */
export const verbClass = (verb: string): string => `verb-${Math.max(0, (VERBS as readonly string[]).indexOf(verb))}`;

export function lanesOf(task: TaskAnswer): Lane[] {
  const bars = task.steps.map((step, number) => ({ number, step }));
  const people = [...new Set(task.steps.map((step) => step.person))].sort((a, b) => a - b);
  return people.map((person) => ({
    person,
    bars: bars.filter(({ step }) => step.person === person).sort((a, b) => a.step.start - b.step.start),
  }));
}

/** Seconds until the last step ends; never 0. */
export const endOf = (task: TaskAnswer): number =>
  Math.max(1e-3, ...task.steps.map((step) => step.start + step.seconds));

/** The marks of the axis, seconds. */
export function ticksOf(end: number): number[] {
  const every = TICKS_S.find((each) => end / each <= MOST_TICKS) ?? end / MOST_TICKS;
  return Array.from({ length: Math.floor(end / every) + 1 }, (_, k) => k * every);
}

/** "0.5" minutes of a mark. */
export const minutesText = (seconds: number): string => String(Number((seconds / 60).toPrecision(3)));

/** "42 s", "3 min 5 s", "1 h 2 min". */
export function clockText(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole < 60) return `${seconds < 10 ? Number(seconds.toPrecision(3)) : whole} s`;
  const minutes = Math.floor(whole / 60);
  return minutes < 60 ? `${minutes} min ${whole % 60} s` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** The names of parts by their paths: the last word, and as many before it as tell them apart. */
export function shortNames(paths: readonly string[]): ReadonlyMap<string, string> {
  const words = new Map(paths.map((path) => [path, 1]));
  const named = (path: string): string =>
    path
      .split("/")
      .slice(-(words.get(path) ?? 1))
      .join("/");
  for (let isMore = true; isMore; ) {
    isMore = false;
    const alike = new Map<string, string[]>();
    for (const path of words.keys()) alike.set(named(path), [...(alike.get(named(path)) ?? []), path]);
    for (const group of alike.values()) {
      for (const path of group.length > 1 ? group : []) {
        const count = words.get(path) ?? 1;
        if (count >= path.split("/").length) continue;
        words.set(path, count + 1);
        isMore = true;
      }
    }
  }
  return new Map([...words.keys()].map((path) => [path, named(path)]));
}

/** How much of a fastener is seen from the best eye, in words. */
export function sightText(share: number): string {
  if (share <= 0) return "Not visible from any side";
  if (share >= 1) return "Fully visible";
  return `${Math.min(99, Math.max(1, Math.round(100 * share)))} % of it is visible`;
}

/** Seconds that were typed, with their unit or without: "90", "1.5 min", "1:30"; null: none. */
export function parseSeconds(text: string): number | null {
  const clock = /^\s*(\d+):([0-5]?\d)\s*$/.exec(text);
  if (clock) return atMost(60 * Number(clock[1]) + Number(clock[2]));
  const found = /^\s*(\d+(?:[.,]\d+)?|[.,]\d+)\s*(s|min|h)?\s*$/.exec(text);
  if (!found) return null;
  const unit = { min: 60, h: 3600 }[found[2] ?? ""] ?? 1;
  return atMost(Number((found[1] as string).replace(",", ".")) * unit);
}

const atMost = (seconds: number): number | null => (seconds <= 1e6 ? seconds : null);

/** The step whose tool stands in its seat while a film is at its beginning; null: none. */
export function seatedStep(answer: CardAnswer | undefined, step: number, share: number): number | null {
  const facts = answer?.task?.steps[step];
  return facts && facts.tool_way.length > 0 && share < SEATED_SHARE ? step : null;
}

/** So far along its way the part has not left its tool. */
const SEATED_SHARE = 0.3;

/** The parts that are out at a step of the film of a task: those of steps before it, and those that are off already. */
export function goneParts(
  film: Film | null,
  cards: readonly Pick<Card, "id" | "question" | "edits">[],
  answers: ReadonlyMap<number, Pick<CardAnswer, "ways">>,
  paths: readonly string[],
): number[] {
  const card = cards.find((each) => each.id === film?.card && each.question === "task");
  if (!film || !card) return [];
  const off = new Set(card.edits.off);
  const before = answers.get(card.id)?.ways.slice(0, film.step) ?? [];
  const away = off.size > 0 ? paths.flatMap((path, part) => (off.has(path) ? [part] : [])) : [];
  return [...away, ...before.flatMap((way) => way.parts)];
}
