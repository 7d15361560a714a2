// All commands of the page: their titles, their keys, when they can run. Keys, palette, menus, help and the tooltips of
// buttons read this table; no other code binds a key.

import type { FindingFormat } from "../link/protocol";
import { UNIT_NAMES, UNITS } from "../math/units";
import type { Vec3 } from "../math/vectors";
import { MODES } from "../model/document";
import { STYLES } from "../model/navigation";
import { type Dialog, PANELS, type Panel } from "../model/page-state";
import { ask, askTools, endFilm, openSequenceFilm } from "./cards";
import { EXPORTS, type Export, exportFile, takeSnapshot } from "./exports";
import {
  checkClashes,
  clashesOf,
  exportFindings,
  FORMATS,
  leaveFinding,
  openBcf,
  openFindings,
  openRules,
  stepFinding,
} from "./findings";
import { chooseMechanism, keepPosition, moverOf, toggleWorst } from "./joints";
import { checkWays, endGuide } from "./lines";
import { MEASURE_TITLES, startMeasuring, stopMeasuring } from "./measures";
import { chooseFiles } from "./opening";
import { changeTurn, giveTurn, wishTurn } from "./people";
import { isStale, project, saveProject, selectStale } from "./project";
import { playRecord } from "./record";
import { addRequirement, checkRequirements } from "./requirements";
import { addSection, fitBox, flipped, pickFace, toggleBox, toggleSections } from "./sections";
import { askTask } from "./tasks";
import { beginTyping, cancelTyping, chooseAxis, confirmTyping, stepTyping } from "./typed-move";
import type { Workbench } from "./workbench";

export type CommandGroup =
  | "Look"
  | "Parts"
  | "Tool"
  | "Ask"
  | "Sections"
  | "Measures"
  | "Sequence"
  | "Findings"
  | "Edit"
  | "Page";

export interface PageCommand {
  readonly id: string;
  readonly title: string;
  /** As `keyOf` names them, the first is shown. */
  readonly keys: readonly string[];
  readonly group: CommandGroup;
  /** While the tool is moved by keys, these keys count and no others. */
  readonly while?: "typing";
  run(wb: Workbench): unknown;
  /** Whether it can run now; absent: always. */
  when?(wb: Workbench): boolean;
}

const canChange = (wb: Workbench): boolean => !wb.store.is_read_only.value;
const canLook = (wb: Workbench): boolean => wb.store.can_look.value;
const hasMockup = (wb: Workbench): boolean => wb.store.manifest.value !== null;
const hasTargets = (wb: Workbench): boolean =>
  canLook(wb) && (wb.store.selection.value.size > 0 || wb.store.hover.value >= 0);
const canAsk = (wb: Workbench): boolean => canChange(wb) && hasTargets(wb);
const canGrip = (wb: Workbench): boolean => canChange(wb) && (hasTargets(wb) || isGripping(wb));
const hasHand = (wb: Workbench): boolean => canChange(wb) && wb.store.has_hand.value;
const canAskAccess = (wb: Workbench): boolean => canChange(wb) && wb.store.document.value?.tool != null;
const isGripping = (wb: Workbench): boolean => canChange(wb) && (wb.store.document.value?.gripped.length ?? 0) > 0;
const hasSections = (wb: Workbench): boolean => canLook(wb) && (wb.store.document.value?.sections.length ?? 0) > 0;
const hasBox = (wb: Workbench): boolean => canLook(wb) && wb.store.document.value?.section_box != null;
const hasFindings = (wb: Workbench): boolean => wb.store.document.value?.findings != null;
const hasRules = (wb: Workbench): boolean => (wb.store.document.value?.clash.rules ?? "") !== "";
const hasRecord = (wb: Workbench): boolean => canChange(wb) && wb.store.document.value?.record != null;
const canOpen = (wb: Workbench): boolean => !wb.store.is_read_only.value && wb.store.opens.value !== null;
const hasDoubts = (wb: Workbench): boolean => (wb.store.document.value?.doubts.length ?? 0) > 0;
const isAsked = (wb: Workbench): boolean => canChange(wb) && wb.store.people.asking.value.length > 0;
const hasOthers = (wb: Workbench): boolean => canChange(wb) && wb.store.people.others.value.length > 0;
const hasStale = (wb: Workbench): boolean => isStale(project(wb));
const isGuided = (wb: Workbench): boolean => canChange(wb) && Boolean(wb.store.document.value?.guiding);
const hasJoints = (wb: Workbench): boolean => canChange(wb) && wb.store.document.value?.mechanism != null;
const hasSequence = (wb: Workbench): boolean => canChange(wb) && (wb.store.document.value?.sequence.length ?? 0) > 0;

const command = (
  group: CommandGroup,
  id: string,
  title: string,
  keys: string | readonly string[],
  run: (wb: Workbench) => unknown,
  when?: (wb: Workbench) => boolean,
): PageCommand => ({
  id,
  title,
  keys: typeof keys === "string" ? (keys === "" ? [] : [keys]) : keys,
  group,
  run,
  ...(when ? { when } : {}),
});

const typing = (
  id: string,
  title: string,
  keys: string | readonly string[],
  run: (wb: Workbench) => unknown,
): PageCommand => ({ ...command("Tool", id, title, keys, run), while: "typing" });

const VIEWS = ["front", "back", "left", "right", "top", "bottom", "corner"] as const;
const HOME_VIEW = 7;
const AXES = ["X", "Y", "Z"] as const;
const STEPS: readonly [string, string, Vec3][] = [
  ["ArrowRight", "right", [1, 0, 0]],
  ["ArrowLeft", "left", [-1, 0, 0]],
  ["ArrowUp", "up", [0, 1, 0]],
  ["ArrowDown", "down", [0, -1, 0]],
  ["PageDown", "nearer", [0, 0, 1]],
  ["PageUp", "farther", [0, 0, -1]],
];
const ORBIT_RAD = Math.PI / 24;
const PAN_PX = 60;

/** Turns or moves the view by the keyboard, about its target. */
function moveView(wb: Workbench, kind: "orbit" | "pan", x: number, y: number): void {
  const { camera } = wb.stage;
  if (kind === "orbit") camera.orbit(-x * ORBIT_RAD, y * ORBIT_RAD, camera.target);
  else camera.pan(-x * PAN_PX, y * PAN_PX);
  wb.redraw();
}

function zoom(wb: Workbench, factor: number): void {
  wb.stage.camera.dolly(factor);
  wb.redraw();
}

/** E: the selection joins the hand; if the hand holds parts and nothing else is selected, they are put down. */
function gripOrRelease(wb: Workbench): Promise<boolean> {
  const targets = wb.targets();
  const selection = wb.store.selection.peek();
  return wb.runOf(({ gripped }) => {
    const held = new Set(gripped);
    const parts = targets.filter((part) => !held.has(part));
    if (held.size > 0 && parts.every((part) => !selection.has(part))) return [["release"]];
    if (parts.length === 0) {
      wb.store.notify("info", "Select a part to grip first");
      return [];
    }
    wb.store.selection.value = new Set();
    return [["grip", { parts }]];
  });
}

/** Space: cycles through stop, glide, pass. */
function nextMode(wb: Workbench): Promise<boolean> {
  return wb.runOf((document) => {
    const mode = MODES[(MODES.indexOf(document.mode) + 1) % MODES.length] ?? "stop";
    wb.say(`Contact: ${mode}`);
    return [["set_mode", { mode }]];
  });
}

function toggleGhost(wb: Workbench): Promise<boolean> {
  const parts = wb.targets();
  return wb.runOf((document) => {
    const ghost = new Set(document.ghost);
    return [["ghost", { parts, is_on: parts.some((part) => !ghost.has(part)) }]];
  });
}

function toggleHidden(wb: Workbench): Promise<boolean> {
  const parts = wb.targets();
  return wb.runOf((document) => {
    const hidden = new Set(document.hidden);
    return [[parts.every((part) => hidden.has(part)) ? "show" : "hide", { parts }]];
  });
}

/** Without a part to isolate, the isolation ends. */
function isolate(wb: Workbench): Promise<boolean> {
  const targets = wb.targets();
  const parts = targets.length > 0 ? targets : wb.visible([...wb.store.paths.peek().keys()]);
  return wb.run("isolate", { parts });
}

/** The menu of a part without a pointer: at what has the focus. */
function openMenu(wb: Workbench): void {
  const [part = -1] = wb.targets();
  const focused = document.activeElement ?? document.body;
  const box = focused.getBoundingClientRect();
  const isPicture = focused === wb.canvas || focused === document.body;
  const at = {
    x: box.left + (isPicture ? 0.5 * box.width : 24),
    y: box.top + (isPicture ? 0.5 * box.height : box.height),
  };
  wb.store.menu.value = { ...at, part, point: null, at };
}

/** Esc: closes or ends the topmost activity. */
function endNearest(wb: Workbench): void {
  const { store } = wb;
  if (moverOf(wb).cancel()) return;
  if (store.dialog.peek()) store.dialog.value = null;
  else if (store.menu.peek()) store.menu.value = null;
  else if (store.drawer.peek()) store.drawer.value = null;
  else if (store.tour_step.peek() !== null) store.tour_step.value = null;
  else if (store.measuring.peek()) stopMeasuring(wb);
  else if (store.is_picking_face.peek()) pickFace(wb);
  else if (store.film.peek()?.card === "sequence") endFilm(wb);
  else if (store.joint_ghost.peek() !== null) toggleWorst(wb, store.joint_ghost.peek() ?? "");
  else if (store.findings.isLooking) leaveFinding(wb);
  else if (store.document.peek()?.guiding) void endGuide(wb);
  else if (store.selection.peek().size > 0) wb.select([]);
}

/** Searches the parts for words that were typed elsewhere. */
export function searchFor(wb: Workbench, words: string): void {
  wb.store.search.value = words;
  focusSearch(wb);
}

function focusSearch(wb: Workbench): void {
  const field = document.querySelector<HTMLInputElement>("#search");
  // At once, so that the next keys go into it.
  if (field) field.select();
  else {
    wb.store.showTree(true);
    // The components are drawn anew in a microtask of their own, which is before this one.
    queueMicrotask(() => document.querySelector<HTMLInputElement>("#search")?.select());
  }
}

const REGIONS = ["#picture", "#tree", "#panels", "#bar"] as const;

/** F6: moves the focus from region to region. */
function nextRegion(): void {
  const found = REGIONS.map((name) => document.querySelector<HTMLElement>(name)).filter((each) => each !== null);
  const at = found.findIndex((each) => each.contains(document.activeElement));
  const next = found[(at + 1) % found.length];
  const target = next?.matches("[tabindex]")
    ? next
    : next?.querySelector<HTMLElement>("[tabindex='0'], button:not([disabled]), input, select");
  target?.focus();
}

const toggleTheme = (wb: Workbench): void =>
  wb.store.set({ theme: wb.store.theme.peek() === "dark" ? "light" : "dark" });

const showDialog =
  (dialog: Dialog) =>
  (wb: Workbench): void => {
    wb.store.dialog.value = dialog;
  };

const panelTitles: Readonly<Record<Panel, string>> = {
  pose: "Pose",
  ask: "Ask",
  sections: "Sections",
  measures: "Measures",
  mechanism: "Mechanism",
  task: "Task",
  sequence: "Sequence",
  findings: "Findings",
};

export const COMMANDS: readonly PageCommand[] = [
  command("Look", "fit", "Frame the selection, or everything", "F", (wb) => wb.fit(), hasMockup),
  ...VIEWS.map((name, k) =>
    command(
      "Look",
      `view-${name}`,
      `View from ${name === "corner" ? "a corner" : `the ${name}`}`,
      `${k + 1}`,
      (wb) => wb.view(k + 1),
      hasMockup,
    ),
  ),
  ...STEPS.slice(0, 4).flatMap(([key, name, [x, y]]) => [
    command("Look", `orbit-${name}`, `Turn the view ${name}`, key, (wb) => moveView(wb, "orbit", x, y), hasMockup),
    command(
      "Look",
      `pan-${name}`,
      `Move the view ${name}`,
      `Shift+${key}`,
      (wb) => moveView(wb, "pan", x, y),
      hasMockup,
    ),
  ]),
  command("Look", "zoom-in", "Zoom in", ["+", "="], (wb) => zoom(wb, 0.8), hasMockup),
  command("Look", "zoom-out", "Zoom out", "-", (wb) => zoom(wb, 1.25), hasMockup),
  command("Look", "home", "Home view: all from a corner", "Home", (wb) => wb.view(HOME_VIEW), hasMockup),
  command("Look", "projection", "Parallel projection, or perspective", "O", (wb) =>
    wb.store.set({ is_parallel: !wb.store.settings.peek().is_parallel }),
  ),
  command("Page", "glide", "Gliding view on, or off", "", (wb) =>
    wb.store.set({ has_glide: !wb.store.settings.peek().has_glide }),
  ),
  command("Look", "snapshot", "Picture and viewpoint", "K", takeSnapshot, hasMockup),
  command(
    "Look",
    "explode",
    "Explode the mock-up, or put it together",
    "",
    (wb) => wb.runOf(({ explode }) => [["explode", { share: explode > 0 ? 0 : 0.5 }]]),
    canLook,
  ),

  command("Parts", "hide", "Hide, or show", "H", toggleHidden, hasTargets),
  command(
    "Parts",
    "isolate",
    "Isolate, or end isolation",
    "Shift+H",
    isolate,
    (wb) => hasTargets(wb) || (canLook(wb) && (wb.store.document.value?.isolated ?? false)),
  ),
  command("Parts", "show-all", "Show all", "Alt+H", (wb) => wb.run("show_all"), canLook),
  command("Parts", "hide-all", "Hide all", "", (wb) => wb.run("hide_all"), canLook),
  command("Parts", "ghost", "Ghost, or solid", "X", toggleGhost, hasTargets),
  command("Parts", "menu", "Menu of the selection", ["Shift+F10", "ContextMenu"], openMenu, hasTargets),
  command("Parts", "search", "Search parts", ["Ctrl+F", "/"], focusSearch, hasMockup),
  command(
    "Parts",
    "select-all",
    "Select all visible parts",
    "Ctrl+A",
    (wb) => wb.select(wb.visible([...wb.store.paths.peek().keys()])),
    hasMockup,
  ),

  command("Tool", "move", "Move the tool", "G", (wb) => beginTyping(wb, "move"), hasHand),
  command("Tool", "turn", "Turn the tool", "R", (wb) => beginTyping(wb, "turn"), hasHand),
  command("Tool", "grip", "Grip the selection, or release it", "E", gripOrRelease, canGrip),
  command("Tool", "release", "Put down the gripped parts", "", (wb) => wb.run("release"), isGripping),
  command(
    "Tool",
    "put-back",
    "Put back in place",
    "Shift+E",
    (wb) => {
      const parts = wb.targets();
      return wb.runOf(({ gripped }) => [["put_back", { parts: parts.length > 0 ? parts : gripped }]]);
    },
    canGrip,
  ),
  command("Tool", "mode", "Contact: stop, glide, pass", "Space", nextMode, canChange),
  ...MODES.map((mode) =>
    command("Tool", `mode-${mode}`, `Contact: ${mode}`, "", (wb) => wb.run("set_mode", { mode }), canChange),
  ),
  command(
    "Tool",
    "frame",
    "World axes, or tool axes",
    "L",
    (wb) => wb.store.set({ frame: wb.store.settings.peek().frame === "world" ? "tool" : "world" }),
    hasHand,
  ),
  command("Tool", "snapping", "Snapping on, or off", "T", (wb) =>
    wb.store.set({ is_snapping: !wb.store.settings.peek().is_snapping }),
  ),
  command("Tool", "look-at-tool", "Look at the tool", "Shift+F", (wb) => wb.lookAtTool(), hasHand),
  command(
    "Tool",
    "spacemouse",
    "Connect a SpaceMouse",
    "",
    (wb) => wb.connectSpaceMouse?.(),
    (wb) => wb.connectSpaceMouse !== null,
  ),
  command(
    "Tool",
    "xr",
    "Enter VR",
    "",
    (wb) => wb.toggleXr?.(),
    (wb) => wb.store.is_xr_there.value,
  ),

  command("Ask", "ask-removal", "Can it come out?", "Q", (wb) => ask(wb, "removal"), canAsk),
  command("Ask", "ask-order", "What has to go first?", "Shift+Q", (wb) => ask(wb, "order"), canAsk),
  command("Ask", "ask-task", "How is it taken out, with which tools, in how long?", "", askTask, canAsk),
  command("Ask", "ask-tools", "Which tool reaches its bolts?", "", askTools, canChange),
  command("Ask", "ask-access", "Does the tool reach its bolts?", "", (wb) => ask(wb, "access"), canAskAccess),
  command("Ask", "ask-swept", "What room does it need to come out?", "", (wb) => ask(wb, "swept"), canAsk),

  ...AXES.map((name, k) =>
    typing(`axis-${name}`, `Along or about ${name}; again: other frame`, name, (wb) => chooseAxis(wb, k as 0 | 1 | 2)),
  ),
  ...STEPS.map(([key, name, direction]) =>
    typing(`step-${name}`, `One step ${name}`, key, (wb) => stepTyping(wb, direction)),
  ),
  typing("move-again", "Move instead", "G", (wb) => beginTyping(wb, "move")),
  typing("turn-again", "Turn instead", "R", (wb) => beginTyping(wb, "turn")),
  typing("confirm", "Confirm", "Enter", confirmTyping),
  typing("cancel", "Cancel", "Escape", cancelTyping),

  command(
    "Sections",
    "sections",
    "Cut through the selection; cuts off, on",
    "S",
    toggleSections,
    (wb) => canLook(wb) && hasMockup(wb),
  ),
  ...AXES.map((name, k) =>
    command(
      "Sections",
      `section-${name}`,
      `Cut across ${name}`,
      "",
      (wb) => {
        const normal: Vec3 = [0, 0, 0];
        normal[k] = 1;
        return addSection(wb, normal);
      },
      (wb) => canLook(wb) && hasMockup(wb),
    ),
  ),
  command("Sections", "section-face", "Cut along a face", "", pickFace, (wb) => canChange(wb) && hasMockup(wb)),
  command(
    "Sections",
    "section-box",
    "Section box round the selection; off, on",
    "B",
    toggleBox,
    (wb) => canLook(wb) && hasMockup(wb),
  ),
  command(
    "Sections",
    "section-box-fit",
    "Fit the section box to the selection",
    "",
    fitBox,
    (wb) => canLook(wb) && hasMockup(wb),
  ),
  command("Sections", "section-box-remove", "Delete the section box", "", (wb) => wb.run("section_box_remove"), hasBox),
  command(
    "Sections",
    "section-flip",
    "Keep the other side of the last cut",
    "Shift+S",
    (wb) =>
      wb.runOf(({ sections }) => {
        const last = sections.at(-1);
        return last ? [flipped(last)] : [];
      }),
    hasSections,
  ),
  command(
    "Sections",
    "section-remove",
    "Delete the last cut",
    "",
    (wb) =>
      wb.runOf(({ sections }) => {
        const last = sections.at(-1);
        return last ? [["section_remove", { id: last.id }]] : [];
      }),
    hasSections,
  ),

  command(
    "Measures",
    "measure",
    "Measure point to point",
    "M",
    (wb) => startMeasuring(wb, "point"),
    (wb) => canLook(wb) && hasMockup(wb),
  ),
  ...(["edge", "angle", "parts"] as const).map((type) =>
    command(
      "Measures",
      `measure-${type}`,
      `Measure: ${MEASURE_TITLES[type].toLowerCase()}`,
      "",
      (wb) => startMeasuring(wb, type),
      (wb) => canChange(wb) && hasMockup(wb),
    ),
  ),
  ...UNITS.map((unit) =>
    command(
      "Measures",
      `unit-${unit}`,
      `Show lengths in ${UNIT_NAMES[unit]}`,
      "",
      (wb) => wb.run("set_unit", { unit }),
      canLook,
    ),
  ),

  ...(Object.entries(EXPORTS) as [Export, string][]).map(([name, title]) =>
    command(
      "Sequence",
      name,
      `Export: ${title}`,
      "",
      (wb) => exportFile(wb, name),
      name === "page" || name === "report" || name === "export_project" ? canChange : hasSequence,
    ),
  ),

  command("Sequence", "check-ways", "Check the ways of all removals", "", checkWays, hasSequence),
  command("Sequence", "open-mechanism", "Open a mechanism", "", chooseMechanism, canChange),
  command("Sequence", "joint-step", "Keep the position of the joints in the sequence", "", keepPosition, hasJoints),
  command("Sequence", "guide-end", "End the guidance of the hand", "", endGuide, isGuided),
  command(
    "Sequence",
    "film",
    "Show the sequence as a film",
    "",
    (wb) => {
      wb.store.panel.value = "sequence";
      return openSequenceFilm(wb);
    },
    (wb) => canChange(wb) && hasSequence(wb),
  ),
  command("Sequence", "replay", "Replay the record", "", (wb) => playRecord(wb), hasRecord),

  command(
    "Findings",
    "check-clashes",
    "Check clashes",
    "",
    (wb) => checkClashes(wb),
    (wb) => canChange(wb) && hasMockup(wb),
  ),
  command(
    "Findings",
    "clashes-of",
    "What clashes with it?",
    "",
    (wb) => clashesOf(wb, wb.targets()),
    (wb) => canChange(wb) && hasTargets(wb),
  ),
  command("Findings", "open-findings", "Open findings of a clash check", "", openFindings, canChange),
  command(
    "Findings",
    "open-bcf",
    "Open statuses and comments of a BCF file",
    "",
    openBcf,
    (wb) => canChange(wb) && hasFindings(wb),
  ),
  command("Findings", "add-requirement", "Add a clearance that must hold", "", addRequirement, canChange),
  command(
    "Findings",
    "check-requirements",
    "Check the clearances that must hold",
    "",
    checkRequirements,
    (wb) => canChange(wb) && (wb.store.document.value?.requirements.length ?? 0) > 0,
  ),
  command("Findings", "open-rules", "Open rules of clash checks", "", openRules, canChange),
  command("Findings", "next-finding", "Next finding", "N", (wb) => stepFinding(wb, 1), hasFindings),
  command("Findings", "previous-finding", "Previous finding", "P", (wb) => stepFinding(wb, -1), hasFindings),
  ...(Object.entries(FORMATS) as [FindingFormat, string][]).map(([format, title]) =>
    command(
      "Findings",
      `findings-${format}`,
      `Export findings: ${title}`,
      "",
      (wb) => exportFindings(wb, format),
      (wb) => canChange(wb) && (format === "rules" ? hasRules(wb) : hasFindings(wb)),
    ),
  ),
  command(
    "Findings",
    "close-findings",
    "Close the findings",
    "",
    (wb) => wb.run("findings_close"),
    (wb) => canChange(wb) && hasFindings(wb),
  ),

  command(
    "Edit",
    "undo",
    "Undo",
    "Ctrl+Z",
    (wb) => wb.run("undo"),
    (wb) => canChange(wb) && (wb.store.undo_depth.value !== 0 || wb.isBusy),
  ),
  command(
    "Edit",
    "redo",
    "Redo",
    ["Ctrl+Y", "Ctrl+Shift+Z"],
    (wb) => wb.run("redo"),
    (wb) => canChange(wb) && (wb.store.redo_depth.value !== 0 || wb.isBusy),
  ),
  command("Edit", "escape", "Cancel, or clear the selection", "Escape", endNearest),

  command("Edit", "save-project", "Save project", "Ctrl+S", saveProject, canChange),
  command("Edit", "select-stale", "Select the parts that a revision changed", "", selectStale, hasStale),
  command(
    "Edit",
    "accept-revision",
    "Accept this revision of the mock-up",
    "",
    (wb) => wb.run("accept_revision"),
    (wb) => canChange(wb) && hasStale(wb),
  ),
  command("Page", "open-file", "Open a file", "Ctrl+O", chooseFiles, canOpen),
  command("Page", "open-sample", "Open a sample", "", showDialog("open"), canOpen),
  command("Page", "reopen-unit", "Correct the unit of the file", "", showDialog("doubts"), canOpen),
  command("Page", "doubts", "Doubts about the files", "", showDialog("doubts"), hasDoubts),
  command(
    "Page",
    "first-run",
    "Three questions to begin with",
    "",
    (wb) => wb.store.set({ has_first_run: true }),
    hasMockup,
  ),

  command("Page", "palette", "All commands", "Ctrl+K", (wb) => {
    wb.store.dialog.value = "palette";
  }),
  command("Page", "help", "Help", ["?", "F1"], (wb) => {
    wb.store.dialog.value = "help";
  }),
  command("Page", "tour", "Two-minute tour", "", (wb) => {
    wb.store.tour_step.value = 0;
  }),
  command(
    "Page",
    "people",
    "People on this project",
    "",
    (wb) => {
      wb.store.dialog.value = "people";
    },
    hasOthers,
  ),
  command("Tool", "give-turn", "Give the tool to who asks for it", "", giveTurn, isAsked),
  command("Tool", "keep-turn", "Keep the tool, though somebody asks for it", "", (wb) => wishTurn(wb, "keep"), isAsked),
  command("Tool", "take-turn", "Turn of the tool: take it, ask for it, let it go", "", changeTurn, hasOthers),
  command("Page", "settings", "Settings", "Ctrl+,", (wb) => {
    wb.store.dialog.value = "settings";
  }),
  command("Page", "theme", "Dark, or light theme", "", toggleTheme),
  command("Page", "next-region", "Focus the next region", "F6", nextRegion),
  command("Page", "tree", "Part tree: open, close", "Ctrl+B", (wb) =>
    wb.store.showTree(!wb.store.is_tree_shown.peek()),
  ),
  command("Page", "panels", "Panels: open, close", "Ctrl+J", (wb) =>
    wb.store.showPanels(!wb.store.are_panels_shown.peek()),
  ),
  ...PANELS.map((panel, k) =>
    command("Page", `panel-${panel}`, `Panel: ${panelTitles[panel]}`, `Alt+${k + 1}`, (wb) => {
      wb.store.panel.value = panel;
      wb.store.showPanels(true);
    }),
  ),
  command("Page", "mute", "Sound on, or off", "Shift+M", (wb) =>
    wb.store.set({ is_muted: !wb.store.settings.peek().is_muted }),
  ),
  command("Page", "figures", "Engine's rate in the status line", "", (wb) =>
    wb.store.set({ has_figures: !wb.store.settings.peek().has_figures }),
  ),
  command("Page", "rumble", "Rumble on, or off", "", (wb) =>
    wb.store.set({ has_rumble: !wb.store.settings.peek().has_rumble }),
  ),
  ...STYLES.map((style) =>
    command("Page", `style-${style.id}`, `Navigate as in ${style.title}`, "", (wb) =>
      wb.store.set({ style: style.id }),
    ),
  ),
];

const BY_ID = new Map(COMMANDS.map((each) => [each.id, each]));

/** The command of an id; a wrong one is an error of the page. */
export function commandOf(id: string): PageCommand {
  const found = BY_ID.get(id);
  if (!found) throw new RangeError(`there is no command ${id}`);
  return found;
}

/** Whether there is a command of an id. */
export const hasCommand = (id: string): boolean => BY_ID.has(id);

/** Runs a command where it can run now; whether it did. */
export function runCommand(wb: Workbench, id: string): boolean {
  const found = commandOf(id);
  if (found.when && !found.when(wb)) return false;
  found.run(wb);
  return true;
}

/** The keys of a command as people read them; empty where it has none. */
export const shownKey = (key: string | undefined): string =>
  (key ?? "")
    .replace("Arrow", "")
    .replace("Escape", "Esc")
    .replace("PageUp", "Page up")
    .replace("PageDown", "Page down");

/** A tooltip: what a command is for, and its key. `tipOf` has what it would do now. */
export function hint(id: string): string {
  const { title, keys } = commandOf(id);
  return keys[0] ? `${title} (${shownKey(keys[0])})` : title;
}
