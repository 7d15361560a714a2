// A timeline: play, scrub, step from entry to entry, and the gap over time as a curve. Of ways, of the sequence, of a
// record.

import type { Gap } from "../link/protocol";
import { formatLength, formatTime } from "../math/units";
import { gapAt, tightest } from "../model/film";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const WIDTH = 280;
const HEIGHT = 56;
const MARGIN = 3;
/** Two moments nearer than this are one, seconds. */
const SAME_S = 1e-6;

/** An entry of a timeline. */
export interface Stop {
  /** When it is reached, seconds. */
  readonly at: number;
  readonly title: string;
  /** What else is said of it; else its time. */
  readonly note?: string;
}

export interface TimelineProps {
  /** What is shown: "the way". */
  readonly name: string;
  readonly seconds: number;
  readonly at: number;
  /** By their share of all seconds. */
  readonly gaps: readonly Gap[];
  readonly stops: readonly Stop[];
  readonly is_playing: boolean;
  readonly disabled?: boolean;
  /** The entries are folded away at first. */
  readonly is_compact?: boolean;
  /** The entries are listed elsewhere. */
  readonly is_bare?: boolean;
  /** Plays from where it is, or pauses; null: it plays elsewhere. */
  readonly toggle: (() => void) | null;
  readonly go: (seconds: number) => void;
  /** Looks at the part of the tightest place. */
  readonly show: (part: number) => void;
}

export function Timeline(props: TimelineProps) {
  const { store } = useWorkbench();
  const { name, seconds, at, gaps, stops, is_playing, go } = props;
  const isLocked = props.disabled || seconds <= 0;
  const share = seconds > 0 ? Math.min(1, at / seconds) : 0;
  const text = momentText(props, share, store.unit.value, (part) => store.nameOf(part));
  const next = stops.find((stop) => stop.at > at + SAME_S);
  const previous = stops.filter((stop) => stop.at < at - SAME_S).at(-1);
  const current = stops.filter((stop) => stop.at <= at + SAME_S).length - 1;
  const least = tightest(gaps);
  const entries = (
    <ol class="steps" aria-label={`Entries of ${name}`}>
      {stops.map((stop, k) => (
        <li key={`${k} ${stop.at}`} class={k === current ? "current" : ""}>
          <button type="button" class="link" disabled={isLocked || is_playing} onClick={() => go(stop.at)}>
            {stop.title}
          </button>
          <span class="note">{stop.note ?? formatTime(stop.at)}</span>
        </li>
      ))}
    </ol>
  );
  return (
    <div class="timeline">
      <div class="timeline-line">
        <IconButton
          icon={is_playing ? "pause" : "play"}
          label={is_playing ? "Pause" : `Play ${name}`}
          disabled={isLocked || !props.toggle}
          run={() => props.toggle?.()}
        />
        {stops.length > 1 && (
          <>
            <IconButton
              icon="previous"
              label="Previous entry"
              disabled={isLocked || is_playing || (!previous && at <= SAME_S)}
              run={() => go(previous?.at ?? 0)}
            />
            <IconButton
              icon="next"
              label="Next entry"
              disabled={isLocked || is_playing || (!next && share >= 1)}
              run={() => go(next?.at ?? seconds)}
            />
          </>
        )}
        <input
          type="range"
          min={0}
          max={1000}
          value={Math.round(1000 * share)}
          disabled={isLocked}
          aria-label={`Place in ${name}`}
          aria-valuetext={text}
          onInput={(event) => go((Number(event.currentTarget.value) / 1000) * seconds)}
        />
        <select
          aria-label="Speed"
          title="Speed"
          value={`${store.speed.value}`}
          onChange={(event) => {
            store.speed.value = Number(event.currentTarget.value);
          }}
        >
          {SPEEDS.map((each) => (
            <option key={each} value={`${each}`}>
              {`${each} ×`}
            </option>
          ))}
        </select>
      </div>
      {gaps.length > 1 && least && <GapCurve {...props} least={least} share={share} isLocked={isLocked} />}
      <p class="note">{text}</p>
      {stops.length > 1 &&
        !props.is_bare &&
        (props.is_compact ? (
          <details>
            <summary>{`${stops.length} entries`}</summary>
            {entries}
          </details>
        ) : (
          entries
        ))}
    </div>
  );
}

/** Only where a gap is known: there is nothing to draw else. */
function GapCurve(props: TimelineProps & { least: Gap; share: number; isLocked: boolean }) {
  const { store } = useWorkbench();
  const { gaps, least, share, seconds, stops, go, isLocked } = props;
  const unit = store.unit.value;
  const known = gaps.map((each) => each.gap).filter((gap) => gap !== null);
  const most = Math.max(...known, 1e-6);
  const x = (at: number): number => MARGIN + at * (WIDTH - 2 * MARGIN);
  const y = (gap: number | null): number => HEIGHT - MARGIN - ((gap ?? most) / most) * (HEIGHT - 2 * MARGIN);
  const line = gaps.map((each) => `${x(each.share).toFixed(1)},${y(each.gap).toFixed(1)}`).join(" ");
  return (
    <div class="gap-curve">
      {/* biome-ignore lint/a11y/useKeyWithClickEvents: the slider above does the same by keys */}
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={`Gap along ${props.name}, least ${formatLength(least.gap ?? 0, unit)}`}
        onClick={(event) => {
          if (isLocked) return;
          const box = event.currentTarget.getBoundingClientRect();
          const at = (((event.clientX - box.left) / box.width) * WIDTH - MARGIN) / (WIDTH - 2 * MARGIN);
          go(Math.min(1, Math.max(0, at)) * seconds);
        }}
      >
        {stops.map((stop, k) => (
          <line
            key={`${k} ${stop.at}`}
            class="stop"
            x1={x(stop.at / seconds)}
            x2={x(stop.at / seconds)}
            y1={HEIGHT - 8}
            y2={HEIGHT}
          />
        ))}
        <polyline points={line} />
        <line class="now" x1={x(share)} x2={x(share)} y1={0} y2={HEIGHT} />
        <line class="least" x1={x(least.share)} x2={x(least.share)} y1={y(least.gap)} y2={y(least.gap)} />
      </svg>
      {least.gap !== null && least.part !== null && (
        <button
          type="button"
          class="link"
          disabled={isLocked}
          onClick={() => {
            go(least.share * seconds);
            props.show(least.part ?? -1);
          }}
        >
          {`Tightest: ${formatLength(least.gap, unit)} to ${store.nameOf(least.part)}`}
        </button>
      )}
    </div>
  );
}

function momentText(
  { seconds, at, gaps }: TimelineProps,
  share: number,
  unit: Parameters<typeof formatLength>[1],
  nameOf: (part: number) => string,
): string {
  const gap = gapAt(gaps, share);
  const there = `${formatTime(at)} of ${formatTime(seconds)}`;
  if (!gap) return there;
  if (gap.gap === null || gap.part === null) return `${there} · nothing near`;
  return `${there} · ${formatLength(gap.gap, unit)} to ${nameOf(gap.part)}`;
}
