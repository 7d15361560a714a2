// The keyboard: each key finds its command in the table. Fields and buttons keep the keys that they need.

import { COMMANDS, type PageCommand, runCommand } from "../actions/commands";
import { refuseKey, typeFigure } from "../actions/typed-move";
import type { Workbench } from "../actions/workbench";

export type KeyPress = Pick<KeyboardEvent, "key" | "code" | "ctrlKey" | "metaKey" | "altKey" | "shiftKey">;

/** The name of a key with its modifiers, as the table has it: "Ctrl+K", "Shift+H", "?". */
export function keyOf(event: KeyPress): string {
  let { key } = event;
  // Alt turns letters and digits into others on some keyboards: the place of the key then identifies it.
  if (event.altKey) key = /^(?:Key|Digit)(.)$/.exec(event.code)?.[1] ?? key;
  if (key === " ") key = "Space";
  const isLetter = /^[a-z]$/i.test(key);
  if (isLetter) key = key.toUpperCase();
  // A sign such as "?" is what Shift made of another key: it names itself.
  const hasShift = event.shiftKey && (isLetter || key.length > 1);
  return [
    event.ctrlKey || event.metaKey ? "Ctrl+" : "",
    event.altKey ? "Alt+" : "",
    hasShift ? "Shift+" : "",
    key,
  ].join("");
}

const tableOf = (commands: readonly PageCommand[]): Map<string, string> =>
  new Map(commands.flatMap((command) => command.keys.map((key) => [key, command.id])));

const TYPING = tableOf(COMMANDS.filter((command) => command.while === "typing"));
const ALWAYS = tableOf(COMMANDS.filter((command) => command.while !== "typing"));

/** The command of a key; null: none. */
export function commandOfKey(key: string, is_typing: boolean): string | null {
  return (is_typing ? TYPING : ALWAYS).get(key) ?? null;
}

/** Whether a key belongs to a movement by keys: an axis, a step, or a sign of a figure. G and R begin a new one. */
export const isOfTyping = (key: string): boolean =>
  key !== "G" && key !== "R" && (TYPING.has(key) || /^(?:[0-9.,\-/]|Backspace)$/.test(key));

/** The focused element, as far as keys are concerned. */
export type Focus = "text" | "control" | "picture";

/** Whether a key is a command's rather than the focused element's own. */
export function isForCommands(key: string, focus: Focus, has_single_keys: boolean): boolean {
  if (key === "Escape" || /^F\d+$/.test(key)) return true;
  if (focus === "text") return /^(?:Ctrl\+[KFBJO,]|Alt\+)/.test(key);
  if (/^(?:Ctrl|Alt)\+/.test(key)) return true;
  if (focus === "control" && /^(?:Shift\+)?(?:Space|Enter|Arrow.*|Page.*|Home|End)$/.test(key)) return false;
  return has_single_keys || (key.length > 1 && !key.startsWith("Shift+"));
}

function focusOf(target: EventTarget | null): Focus {
  if (!(target instanceof HTMLElement)) return "picture";
  if (target.closest("input:not([type=checkbox]):not([type=radio]):not([type=range]), textarea, [contenteditable]")) {
    return "text";
  }
  return target.closest("button, input, select, a, [role=treeitem], [role=tab], [role=menuitem], [role=option]")
    ? "control"
    : "picture";
}

/** Whether an element keeps its keys during a movement: a field, and whatever lies over the page. */
const isOfCover = (target: EventTarget | null): boolean =>
  focusOf(target) === "text" ||
  (target instanceof HTMLElement && target.closest("dialog, [role=dialog], [role=menu], [role=listbox]") !== null);

/** Listens to the keys of the whole page; the function returned ends it. */
export function listenToKeys(wb: Workbench): () => void {
  // A movement has its keys wherever the focus is, also in a tree with keys of its own: it is asked first.
  const onTyping = (event: KeyboardEvent): void => {
    if (event.isComposing || wb.store.typed.peek() === null || isOfCover(event.target)) return;
    const id = commandOfKey(keyOf(event), true);
    const has_modifier = event.ctrlKey || event.altKey || event.metaKey;
    if (!(!has_modifier && typeFigure(wb, event.key)) && !(id && runCommand(wb, id))) return;
    event.preventDefault();
    event.stopPropagation();
  };
  const onKey = (event: KeyboardEvent): void => {
    if (event.defaultPrevented || event.isComposing) return;
    const { store } = wb;
    const key = keyOf(event);
    const is_typing = store.typed.peek() !== null;
    const focus = focusOf(event.target);
    if (!is_typing && focus !== "text" && refuseKey(wb, isOfTyping(key), key)) {
      event.preventDefault();
      return;
    }
    // A dialog is modal: only Esc and its own keys reach it.
    if (store.dialog.peek() && key !== "Escape") return;
    if (!is_typing && !isForCommands(key, focus, store.settings.peek().has_single_keys)) return;
    if (is_typing && focus === "text") return;
    const id = commandOfKey(key, is_typing);
    if (id && runCommand(wb, id)) event.preventDefault();
    // The browser's own search and bookmarks would cover the page's, even while they cannot run.
    else if (id && /^Ctrl\+[FBJKO]$/.test(key)) event.preventDefault();
  };
  window.addEventListener("keydown", onTyping, { capture: true });
  window.addEventListener("keydown", onKey);
  return () => {
    window.removeEventListener("keydown", onTyping, { capture: true });
    window.removeEventListener("keydown", onKey);
  };
}
