// A way as a film: play, scrub, its gaps as a curve, and its steps.

import { frameWay, playFilm, scrub, showHit, showPart, takeWay, type Way } from "../actions/cards";
import { type GuideOf, isGuiding, keepWay, toggleGuide } from "../actions/lines";
import type { Card, CardAnswer, Gap } from "../link/protocol";
import { formatAngle, formatLength, formatShare, type Unit } from "../math/units";
import { gapAt, tightest } from "../model/film";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";
import { Icon } from "./icons";
import { counted, partsText } from "./words";

const WIDTH = 280;
const HEIGHT = 56;
const MARGIN = 3;

export function WayPlayer({ card, answer }: { card: Card; answer: CardAnswer }) {
  const wb = useWorkbench();
  const { store } = wb;
  const film = store.film.value?.card === card.id ? store.film.value : null;
  const step = film?.step ?? 0;
  const way = answer.ways[step];
  if (!way) return null;
  const isSeveral = answer.ways.length > 1;
  const share = film?.share ?? 0;
  return (
    <div class="way">
      <div class="way-line">
        <IconButton
          icon={film?.is_playing ? "pause" : "play"}
          label={film?.is_playing ? "Pause" : isSeveral ? "Play all steps" : "Play the way"}
          run={() => playFilm(wb, card.id)}
        />
        <input
          type="range"
          min={0}
          max={1000}
          value={Math.round(1000 * share)}
          aria-label={isSeveral ? `Place in step ${step + 1}` : "Place on the way"}
          aria-valuetext={placeText(way, share, store.unit.value, (part) => store.nameOf(part))}
          onInput={(event) => scrub(wb, card.id, step, Number(event.currentTarget.value) / 1000)}
        />
        <IconButton icon="fit" label="Show the whole way" run={() => frameWay(wb, way)} />
      </div>
      {way.gaps.length > 1 && (
        <GapCurve gaps={way.gaps} share={share} unit={store.unit.value} go={(at) => scrub(wb, card.id, step, at)} />
      )}
      <p class="note">{placeText(way, share, store.unit.value, (part) => store.nameOf(part))}</p>
      {way.hit && (
        <button type="button" class="link" onClick={() => showHit(wb, card.id, step, way)}>
          {`Show where it meets ${store.nameOf(way.hit.part)}`}
        </button>
      )}
      {isSeveral ? (
        <ol class="steps" aria-label="Steps">
          {answer.ways.map((each, k) => (
            <li key={each.parts.join()} class={k === step && film ? "current" : ""}>
              <button type="button" class="link" onClick={() => scrub(wb, card.id, k, 0)}>
                {stepText(each, (part) => store.nameOf(part))}
              </button>
              <span class="note">{wayText(each, store.unit.value)}</span>
            </li>
          ))}
        </ol>
      ) : (
        <ul class="legs" aria-label="The way">
          {way.legs.map((leg, k) => (
            <li key={k}>{leg}</li>
          ))}
        </ul>
      )}
      <div class="button-row">
        {card.line === null && (
          <button
            type="button"
            class="button main"
            disabled={store.is_read_only.value || card.is_stale}
            title={
              card.is_stale ? "Parts were moved since: ask again" : "Adds it to the sequence; the parts are out then"
            }
            onClick={() => takeWay(wb, card.id)}
          >
            <Icon name="list" size={14} />
            <span>
              {isSeveral
                ? `Take ${counted(answer.ways.length, "step")} into the sequence`
                : "Take it into the sequence"}
            </span>
          </button>
        )}
        {card.question === "shorten" && card.is_good && <KeepButtons card={card} />}
        {card.is_good && card.question !== "way" && <GuideButton of={{ card: card.id, step }} parts={way.parts} />}
      </div>
    </div>
  );
}

function KeepButtons({ card }: { card: Card }) {
  const wb = useWorkbench();
  const isLocked = wb.store.is_read_only.value || card.is_stale;
  const title = card.is_stale ? "It is of another way now: ask again" : undefined;
  return (
    <>
      <button
        type="button"
        class="button main"
        disabled={isLocked}
        title={title ?? "Puts it in place of the way in the sequence"}
        onClick={() => keepWay(wb, card.id, false)}
      >
        <Icon name="check" size={14} />
        <span>Use it</span>
      </button>
      <button
        type="button"
        class="button"
        disabled={isLocked}
        title={title ?? "Adds it to the sequence as another line"}
        onClick={() => keepWay(wb, card.id, true)}
      >
        Keep both
      </button>
    </>
  );
}

/** Lets a way guide the hand, and ends it. */
export function GuideButton({ of, parts }: { of: GuideOf; parts: readonly number[] }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isOn = isGuiding(store.document.value?.guiding, of);
  return (
    <button
      type="button"
      class={`button ${isOn ? "on" : ""}`}
      disabled={store.is_read_only.value}
      title={isOn ? "The hand goes free (Esc)" : "Grips the parts, and draws your hand to the way while it is near"}
      onClick={() => toggleGuide(wb, of, parts)}
    >
      <Icon name="grip" size={14} />
      <span>{isOn ? "Stop guiding" : "Guide my hand"}</span>
    </button>
  );
}

function GapCurve({
  gaps,
  share,
  unit,
  go,
}: {
  gaps: readonly Gap[];
  share: number;
  unit: Unit;
  go: (share: number) => void;
}) {
  const wb = useWorkbench();
  const known = gaps.map((each) => each.gap).filter((gap) => gap !== null);
  const most = Math.max(...known, 1e-6);
  const x = (at: number): number => MARGIN + at * (WIDTH - 2 * MARGIN);
  const y = (gap: number | null): number => HEIGHT - MARGIN - ((gap ?? most) / most) * (HEIGHT - 2 * MARGIN);
  const line = gaps.map((each) => `${x(each.share).toFixed(1)},${y(each.gap).toFixed(1)}`).join(" ");
  const least = tightest(gaps);
  return (
    <div class="gap-curve">
      {/* biome-ignore lint/a11y/useKeyWithClickEvents: the slider above does the same by keys */}
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        role="img"
        aria-label={
          least?.gap != null ? `Gap along the way, least ${formatLength(least.gap, unit)}` : "Nothing comes near"
        }
        onClick={(event) => {
          const box = event.currentTarget.getBoundingClientRect();
          const at = (((event.clientX - box.left) / box.width) * WIDTH - MARGIN) / (WIDTH - 2 * MARGIN);
          go(Math.min(1, Math.max(0, at)));
        }}
      >
        <polyline points={line} />
        <line class="now" x1={x(share)} x2={x(share)} y1={0} y2={HEIGHT} />
        {least?.gap != null && <circle cx={x(least.share)} cy={y(least.gap)} r={3} />}
      </svg>
      {least?.gap != null && least.part !== null && (
        <button
          type="button"
          class="link"
          onClick={() => {
            go(least.share);
            showPart(wb, least.part ?? -1);
          }}
        >
          {`Tightest: ${formatLength(least.gap, unit)} to ${wb.store.nameOf(least.part)}`}
        </button>
      )}
    </div>
  );
}

function placeText(way: Way, share: number, unit: Unit, nameOf: (part: number) => string): string {
  const gap = gapAt(way.gaps, share);
  const there = `${formatShare(share)} of ${formatLength(way.length, unit)}`;
  if (!gap) return there;
  if (gap.gap === null || gap.part === null) return `${there} · nothing near`;
  return `${there} · ${formatLength(gap.gap, unit)} to ${nameOf(gap.part)}`;
}

const wayText = (way: Way, unit: Unit): string =>
  [
    formatLength(way.length, unit),
    ...(way.rotation > 0.01 ? [`turned ${formatAngle(way.rotation)}`] : []),
    ...(way.clearance !== null ? [`nearest ${formatLength(way.clearance, unit)}`] : []),
  ].join(" · ");

const stepText = (way: Way, nameOf: (part: number) => string): string =>
  way.parts.length === 1
    ? nameOf(way.parts[0] as number)
    : `${nameOf(way.parts[0] as number)} and ${partsText(way.parts.length - 1, String)} more`;
