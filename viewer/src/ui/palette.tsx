// The palette: finds every command by a few letters of its name.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { COMMANDS, type PageCommand, runCommand, shownKey } from "../actions/commands";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";

const MOST = 60;

/**
 * The commands whose title or group has the letters of every word, in order; the nearer to a word's start, the earlier.
 */
export function matchingCommands(query: string, commands: readonly PageCommand[] = COMMANDS): PageCommand[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const ranked = commands
    .filter((command) => command.while !== "typing")
    .map((command) => {
      const text = `${command.title} ${command.group}`.toLowerCase();
      const ranks = words.map((word) => rankOf(text, word));
      return { command, rank: ranks.some((rank) => rank < 0) ? -1 : ranks.reduce((sum, rank) => sum + rank, 0) };
    })
    .filter(({ rank }) => rank >= 0);
  return ranked.sort((a, b) => a.rank - b.rank).map(({ command }) => command);
}

/** 0: begins the text; 1: begins a word; 2: within a word; 3: its letters occur in order; -1: does not match. */
function rankOf(text: string, word: string): number {
  const at = text.indexOf(word);
  if (at === 0) return 0;
  if (at > 0) return /\W/.test(text[at - 1] ?? "") || text.includes(` ${word}`) ? 1 : 2;
  let from = 0;
  for (const letter of word) {
    from = text.indexOf(letter, from) + 1;
    if (from === 0) return -1;
  }
  return 3;
}

export function Palette() {
  const wb = useWorkbench();
  const query = useSignal("");
  const active = useSignal(0);
  const list = useRef<HTMLDivElement>(null);
  const found = matchingCommands(query.value).slice(0, MOST);
  const canRun = (command: PageCommand): boolean => command.when?.(wb) ?? true;
  const current = Math.min(active.value, Math.max(0, found.length - 1));
  const choose = (command: PageCommand | undefined): void => {
    if (!command || !canRun(command)) return;
    wb.store.dialog.value = null;
    // The dialog gives the focus back first, so that a command may move it.
    setTimeout(() => runCommand(wb, command.id));
  };
  useEffect(() => {
    list.current?.querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest" });
  });
  return (
    <Dialog title="Commands" kind="palette" bare>
      <input
        class="palette-input"
        type="text"
        role="combobox"
        aria-expanded="true"
        aria-controls="palette-list"
        aria-activedescendant={found.length > 0 ? `palette-${current}` : undefined}
        aria-label="Search commands"
        placeholder="Search commands"
        autocomplete="off"
        spellcheck={false}
        value={query.value}
        onInput={(event) => {
          query.value = event.currentTarget.value;
          active.value = 0;
        }}
        onKeyDown={(event) => {
          if (event.key === "ArrowDown") active.value = (current + 1) % Math.max(1, found.length);
          else if (event.key === "ArrowUp") active.value = (current - 1 + found.length) % Math.max(1, found.length);
          else if (event.key === "Enter") choose(found[current]);
          else return;
          event.preventDefault();
        }}
      />
      <div ref={list} id="palette-list" class="palette-list" role="listbox" aria-label="Commands">
        {found.map((command, k) => (
          // biome-ignore lint/a11y/useKeyWithClickEvents: the field has the focus, and its keys choose
          <div
            key={command.id}
            id={`palette-${k}`}
            role="option"
            tabIndex={-1}
            class="palette-option"
            aria-selected={k === current}
            aria-disabled={!canRun(command)}
            onPointerMove={() => {
              active.value = k;
            }}
            onClick={() => choose(command)}
          >
            <span class="palette-group">{command.group}</span>
            <span class="row-name">{command.title}</span>
            {command.keys[0] && <kbd>{shownKey(command.keys[0])}</kbd>}
          </div>
        ))}
      </div>
      {found.length === 0 && <p class="note palette-none">No command matches.</p>}
    </Dialog>
  );
}
