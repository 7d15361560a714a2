// Settings of this browser: appearance, navigation, keys, sound and touch.

import { MATERIALS, materialOf } from "../feel/materials";
import { formatShare, UNITS } from "../math/units";
import { MODES } from "../model/document";
import { STYLES } from "../model/navigation";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";
import { Choice, CommandButton } from "./fields";
import { NameSetting } from "./people";

export function Preferences() {
  const wb = useWorkbench();
  const { store } = wb;
  const settings = store.settings.value;
  return (
    <Dialog title="Settings" kind="settings">
      <div class="setting">
        <h3>Colours</h3>
        <Choice
          label="Colours"
          value={settings.theme}
          options={[
            { value: "system", text: "System" },
            { value: "dark", text: "Dark" },
            { value: "light", text: "Light" },
          ]}
          choose={(theme) => store.set({ theme })}
        />
      </div>
      {store.connection.value !== "offline" && (
        <div class="setting">
          <h3>Others on the same project</h3>
          <NameSetting />
        </div>
      )}
      <div class="setting">
        <h3>Navigation</h3>
        <label class="field">
          As in
          <select value={settings.style} onChange={(event) => store.set({ style: event.currentTarget.value })}>
            {STYLES.map((style) => (
              <option key={style.id} value={style.id}>
                {style.title}
              </option>
            ))}
          </select>
        </label>
      </div>
      <div class="setting">
        <h3>View</h3>
        <Choice
          label="Projection"
          value={settings.is_parallel ? "parallel" : "perspective"}
          options={[
            { value: "perspective", text: "Perspective" },
            { value: "parallel", text: "Parallel" },
          ]}
          choose={(projection) => store.set({ is_parallel: projection === "parallel" })}
        />
        <label class="check">
          <input
            type="checkbox"
            checked={settings.has_glide}
            onChange={(event) => store.set({ has_glide: event.currentTarget.checked })}
          />
          The view glides to where a command sends it (never where the system asks for reduced motion)
        </label>
      </div>
      <div class="setting">
        <h3>Unit and contact</h3>
        <Choice
          label="Unit"
          value={store.unit.value}
          disabled={!store.can_look.value}
          options={UNITS.map((unit) => ({ value: unit, text: unit }))}
          choose={(unit) => wb.run("set_unit", { unit })}
        />
        <Choice
          label="Contact"
          value={store.document.value?.mode ?? "stop"}
          disabled={store.is_read_only.value}
          options={MODES.map((mode) => ({ value: mode, text: mode }))}
          choose={(mode) => wb.run("set_mode", { mode })}
        />
      </div>
      <div class="setting">
        <h3>Sound and touch</h3>
        <label class="check">
          <input
            type="checkbox"
            checked={!settings.is_muted}
            onChange={(event) => store.set({ is_muted: !event.currentTarget.checked })}
          />
          Sound of contacts and sliding
        </label>
        <label class="field">
          Volume
          <input
            type="range"
            min="0"
            max="1"
            step="0.01"
            value={settings.volume}
            disabled={settings.is_muted}
            onInput={(event) => store.set({ volume: Number(event.currentTarget.value) })}
          />
        </label>
        <label class="check">
          <input
            type="checkbox"
            checked={settings.has_rumble}
            onChange={(event) => store.set({ has_rumble: event.currentTarget.checked })}
          />
          Rumble of gamepads and VR controllers
        </label>
        <label class="check">
          <input
            type="checkbox"
            checked={settings.has_event_rumble}
            disabled={!settings.has_rumble}
            onChange={(event) => store.set({ has_event_rumble: event.currentTarget.checked })}
          />
          Rumble at each contact
        </label>
        <label class="check">
          <input
            type="checkbox"
            checked={settings.has_force_rumble}
            disabled={!settings.has_rumble}
            onChange={(event) => store.set({ has_force_rumble: event.currentTarget.checked })}
          />
          Rumble with the force
        </label>
        <label class="field">
          Mock-up sounds like
          <select
            value={materialOf(store.document.value?.material ?? null)}
            disabled={store.is_read_only.value}
            onChange={(event) => wb.run("set_material", { material: materialOf(event.currentTarget.value) })}
          >
            {Object.keys(MATERIALS).map((name) => (
              <option key={name} value={name}>
                {name}
              </option>
            ))}
          </select>
        </label>
      </div>
      <div class="setting">
        <h3>Devices</h3>
        <label class="field">
          Gamepad: rest of the sticks
          <input
            type="range"
            min="0.02"
            max="0.4"
            step="0.01"
            value={settings.dead_zone}
            onInput={(event) => store.set({ dead_zone: Number(event.currentTarget.value) })}
          />
          <span class="figure-unit">{formatShare(settings.dead_zone)}</span>
        </label>
        <Choice
          label="In VR"
          value={settings.vr_size}
          options={[
            { value: "table", text: "On a table" },
            { value: "real", text: "At full size" },
          ]}
          choose={(vr_size) => store.set({ vr_size })}
        />
        <div class="button-row">
          <CommandButton id="spacemouse" icon="move" text="Connect a SpaceMouse" />
          <CommandButton id="xr" icon="eye" text="Enter VR" />
        </div>
      </div>
      <div class="setting">
        <h3>Keyboard</h3>
        <label class="check">
          <input
            type="checkbox"
            checked={settings.has_single_keys}
            onChange={(event) => store.set({ has_single_keys: event.currentTarget.checked })}
          />
          Single letters run commands (off: only keys with Ctrl or Alt, and the palette)
        </label>
      </div>
    </Dialog>
  );
}
