// Commands that only change visibility, for a page without a server: the same names and arguments, applied to the page's
// document. Commands that need the engine are refused.

import type { CommandRequest, Commands, Document, Section, Selection } from "../link/protocol";
import { distance, type Vec3 } from "../math/vectors";

type Change<Name extends keyof Commands> = (document: Document, args: Commands[Name]) => Document | null;

/** The page names parts by their numbers. */
const ids = ({ parts }: { readonly parts: Selection }): number[] =>
  (Array.isArray(parts) ? parts : [parts]).filter((part) => typeof part === "number");
const united = (parts: readonly number[], more: readonly number[]): number[] =>
  [...new Set([...parts, ...more])].sort((a, b) => a - b);
const less = (parts: readonly number[], fewer: readonly number[]): number[] => {
  const gone = new Set(fewer);
  return parts.filter((part) => !gone.has(part));
};
const allOf = (document: Document): number[] => less([...Array(document.mockup?.parts ?? 0).keys()], document.absent);
const withSection = (document: Document, id: number, change: (section: Section) => Section): Document => ({
  ...document,
  sections: document.sections.map((section) => (section.id === id ? change(section) : section)),
});

/** From the picture's depth: near, and not exact. */
function withMeasure(document: Document, points: readonly [Vec3, Vec3]): Document {
  const id = 1 + Math.max(0, ...document.measures.map((each) => each.id));
  const value = distance(...points);
  const measure = {
    id,
    name: `point ${id}`,
    type: "point",
    points,
    value,
    unit: "m",
    is_exact: false,
    stale: {},
  } as const;
  return { ...document, measures: [...document.measures, measure] };
}

const CHANGES: { readonly [Name in keyof Commands]?: Change<Name> } = {
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
  explode: (document, { share }) => ({ ...document, explode: share }),
  set_unit: (document, { unit }) => ({ ...document, unit }),
  section_add: (document, { normal, offset }) => {
    const id = 1 + Math.max(0, ...document.sections.map((section) => section.id));
    return { ...document, sections: [...document.sections, { id, normal, offset, is_on: true }] };
  },
  section_move: (document, { id, normal, offset }) =>
    withSection(document, id, (section) => ({ ...section, normal, offset })),
  section_switch: (document, { id, is_on }) => withSection(document, id, (section) => ({ ...section, is_on })),
  section_remove: (document, { id }) => ({
    ...document,
    sections: document.sections.filter((section) => section.id !== id),
  }),
  section_box: (document, { lower, upper }) => ({ ...document, section_box: { lower, upper, is_on: true } }),
  section_box_switch: (document, { is_on }) => ({
    ...document,
    section_box: document.section_box && { ...document.section_box, is_on },
  }),
  section_box_remove: (document) => ({ ...document, section_box: null }),
  viewpoint_show: (document, { id }) => {
    const kept = document.viewpoints.find((each) => each.id === id);
    return kept?.sections ? { ...document, sections: kept.sections, section_box: kept.section_box } : document;
  },
  measure_add: (document, { type, points: [one, other] = [] }) =>
    type === "point" && one && other ? withMeasure(document, [one, other]) : null,
  measure_edit: (document, { id, name }) => ({
    ...document,
    measures: document.measures.map((each) => (each.id === id && name ? { ...each, name } : each)),
  }),
  measure_remove: (document, { id }) => ({ ...document, measures: document.measures.filter((each) => each.id !== id) }),
  sequence_replay: (document, { id }) => ({ ...document, replaying: id }),
  finding_filter: (document, { is_touching_hidden }) => ({
    ...document,
    findings: document.findings && { ...document.findings, is_touching_hidden },
  }),
};

function changed<Name extends keyof Commands>(document: Document, name: Name, args: Commands[Name]): Document | null {
  const change: Change<Name> | undefined = CHANGES[name];
  return change?.(document, args) ?? null;
}

/** Applies such commands, one after the other. */
export class OfflineCommands {
  private isolated: readonly number[] | null = null;
  private hidden_before: readonly number[] = [];

  /** The document after a command; null for one that needs the engine. */
  applied(document: Document, request: CommandRequest): Document | null {
    if (request[0] === "isolate") return this.isolate(document, ids(request[1]));
    const [name, args = {}] = request;
    if (name === "show_all" || name === "hide_all") this.isolated = null;
    return changed(document, name, args);
  }

  /** The same parts again restore the previous visibility. */
  private isolate(document: Document, parts: readonly number[]): Document {
    const isAgain = this.isolated?.join() === parts.join();
    if (!this.isolated) this.hidden_before = document.hidden;
    this.isolated = isAgain ? null : parts;
    const hidden = isAgain ? this.hidden_before : less(allOf(document), parts);
    return { ...document, hidden, isolated: !isAgain };
  }
}
