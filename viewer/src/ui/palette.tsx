// The palette: finds every command by a few letters of its name.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { COMMANDS, type PageCommand, runCommand, searchFor, shownKey } from "../actions/commands";
import { labelOf } from "../actions/labels";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";
import { Icon } from "./icons";
import { matchingCommands } from "./ranking";

const MOST = 60;

export function Palette() {
  const wb = useWorkbench();
  const query = useSignal("");
  const active = useSignal(0);
  const list = useRef<HTMLDivElement>(null);
  const found = matchingCommands(query.value, COMMANDS, (command) => labelOf(wb, command)).slice(0, MOST);
  const words = query.value.trim();
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
          else if (event.key === "Enter" && !event.isComposing) choose(found[current]);
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
            <span class="row-name">{labelOf(wb, command)}</span>
            {command.keys[0] && <kbd>{shownKey(command.keys[0])}</kbd>}
          </div>
        ))}
      </div>
      {found.length === 0 && (
        <div class="palette-none" role="status">
          <p class="note">No command has these words. Try hide, cut, measure, take out, clash, or undo.</p>
          <button
            type="button"
            class="button"
            onClick={() => {
              wb.store.dialog.value = null;
              setTimeout(() => searchFor(wb, words));
            }}
          >
            <Icon name="search" size={14} />
            <span class="row-name">{`Search the parts for “${words}”`}</span>
          </button>
        </div>
      )}
    </Dialog>
  );
}
