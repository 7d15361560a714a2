// What a command would do now, in a few words: "Hide" or "Show", where its title in the help has both.

import type { Mode } from "../link/protocol";
import { MODES } from "../model/document";
import { type PageCommand, shownKey } from "./commands";
import type { Workbench } from "./workbench";

const LABELS: Readonly<Record<string, (wb: Workbench) => string>> = {
  fit: ({ store }) => (store.selection.value.size > 0 ? "Frame the selection" : "Frame everything"),
  explode: ({ store }) => ((store.document.value?.explode ?? 0) > 0 ? "Put together" : "Explode"),
  hide: (wb) => (areAll(targetsOf(wb), wb.store.hidden.value) ? "Show" : "Hide"),
  ghost: (wb) => (areAll(targetsOf(wb), wb.store.ghost.value) ? "Solid" : "Ghost"),
  isolate: (wb) => (isIsolated(wb) ? "Show the others again" : "Isolate"),
  grip: (wb) => (isPutDown(wb) ? "Put down" : "Grip"),
  "take-turn": ({ store }) =>
    store.people.is_mine.value
      ? "Let go of the tool"
      : store.people.is_barred.value
        ? "Ask for the tool"
        : "Take the tool",
  mode: ({ store }) => `Contact: switch to ${nextMode(store.document.value?.mode)}`,
  frame: ({ store }) => (store.settings.value.frame === "world" ? "Use the tool's axes" : "Use the world's axes"),
  snapping: ({ store }) => (store.settings.value.is_snapping ? "Snapping off" : "Snapping on"),
  sections: ({ store }) => {
    const sections = store.document.value?.sections ?? [];
    if (sections.length === 0) return store.selection.value.size > 0 ? "Cut through the selection" : "Cut open";
    return sections.some((section) => section.is_on) ? "Cuts off" : "Cuts on";
  },
  "section-face": ({ store }) => (store.is_picking_face.value ? "Click a face, or end this" : "Cut along a face"),
  "section-box": ({ store }) => {
    const box = store.document.value?.section_box;
    if (box) return box.is_on ? "Section box off" : "Section box on";
    return store.selection.value.size > 0 ? "Section box round the selection" : "Section box round everything";
  },
  "section-box-fit": ({ store }) =>
    store.selection.value.size > 0 ? "Fit the section box to the selection" : "Fit the section box to everything",
  measure: ({ store }) => (store.measuring.value?.type === "point" ? "End measuring" : "Measure point to point"),
  theme: ({ store }) => (store.theme.value === "dark" ? "Light theme" : "Dark theme"),
  mute: ({ store }) => (store.settings.value.is_muted ? "Sound on" : "Sound off"),
  rumble: ({ store }) => (store.settings.value.has_rumble ? "Rumble off" : "Rumble on"),
  figures: ({ store }) => `${store.settings.value.has_figures ? "Hide" : "Show"} the engine's rate in the status line`,
  tree: ({ store }) => (store.is_tree_shown.value ? "Close the part tree" : "Open the part tree"),
  panels: ({ store }) => (store.are_panels_shown.value ? "Close the panels" : "Open the panels"),
};

/** Whether the label says what the command does next: a button then needs no other sign of its state. */
export const hasLabel = (id: string): boolean => id in LABELS;

/** The words of a button or a line of a menu. */
export const labelOf = (wb: Workbench, { id, title }: Pick<PageCommand, "id" | "title">): string =>
  LABELS[id]?.(wb) ?? title;

/** A button's tooltip: what it does now, and the key. */
export function tipOf(wb: Workbench, command: PageCommand): string {
  const label = labelOf(wb, command);
  return command.keys[0] ? `${label} (${shownKey(command.keys[0])})` : label;
}

/** As `Workbench.targets`, followed by components. */
function targetsOf({ store }: Workbench): readonly number[] {
  const selected = [...store.selection.value];
  if (selected.length > 0) return selected;
  return store.hover.value >= 0 ? [store.hover.value] : [];
}

const areAll = (parts: readonly number[], set: ReadonlySet<number>): boolean =>
  parts.length > 0 && parts.every((part) => set.has(part));

/** The targets are the parts that were isolated: the same command shows the others again. */
function isIsolated(wb: Workbench): boolean {
  const { store } = wb;
  if (!store.document.value?.isolated) return false;
  const targets = targetsOf(wb);
  if (targets.length === 0) return true;
  const hidden = store.hidden.value;
  return targets.length + hidden.size === store.part_count.value && targets.every((part) => !hidden.has(part));
}

/** As `gripOrRelease` decides. */
function isPutDown({ store }: Workbench): boolean {
  const held = new Set(store.document.value?.gripped ?? []);
  return held.size > 0 && [...store.selection.value].every((part) => held.has(part));
}

const nextMode = (mode: Mode | undefined): string => {
  const at = mode ? MODES.indexOf(mode) : -1;
  return MODES[(at + 1) % MODES.length] ?? "stop";
};
