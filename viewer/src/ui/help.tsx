// Help: all keys by group, and the mouse actions of the chosen style.

import { COMMANDS, type CommandGroup, type PageCommand, shownKey } from "../actions/commands";
import { STYLES, styleOf } from "../model/navigation";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";

const ACTIONS = {
  orbit: "Turn the view about the point under the pointer",
  pan: "Move the view",
  zoom: "Zoom",
} as const;

const withKeys = COMMANDS.filter((command) => command.keys.length > 0);
const GROUPS = [...new Set(withKeys.map((command) => command.group))] as CommandGroup[];

export function Help() {
  const { store } = useWorkbench();
  const style = styleOf(store.settings.value.style);
  return (
    <Dialog title="Help" kind="help">
      <div class="help-columns">
        <section class="help-group">
          <h3>Mouse</h3>
          <label class="field">
            Navigate as in
            <select value={style.id} onChange={(event) => store.set({ style: event.currentTarget.value })}>
              {STYLES.map((each) => (
                <option key={each.id} value={each.id}>
                  {each.title}
                </option>
              ))}
            </select>
          </label>
          <dl class="keys">
            {style.bindings.map((binding) => (
              <Line key={binding.text} what={ACTIONS[binding.action]} keys={[binding.text]} />
            ))}
            <Line
              what={style.wheel === "zoom" ? "Zoom to the pointer" : "Move the view; with Ctrl zoom"}
              keys={["Wheel"]}
            />
            <Line what="Select; with Ctrl or Shift more" keys={["Click"]} />
            <Line what="Drag the tool in the view plane" keys={["Drag the tool"]} />
            <Line what="Move or turn along one axis" keys={["Arrows, rings"]} />
            <Line what="Finer; in steps" keys={["Shift", "Ctrl"]} />
            <Line what="Centre there" keys={["Double click"]} />
            <Line what="Menu" keys={["Right click", "Long press"]} />
            <Line what="Open files" keys={["Drop them"]} />
          </dl>
        </section>
        <section class="help-group">
          <h3>While the tool is moved by keys</h3>
          <dl class="keys">
            <Line what="A length or an angle: 12.5, 3/8in, -90" keys={["0–9"]} />
            {withKeys
              .filter((command) => command.while)
              .map((command) => (
                <CommandLine key={command.id} command={command} />
              ))}
          </dl>
        </section>
        {GROUPS.map((group) => (
          <section class="help-group" key={group}>
            <h3>{group}</h3>
            <dl class="keys">
              {withKeys
                .filter((command) => command.group === group && !command.while)
                .map((command) => (
                  <CommandLine key={command.id} command={command} />
                ))}
            </dl>
          </section>
        ))}
      </div>
    </Dialog>
  );
}

const CommandLine = ({ command }: { command: PageCommand }) => (
  <Line what={command.title} keys={command.keys.slice(0, 2).map(shownKey)} />
);

function Line({ what, keys }: { what: string; keys: readonly string[] }) {
  return (
    <div class="key-line">
      <dt>{what}</dt>
      <dd>
        {keys.map((key) => (
          <kbd key={key}>{key}</kbd>
        ))}
      </dd>
    </div>
  );
}
