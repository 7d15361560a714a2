// The pose of the hand: numbers to read and type, steps, contact mode, and the present contacts.

import { commandOf } from "../actions/commands";
import { labelOf } from "../actions/labels";
import { anglesOf, fromAngles, type Pose, position } from "../math/matrix";
import { angleFigure, formatAngle, formatForce, formatLength, lengthFigure } from "../math/units";
import { length, type Vec3 } from "../math/vectors";
import { touchedParts } from "../model/contact";
import { MODES } from "../model/document";
import { useWorkbench } from "./context";
import { Choice, CommandButton, Figure, IconButton } from "./fields";
import { Name } from "./names";
import { depthText } from "./words";

const AXES = ["X", "Y", "Z"] as const;
const STEPS_M = [1e-4, 1e-3, 1e-2] as const;
const STEPS_RAD = [1, 5, 15].map((degrees) => (degrees * Math.PI) / 180);

export function PosePanel() {
  const wb = useWorkbench();
  const { store, hand } = wb;
  const document = store.document.value;
  if (!store.has_hand.value || !document) return <EmptyHand />;
  const pose: Pose = Array.from(store.state.value?.pose ?? document.pose);
  const unit = store.unit.value;
  const settings = store.settings.value;
  const isLocked = store.is_read_only.value;
  const at = position(pose);
  const angles = anglesOf(pose);
  // The other figures stay what they are wished to be: the tool may be on its way there.
  const wished = (): Pose => hand.pose ?? pose;
  const moveTo = (next: Pose): Promise<boolean> => {
    hand.move(next, "keys");
    hand.put();
    return wb.rest();
  };
  const setPlace = (axis: 0 | 1 | 2, value: number): Promise<boolean> => {
    const next = position(wished());
    next[axis] = value;
    return moveTo(fromAngles(anglesOf(wished()), next));
  };
  const setAngle = (axis: 0 | 1 | 2, value: number): Promise<boolean> => {
    const next = anglesOf(wished());
    next[axis] = value;
    return moveTo(fromAngles(next, position(wished())));
  };
  const nudge = (axis: 0 | 1 | 2, kind: "length" | "angle", sign: 1 | -1): void => {
    const by: Vec3 = [0, 0, 0];
    by[axis] = sign * (kind === "length" ? settings.step_m : settings.step_rad);
    const zero: Vec3 = [0, 0, 0];
    const increment = kind === "length" ? { translation: by, rotation: zero } : { translation: zero, rotation: by };
    hand.nudge(increment, settings.frame, "keys");
    hand.put();
  };
  const held = document.gripped;
  const heldText = held.length === 1 ? wb.path(held[0] ?? -1) : `${held.length} parts`;
  return (
    <div class="panel-body">
      <section>
        <h2>In the hand</h2>
        <ToolChoice />
        <p class="held-name">
          {[document.tool?.name, held.length > 0 ? heldText : null].filter(Boolean).join(" and ")}
        </p>
        <div class="button-row">
          <CommandButton id="move" icon="move" text="Move" pressed={store.typed.value?.kind === "move"} />
          <CommandButton id="turn" icon="turn" text="Turn" pressed={store.typed.value?.kind === "turn"} />
          <CommandButton id="grip" icon="grip" text={labelOf(wb, commandOf("grip"))} />
        </div>
      </section>
      <section>
        <h2>Contact</h2>
        <Choice
          label="Contact mode"
          value={document.mode}
          disabled={isLocked}
          options={MODES.map((mode) => ({ value: mode, text: MODE_NAMES[mode], title: MODE_TITLES[mode] }))}
          choose={(mode) => wb.run("set_mode", { mode })}
        />
        <p class="note">{MODE_TITLES[document.mode]}</p>
      </section>
      <ContactReport />
      <section>
        <h2>Position</h2>
        <div class="figures">
          {([0, 1, 2] as const).map((axis) => (
            <div class={`axis-row axis-${axis}`} key={axis}>
              <Figure
                label={AXES[axis]}
                kind="length"
                unit={unit}
                value={at[axis]}
                step={settings.step_m}
                disabled={isLocked}
                change={(value) => setPlace(axis, value)}
              />
              <IconButton
                icon="minus"
                label={`${AXES[axis]} one step back`}
                disabled={isLocked}
                run={() => nudge(axis, "length", -1)}
              />
              <IconButton
                icon="plus"
                label={`${AXES[axis]} one step on`}
                disabled={isLocked}
                run={() => nudge(axis, "length", 1)}
              />
            </div>
          ))}
        </div>
      </section>
      <section>
        <h2>
          Turned <span class="note">about X, then Y, then Z</span>
        </h2>
        <div class="figures">
          {([0, 1, 2] as const).map((axis) => (
            <div class={`axis-row axis-${axis}`} key={axis}>
              <Figure
                label={AXES[axis]}
                kind="angle"
                unit={unit}
                value={angles[axis]}
                step={settings.step_rad}
                disabled={isLocked}
                change={(value) => setAngle(axis, value)}
              />
              <IconButton
                icon="minus"
                label={`One step back about ${AXES[axis]}`}
                disabled={isLocked}
                run={() => nudge(axis, "angle", -1)}
              />
              <IconButton
                icon="plus"
                label={`One step on about ${AXES[axis]}`}
                disabled={isLocked}
                run={() => nudge(axis, "angle", 1)}
              />
            </div>
          ))}
        </div>
      </section>
      <section>
        <h2>Steps</h2>
        <Choice
          label="Step of a length"
          value={String(settings.step_m)}
          options={STEPS_M.map((step) => ({ value: String(step), text: `${lengthFigure(step, unit)} ${unit}` }))}
          choose={(step) => store.set({ step_m: Number(step) })}
        />
        <Choice
          label="Step of an angle"
          value={String(settings.step_rad)}
          options={STEPS_RAD.map((step) => ({ value: String(step), text: `${angleFigure(step)}°` }))}
          choose={(step) => store.set({ step_rad: Number(step) })}
        />
        <Choice
          label="Axes"
          value={settings.frame}
          options={[
            { value: "world", text: "World axes" },
            { value: "tool", text: "Tool axes" },
          ]}
          choose={(frame) => store.set({ frame })}
        />
        <label class="check">
          <input
            type="checkbox"
            checked={settings.is_snapping}
            onChange={(event) => store.set({ is_snapping: event.currentTarget.checked })}
          />
          Drag in steps (Ctrl: the other way)
        </label>
      </section>
    </div>
  );
}

const MODE_NAMES = { stop: "Stop", glide: "Glide", pass: "Pass" } as const;
const MODE_TITLES = {
  stop: "The tool stops at the first contact, at any speed.",
  glide: "The tool slides along surfaces, and pushes back.",
  pass: "The tool goes through; the cut triangles are shown.",
} as const;

const NO_TOOL = "";

/** The content of the hand. */
function ToolChoice() {
  const wb = useWorkbench();
  const { store } = wb;
  const document = store.document.value;
  return (
    <label class="field">
      Tool
      <select
        value={document?.tool?.name ?? NO_TOOL}
        disabled={store.is_read_only.value || (document?.gripped.length ?? 0) > 0}
        onChange={(event) => wb.run("take_tool", { name: event.currentTarget.value || null })}
      >
        <option value={NO_TOOL}>none</option>
        {document?.tools.map((name) => (
          <option key={name} value={name}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}

function EmptyHand() {
  const { store } = useWorkbench();
  if (store.connection.value === "offline") {
    return (
      <div class="panel-body empty">
        <p>This file can be looked at: turn, hide, cut and measure. Nothing can be moved in it.</p>
      </div>
    );
  }
  return (
    <div class="panel-body empty">
      <p>The hand is empty.</p>
      <p class="note">Select a part and grip it with E, or take a tool. Your own: feeler view MOCKUP --tool TOOL.</p>
      <ToolChoice />
      <CommandButton id="grip" icon="grip" text="Grip the selection" />
    </div>
  );
}

/** The touched parts by name, and the force. */
function ContactReport() {
  const { store } = useWorkbench();
  const state = store.state.value;
  const unit = store.unit.value;
  if (!state) return null;
  const near: { part: number; distance: number }[] = [];
  for (const [k, part] of state.clearance_parts.entries()) near.push({ part, distance: state.clearance[7 * k] ?? 0 });
  const turn = Math.hypot(...state.torque);
  const touched = touchedParts(state);
  return (
    <section>
      <h2>Contact now</h2>
      <dl class="facts">
        <dt>Force</dt>
        <dd>{formatForce(length(state.force))}</dd>
        <dt>Torque</dt>
        <dd>{turn > 0 ? `${turn.toPrecision(2)} N m` : "0 N m"}</dd>
        <dt>Depth</dt>
        <dd>{depthText(state, unit) || "none"}</dd>
        <dt>Held back</dt>
        <dd>{state.blocked ? heldBack(state.pose, state.wish, unit) : "no"}</dd>
      </dl>
      <ul class="part-list" aria-label="Touched parts">
        {touched.map((part) => (
          <PartLine key={part} part={part} kind="hit" text="touches" />
        ))}
        {near
          .filter(({ part }) => !touched.includes(part))
          .map(({ part, distance }) => (
            <PartLine key={part} part={part} kind="near" text={formatLength(distance, unit)} />
          ))}
      </ul>
    </section>
  );
}

function PartLine({ part, kind, text }: { part: number; kind: "hit" | "near"; text: string }) {
  const wb = useWorkbench();
  return (
    <li>
      <button type="button" class="part-line" title={wb.path(part)} onClick={() => wb.select([part])}>
        <span class={`swatch ${kind}`} aria-hidden="true" />
        <span class="row-name">
          <Name text={wb.store.nameOf(part)} title={wb.path(part)} />
        </span>
        <span class="row-count">{text}</span>
      </button>
    </li>
  );
}

/** How far the tool stays behind the hand. */
function heldBack(pose: ArrayLike<number>, wish: ArrayLike<number>, unit: Parameters<typeof formatLength>[1]): string {
  const [a, b] = [position(pose), position(wish)];
  const gap = Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  let cosine = -1;
  for (const k of [0, 1, 2, 4, 5, 6, 8, 9, 10]) cosine += (pose[k] ?? 0) * (wish[k] ?? 0);
  const angle = Math.acos(Math.max(-1, Math.min(1, cosine / 2)));
  return gap > 1e-6 || angle < 1e-4 ? formatLength(gap, unit) : formatAngle(angle);
}
