// The panel of a mechanism: a row for each number, with a slider that stops at contact and the bar of its free range.

import { useEffect, useRef } from "preact/hooks";
import {
  chooseMechanism,
  keepPosition,
  moverOf,
  showJoint,
  showMet,
  takeJoint,
  toggleWorst,
  typeJoint,
} from "../actions/joints";
import type { JointRange } from "../link/protocol";
import { formatAngle, formatLength } from "../math/units";
import { barOf, type JointNumber, spanOf } from "../model/joints";
import { useWorkbench } from "./context";
import { Figure, IconButton } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";

/** Steps of a slider. */
const STEPS = 1000;
const TYPED_RAD = Math.PI / 180;

export function MechanismPanel() {
  const wb = useWorkbench();
  const { store } = wb;
  const document = store.document.value;
  const mechanism = document?.mechanism ?? null;
  const isLocked = store.is_read_only.value;
  if (!document || !mechanism) {
    return (
      <div class="panel-body empty">
        <p>No mechanism is open.</p>
        <p class="note">
          A mechanism says which parts move, and how: doors, levers, slides. Drop a TOML file on the page, or start with
          feeler view MOCKUP --mechanism FILE.
        </p>
        <button type="button" class="button" disabled={isLocked} onClick={() => chooseMechanism(wb)}>
          <Icon name="folder" size={14} />
          <span>Open a mechanism</span>
        </button>
      </div>
    );
  }
  const ranges = new Map(document.joint_ranges.map((each) => [each.name, each]));
  return (
    <div class="panel-body">
      <section>
        <h2>
          <Name text={mechanism.name} title={mechanism.name} />
        </h2>
        <div class="button-row">
          <button type="button" class="button" disabled={isLocked} onClick={() => keepPosition(wb)}>
            <Icon name="list" size={14} />
            <span>Keep this position in the sequence</span>
          </button>
        </div>
        <div class="button-row">
          <button type="button" class="button" disabled={isLocked} onClick={() => chooseMechanism(wb)}>
            <span>Open another</span>
          </button>
          <button type="button" class="button" disabled={isLocked} onClick={() => wb.run("mechanism_close")}>
            <span>Close it</span>
          </button>
        </div>
      </section>
      <section>
        <h2>Joints</h2>
        <ul class="card-list joints" aria-label="Joints">
          {mechanism.numbers.map((number) => (
            <JointRow key={number.name} number={number} range={ranges.get(number.name)} />
          ))}
        </ul>
      </section>
    </div>
  );
}

function JointRow({ number, range }: { number: JointNumber; range: JointRange | undefined }) {
  const wb = useWorkbench();
  const { store } = wb;
  const unit = store.unit.value;
  const document = store.document.value;
  const shown = store.joints_shown.value?.values[number.name];
  const value = shown ?? document?.mechanism?.values[number.name] ?? 0;
  const isHeld = (document?.gripped.length ?? 0) > 0;
  const isLocked = store.is_read_only.value || isHeld;
  const isTurn = number.kind === "turn";
  const words = (each: number): string => (isTurn ? formatAngle(each) : formatLength(each, unit));
  const follows = number.root !== number.name;
  const span = spanOf(number, range, value);
  const isOn = document?.on_joint === number.name;
  return (
    <li class={`card joint ${isOn ? "playing" : ""}`} aria-label={number.name}>
      <header>
        <button type="button" class="link joint-name" title={number.name} onClick={() => showJoint(wb, number)}>
          <Name text={number.name} title={number.name} />
        </button>
        <IconButton
          icon="grip"
          label={isOn ? `Put ${number.name} down` : `Take ${number.name} in the hand, on its joint`}
          pressed={isOn}
          disabled={store.is_read_only.value || (isHeld && !isOn)}
          run={() => (isOn ? void wb.run("release") : void takeJoint(wb, number.name))}
        />
      </header>
      <div class="joint-slider">
        <Slider name={number.name} value={value} span={span} words={words} disabled={isLocked} />
        <Figure
          label={isTurn ? "Angle" : "Slide"}
          kind={isTurn ? "angle" : "length"}
          unit={unit}
          value={value}
          step={isTurn ? TYPED_RAD : store.settings.value.step_m}
          disabled={isLocked}
          change={(typed) => typeJoint(wb, number.name, typed)}
        />
      </div>
      {follows && <p class="note">{`follows ${number.root}`}</p>}
      {range && <RangeBar range={range} span={span} value={value} words={words} />}
    </li>
  );
}

function Slider(props: {
  name: string;
  value: number;
  span: readonly [number, number];
  words: (value: number) => string;
  disabled: boolean;
}) {
  const wb = useWorkbench();
  const input = useRef<HTMLInputElement>(null);
  const isByKey = useRef(false);
  const { name, value, span, words, disabled } = props;
  const [least, most] = span;
  const place = wb.store.joint_place.value;
  // A slider that was dragged past a stop goes back to it.
  useEffect(() => {
    if (input.current) input.current.value = String(value);
  }, [value, place, least, most]);
  const stopped = place?.name === name && place.is_stopped ? ", stopped" : "";
  return (
    <input
      ref={input}
      type="range"
      min={least}
      max={most}
      step={(most - least) / STEPS}
      value={value}
      disabled={disabled}
      aria-label={name}
      aria-valuetext={words(value) + stopped}
      onInput={(event) => {
        moverOf(wb).to(name, Number(event.currentTarget.value));
        if (isByKey.current) moverOf(wb).settle(true);
      }}
      onChange={() => {
        if (!isByKey.current) moverOf(wb).settle();
      }}
      onPointerDown={() => {
        isByKey.current = false;
      }}
      onKeyDown={(event) => {
        isByKey.current = true;
        if (event.key === "Escape" && moverOf(wb).cancel()) event.stopPropagation();
      }}
      onBlur={() => moverOf(wb).settle()}
    />
  );
}

const TEXTS = ["contact", "under 1 mm", "under 5 mm", "under 20 mm", "20 mm and more"] as const;

function RangeBar(props: {
  range: JointRange;
  span: readonly [number, number];
  value: number;
  words: (value: number) => string;
}) {
  const wb = useWorkbench();
  const { store } = wb;
  const { range, span, value, words } = props;
  if (range.state === "failed") return <p class="note">{`The range is not known: ${range.trouble}`}</p>;
  if (range.share < 0.2) {
    return <progress value={range.share} max={1} aria-label={`Range of ${range.name}`} />;
  }
  const { worst } = range;
  const at = (each: number): number => 100 * Math.min(1, Math.max(0, (each - span[0]) / (span[1] - span[0])));
  const least = worst ? `; least gap ${formatLength(worst.gap, store.unit.value)} at ${words(worst.value)}` : "";
  const text = `Free from ${words(range.lower)} to ${words(range.upper)}${least}`;
  const isGhost = store.joint_ghost.value === range.name;
  return (
    <>
      <svg class="joint-bar" viewBox="0 0 100 8" preserveAspectRatio="none" role="img" aria-label={text}>
        <title>{text}</title>
        <rect class="bar-back" x={0} y={0} width={100} height={8} />
        {barOf(range, span).map(({ from, to, gap }) => (
          <rect
            key={from}
            class={gap === null ? "bar-open" : `bar-gap-${gap}`}
            x={100 * from}
            y={0}
            width={Math.max(0.5, 100 * (to - from))}
            height={8}
          >
            {gap !== null && <title>{TEXTS[gap]}</title>}
          </rect>
        ))}
        <rect class="bar-now" x={at(value) - 0.4} y={0} width={0.8} height={8} />
      </svg>
      <p class="note">{text}</p>
      {range.trouble && <p class="note">{range.trouble}</p>}
      {range.state === "running" && <progress value={range.share} max={1} aria-label={`Gaps of ${range.name}`} />}
      <Stop text={`Below ${words(range.lower)}`} met={range.below} />
      <Stop text={`Above ${words(range.upper)}`} met={range.above} />
      {worst && (
        <button
          type="button"
          class={`button ${isGhost ? "on" : ""}`}
          aria-pressed={isGhost}
          onClick={() => toggleWorst(wb, range.name)}
        >
          <Icon name="ghost" size={14} />
          <span>Worst position as a ghost</span>
        </button>
      )}
    </>
  );
}

function Stop({ text, met }: { text: string; met: JointRange["below"] }) {
  const wb = useWorkbench();
  if (!met) return null;
  const { part, other } = met;
  return (
    <button
      type="button"
      class="part-line"
      title={`${wb.path(part)} meets ${wb.path(other)}`}
      onClick={() => showMet(wb, met)}
    >
      <span class="swatch hit" aria-hidden="true" />
      <span class="row-name">
        <Name text={`${wb.store.nameOf(part)} – ${wb.store.nameOf(other)}`} title={wb.path(other)} />
      </span>
      <span class="row-count">{text}</span>
    </button>
  );
}
