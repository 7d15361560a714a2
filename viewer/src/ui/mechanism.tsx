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
import {
  barOf,
  GAP_CLASSES,
  gapText,
  isContact,
  isFixed,
  type JointNumber,
  KNOWN_SHARE,
  spanOf,
  stepped,
} from "../model/joints";
import { useWorkbench } from "./context";
import { Figure, IconButton } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";

const TYPED_RAD = Math.PI / 180;
/** A joint that is so near to a stop is at it: radians, metres. */
const AT_END = 1e-8;

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
        {document.joint_ranges.some((each) => each.curve.length > 0) && <Legend />}
        <ul class="card-list joints" aria-label="Joints">
          {mechanism.numbers.map((number) => (
            <JointRow key={number.name} number={number} range={ranges.get(number.name)} />
          ))}
        </ul>
      </section>
    </div>
  );
}

/** What the colours of the bars say. */
function Legend() {
  const unit = useWorkbench().store.unit.value;
  return (
    <ul class="gap-legend" aria-label="Colours of the bars: the gap">
      {GAP_CLASSES.map((gap) => (
        <li key={gap}>
          <span class={`swatch bar-gap-${gap}`} aria-hidden="true" />
          {gapText(gap, unit)}
        </li>
      ))}
    </ul>
  );
}

function JointRow({ number, range }: { number: JointNumber; range: JointRange | undefined }) {
  const wb = useWorkbench();
  const { store } = wb;
  const unit = store.unit.value;
  const document = store.document.value;
  // What was known stays, until it is known again: rows keep their height while another joint moves.
  const last = useRef<JointRange | undefined>(undefined);
  const isKnown = range !== undefined && (range.state === "failed" || range.share >= KNOWN_SHARE);
  if (isKnown || !range) last.current = range;
  const known = last.current;
  const shown = store.joints_shown.value?.values[number.name];
  const value = shown ?? document?.mechanism?.values[number.name] ?? 0;
  const isHeld = (document?.gripped.length ?? 0) > 0;
  const isLocked = store.is_read_only.value || isHeld || store.people.is_barred.value;
  const isTurn = number.kind === "turn";
  const words = (each: number): string => (isTurn ? formatAngle(each) : formatLength(each, unit));
  const follows = number.root !== number.name;
  const span = spanOf(number, known, value);
  const step = isTurn ? TYPED_RAD : store.settings.value.step_m;
  const isOn = document?.on_joint === number.name;
  return (
    <li class={`card joint ${isOn ? "playing" : ""}`} aria-label={number.name} aria-busy={range !== known}>
      <header>
        <button type="button" class="link joint-name" title={number.name} onClick={() => showJoint(wb, number)}>
          <Name text={number.name} title={number.name} />
        </button>
        <Figure
          label={`${number.name}, ${isTurn ? "angle" : "slide"}`}
          kind={isTurn ? "angle" : "length"}
          unit={unit}
          value={value}
          step={step}
          disabled={isLocked}
          change={(typed) => typeJoint(wb, number.name, typed)}
        />
        <IconButton
          icon="grip"
          label={isOn ? `Put ${number.name} down` : `Take ${number.name} in the hand, on its joint`}
          pressed={isOn}
          disabled={isOn ? store.is_read_only.value : isLocked}
          run={() => (isOn ? void wb.run("release") : void takeJoint(wb, number.name))}
        />
      </header>
      <div class={`joint-track ${range === known ? "" : "stale"}`}>
        <Bar range={known?.state === "failed" ? undefined : known} span={span} />
        <Slider name={number.name} value={value} span={span} step={step} words={words} disabled={isLocked} />
      </div>
      {follows && <p class="note">{`Follows ${number.root}`}</p>}
      {known ? (
        <Facts range={known} value={value} words={words} />
      ) : (
        range && <progress value={range.share} max={1} aria-label={`Range of ${range.name}`} />
      )}
    </li>
  );
}

function Slider(props: {
  name: string;
  value: number;
  span: readonly [number, number];
  step: number;
  words: (value: number) => string;
  disabled: boolean;
}) {
  const wb = useWorkbench();
  const input = useRef<HTMLInputElement>(null);
  const { name, value, span, step, words, disabled } = props;
  const [least, most] = span;
  const place = wb.store.joint_place.value;
  // A slider that was dragged past a stop goes back to it.
  useEffect(() => {
    if (input.current) input.current.value = String(value);
  }, [value, place, least, most]);
  const stopped = place?.name === name && place.stop ? ", stopped" : "";
  const onKey = (event: KeyboardEvent): void => {
    const mover = moverOf(wb);
    if (event.key === "Escape") {
      if (mover.cancel()) event.stopPropagation();
      return;
    }
    // From where it is wanted, so that keys that follow each other fast add up.
    const now = mover.wantedOf(name) ?? value;
    const next = stepped(event, now, step, span);
    if (next === null) return;
    event.preventDefault();
    event.stopPropagation();
    mover.to(name, next);
    mover.settle(true);
  };
  return (
    <input
      ref={input}
      type="range"
      min={least}
      max={most}
      step="any"
      value={value}
      disabled={disabled}
      aria-label={name}
      aria-valuetext={words(value) + stopped}
      onInput={(event) => moverOf(wb).to(name, Number(event.currentTarget.value))}
      onChange={() => moverOf(wb).settle()}
      onKeyDown={onKey}
      onBlur={() => moverOf(wb).settle()}
    />
  );
}

/** The free range, coloured by the gap, under the slider. */
function Bar({ range, span }: { range: JointRange | undefined; span: readonly [number, number] }) {
  return (
    <svg class="joint-bar" viewBox="0 0 100 8" preserveAspectRatio="none" aria-hidden="true">
      <rect class="bar-back" x={0} y={0} width={100} height={8} />
      {(range ? barOf(range, span) : []).map(({ from, to, gap }) => (
        <rect
          key={from}
          class={gap === null ? "bar-open" : `bar-gap-${gap}`}
          x={100 * from}
          y={0}
          width={Math.max(0.5, 100 * (to - from))}
          height={8}
        />
      ))}
    </svg>
  );
}

/** What is known of a range, in words: how far it goes, what stops it, and where it is narrowest. */
function Facts(props: { range: JointRange; value: number; words: (value: number) => string }) {
  const wb = useWorkbench();
  const { store } = wb;
  const { range, value, words } = props;
  if (range.state === "failed") return <p class="note">{`The range is not known: ${range.trouble}`}</p>;
  const { worst, lower, upper } = range;
  const isGhost = store.joint_ghost.value === range.name;
  const gap = worst && (isContact(worst.gap) ? "contact" : formatLength(worst.gap, store.unit.value));
  return (
    <>
      <p class="note">{isFixed(range) ? "Blocked both ways" : `Free from ${words(lower)} to ${words(upper)}`}</p>
      {range.trouble && <p class="note">{range.trouble}</p>}
      <Stop text={`below ${words(lower)}`} met={range.below} isAt={value <= lower + AT_END} />
      <Stop text={`above ${words(upper)}`} met={range.above} isAt={value >= upper - AT_END} />
      {worst && (
        <button
          type="button"
          class={`part-line ${isGhost ? "on" : ""}`}
          aria-pressed={isGhost}
          title={`${wb.path(worst.part)} comes nearest to ${wb.path(worst.other)}. Shows it as a ghost`}
          onClick={() => toggleWorst(wb, range.name)}
        >
          <Icon name="ghost" size={12} />
          <Pair of={worst} />
          <span class="row-count">{`${gap} at ${words(worst.value)}`}</span>
        </button>
      )}
      {range.state === "running" && <progress value={range.share} max={1} aria-label={`Gaps of ${range.name}`} />}
    </>
  );
}

/** Two parts, each cut on its own where there is no room. */
function Pair({ of: { part, other } }: { of: { readonly part: number; readonly other: number } }) {
  const wb = useWorkbench();
  return (
    <span class="row-name pair-name">
      <Name text={wb.store.nameOf(part)} title={wb.path(part)} />
      <span>–</span>
      <Name text={wb.store.nameOf(other)} title={wb.path(other)} />
    </span>
  );
}

function Stop({ text, met, isAt }: { text: string; met: JointRange["below"]; isAt: boolean }) {
  const wb = useWorkbench();
  if (!met) return null;
  return (
    <button
      type="button"
      class={`part-line ${isAt ? "on" : ""}`}
      title={`${wb.path(met.part)} meets ${wb.path(met.other)}`}
      onClick={() => showMet(wb, met)}
    >
      <span class="swatch hit" aria-hidden="true" />
      <Pair of={met} />
      <span class="row-count">{isAt ? "stopped here" : text}</span>
    </button>
  );
}
