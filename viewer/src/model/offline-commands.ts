// Commands that only change what is seen, for a page without a server: the same names and arguments, on the document
// that the page has. What needs the engine is refused.

import type { Document, Section } from "../link/protocol";
import { distance, type Vec3 } from "../math/vectors";

type Args = Record<string, unknown>;
type Change = (document: Document, args: Args) => Document | null;

const ids = (args: Args): number[] => args.parts as number[];
const united = (parts: readonly number[], more: readonly number[]): number[] =>
  [...new Set([...parts, ...more])].sort((a, b) => a - b);
const less = (parts: readonly number[], fewer: readonly number[]): number[] => {
  const gone = new Set(fewer);
  return parts.filter((part) => !gone.has(part));
};
const allOf = (document: Document): number[] => less([...Array(document.mockup?.parts ?? 0).keys()], document.absent);
const withSection = (document: Document, id: unknown, change: (section: Section) => Section): Document => ({
  ...document,
  sections: document.sections.map((section) => (section.id === id ? change(section) : section)),
});

/** From the picture's depth: near, and not exact. */
function withMeasure(document: Document, points: readonly [Vec3, Vec3]): Document {
  const id = 1 + Math.max(0, ...document.measures.map((each) => each.id));
  const value = distance(...points);
  const measure = { id, name: `point ${id}`, type: "point", points, value, unit: "m", is_exact: false } as const;
  return { ...document, measures: [...document.measures, measure] };
}

const CHANGES: Readonly<Record<string, Change>> = {
  hide: (document, args) => ({ ...document, hidden: united(document.hidden, ids(args)) }),
  show: (document, args) => ({ ...document, hidden: less(document.hidden, ids(args)) }),
  show_all: (document) => ({ ...document, hidden: [], ghost: [], isolated: false }),
  hide_all: (document) => ({ ...document, hidden: allOf(document), isolated: false }),
  ghost: (document, args) => ({
    ...document,
    ghost: args.is_on ? united(document.ghost, ids(args)) : less(document.ghost, ids(args)),
  }),
  single_out: (document, args) => ({
    ...document,
    hidden: less(document.hidden, ids(args)),
    ghost: less(allOf(document), ids(args)),
  }),
  explode: (document, args) => ({ ...document, explode: args.share as number }),
  set_unit: (document, args) => ({ ...document, unit: args.unit as Document["unit"] }),
  section_add: (document, args) => {
    const id = 1 + Math.max(0, ...document.sections.map((section) => section.id));
    const section = { id, normal: args.normal as Vec3, offset: args.offset as number, is_on: true };
    return { ...document, sections: [...document.sections, section] };
  },
  section_move: (document, args) =>
    withSection(document, args.id, (section) => ({
      ...section,
      normal: args.normal as Vec3,
      offset: args.offset as number,
    })),
  section_switch: (document, args) =>
    withSection(document, args.id, (section) => ({ ...section, is_on: args.is_on as boolean })),
  section_remove: (document, args) => ({
    ...document,
    sections: document.sections.filter((section) => section.id !== args.id),
  }),
  measure_add: (document, args) =>
    args.type === "point" ? withMeasure(document, args.points as readonly [Vec3, Vec3]) : null,
  measure_edit: (document, args) => ({
    ...document,
    measures: document.measures.map((each) => (each.id === args.id ? { ...each, name: args.name as string } : each)),
  }),
  measure_remove: (document, args) => ({
    ...document,
    measures: document.measures.filter((each) => each.id !== args.id),
  }),
  sequence_replay: (document, args) => ({ ...document, replaying: args.id as number }),
  finding_filter: (document, args) => ({
    ...document,
    findings: document.findings && { ...document.findings, is_touching_hidden: args.is_touching_hidden as boolean },
  }),
};

/** Applies such commands, one after the other. */
export class Looking {
  private isolated: readonly number[] | null = null;
  private hidden_before: readonly number[] = [];

  /** The document after a command; null for one that needs the engine. */
  applied(document: Document, name: string, args: Args): Document | null {
    if (name === "isolate") return this.isolate(document, ids(args));
    if (name === "show_all" || name === "hide_all") this.isolated = null;
    return CHANGES[name]?.(document, args) ?? null;
  }

  /** The same parts again bring back what was seen before. */
  private isolate(document: Document, parts: readonly number[]): Document {
    const isAgain = this.isolated?.join() === parts.join();
    if (!this.isolated) this.hidden_before = document.hidden;
    this.isolated = isAgain ? null : parts;
    const hidden = isAgain ? this.hidden_before : less(allOf(document), parts);
    return { ...document, hidden, isolated: !isAgain };
  }
}
