// The bar at the top: the open mock-up, contact mode, undo and redo, access to every command.

import { hint, runCommand } from "../actions/commands";
import { formatCount } from "../math/units";
import { MODES, shownMockup } from "../model/document";
import { useWorkbench } from "./context";
import { Choice, CommandButton } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";
import { PeopleStrip } from "./people";
import { counted, partsText, trianglesText } from "./words";

export function Bar() {
  const wb = useWorkbench();
  const { store } = wb;
  const document = store.document.value;
  const mockup = shownMockup(document);
  const settings = store.settings.value;
  const doubts = document?.doubts.length ?? 0;
  return (
    <header id="bar" class="bar">
      {store.is_narrow.value && <CommandButton id="tree" icon="sidebar" pressed={store.is_tree_shown.value} />}
      <div class="brand">
        <svg viewBox="0 0 32 32" width="24" height="24" aria-hidden="true">
          <rect class="brand-back" width="32" height="32" rx="7" />
          <path class="brand-line" d="M6 24h20" />
          <path class="brand-tip" d="M9 8l7 12 7-12z" />
        </svg>
        <div class="brand-text">
          <h1>{mockup ? <Name text={mockup.name} /> : "feeler"}</h1>
          {mockup && (
            <p>{`${trianglesText(mockup.triangles, formatCount)}, ${partsText(mockup.parts - (document?.absent.length ?? 0), formatCount)}${document?.tool ? ` · ${document.tool.name}` : ""}`}</p>
          )}
        </div>
      </div>
      <div class="bar-group">
        <CommandButton id="undo" icon="undo" />
        <CommandButton id="redo" icon="redo" />
      </div>
      <div id="modes" class="bar-group" title={hint("mode")}>
        <Choice
          label="Contact"
          value={document?.mode ?? "stop"}
          disabled={store.is_read_only.value}
          options={MODES.map((mode) => ({ value: mode, text: MODE_NAMES[mode] }))}
          choose={(mode) => wb.run("set_mode", { mode })}
        />
      </div>
      <button
        type="button"
        class="command-box"
        title={hint("palette")}
        onClick={() => {
          store.dialog.value = "palette";
        }}
      >
        <Icon name="search" size={14} />
        <span>Search commands</span>
        <kbd>Ctrl+K</kbd>
      </button>
      {doubts > 0 && (
        <button
          type="button"
          class="button doubts-badge"
          title="What the loaders found doubtful about the files"
          onClick={() => runCommand(wb, "doubts")}
        >
          <Icon name="alert" size={14} />
          <span>{counted(doubts, "doubt")}</span>
        </button>
      )}
      <PeopleStrip />
      <div class="bar-group bar-rest">
        {store.opens.value && <CommandButton id="open-file" icon="folder" />}
        <CommandButton id="mute" icon={settings.is_muted ? "soundOff" : "sound"} pressed={settings.is_muted} />
        <CommandButton id="theme" icon={store.theme.value === "dark" ? "sun" : "moon"} />
        <CommandButton id="settings" icon="settings" />
        <CommandButton id="help" icon="help" />
      </div>
      <div class="bar-group">
        <More />
        {!store.is_narrow.value && <CommandButton id="tree" icon="sidebar" pressed={store.is_tree_shown.value} />}
        <CommandButton id="panels" icon="panels" pressed={store.are_panels_shown.value} />
      </div>
    </header>
  );
}

/** What has no room in a narrow bar. */
const MORE = [
  "people",
  "take-turn",
  "open-file",
  "open-sample",
  "mode",
  "mute",
  "theme",
  "settings",
  "help",
  "tour",
] as const;

function More() {
  const { store } = useWorkbench();
  const items = store.people.others.value.length > 0 ? ["people", "take-turn", ...MORE] : MORE;
  return (
    <button
      type="button"
      class="button square more"
      title="More"
      aria-label="More"
      aria-haspopup="menu"
      aria-expanded={store.menu.value?.items !== undefined}
      onClick={(event) => {
        const { right, bottom } = event.currentTarget.getBoundingClientRect();
        store.menu.value = { x: right, y: bottom, part: -1, point: null, at: { x: 0, y: 0 }, items };
      }}
    >
      <Icon name="more" />
    </button>
  );
}

const MODE_NAMES = { stop: "Stop", glide: "Glide", pass: "Pass" } as const;
