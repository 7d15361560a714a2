// The ways of a card as a film, with the step of each.

import { frameWay, playFilm, scrub, showHit, showPart, takeWay } from "../actions/cards";
import { type GuideOf, isGuiding, keepWay, toggleGuide } from "../actions/lines";
import type { Card, CardAnswer } from "../link/protocol";
import { formatAngle, formatLength, type Unit } from "../math/units";
import { type FilmOf, gapsOf, secondsOf, timeOf, type Way } from "../model/film";
import { useWorkbench } from "./context";
import { Icon } from "./icons";
import { Timeline } from "./timeline";
import { counted, partsText } from "./words";

/** A film with its timeline: of a card, or of the sequence. is_bare: its steps are listed elsewhere. */
export function FilmPlayer(props: { of: FilmOf; ways: readonly Way[]; name: string; is_bare?: boolean }) {
  const { of, ways, name, is_bare = false } = props;
  const wb = useWorkbench();
  const { store } = wb;
  const film = store.film.value?.card === of ? store.film.value : null;
  return (
    <Timeline
      name={name}
      seconds={ways.reduce((sum, way) => sum + secondsOf(way), 0)}
      at={film ? timeOf(film, ways) : 0}
      gaps={gapsOf(ways)}
      stops={ways.map((way, step) => ({
        at: timeOf({ step, share: 0 }, ways),
        title: stepText(way, (part) => store.nameOf(part)),
        note: wayText(way, store.unit.value),
      }))}
      is_bare={is_bare}
      is_playing={film?.is_playing ?? false}
      toggle={() => playFilm(wb, of)}
      go={(seconds) => scrub(wb, of, seconds)}
      show={(part) => showPart(wb, part)}
    />
  );
}

export function WayPlayer({ card, answer }: { card: Card; answer: CardAnswer }) {
  const wb = useWorkbench();
  const { store } = wb;
  const film = store.film.value?.card === card.id ? store.film.value : null;
  const step = film?.step ?? 0;
  const way = answer.ways[step];
  if (!way) return null;
  const isSeveral = answer.ways.length > 1;
  return (
    <div class="way">
      <FilmPlayer
        of={card.id}
        ways={answer.ways}
        name={isSeveral ? "all steps" : "the way"}
        is_bare={card.question === "task"}
      />
      {way.hit && (
        <button type="button" class="link" onClick={() => showHit(wb, card.id, step, way)}>
          {`Show where it meets ${store.nameOf(way.hit.part)}`}
        </button>
      )}
      {!isSeveral && (
        <>
          <p class="note">{wayText(way, store.unit.value)}</p>
          <ul class="legs" aria-label="The way">
            {way.legs.map((leg, k) => (
              <li key={k}>{leg}</li>
            ))}
          </ul>
        </>
      )}
      <div class="button-row">
        <button type="button" class="button" onClick={() => frameWay(wb, way)}>
          <Icon name="fit" size={14} />
          <span>Show the whole way</span>
        </button>
        {card.line === null && (
          <button
            type="button"
            class="button main"
            disabled={store.is_read_only.value || card.is_stale}
            title={
              card.is_stale
                ? "The mock-up is another one now: ask again"
                : "Adds it to the sequence; the parts are out then"
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

export const wayText = (way: Way, unit: Unit): string =>
  [
    formatLength(way.length, unit),
    ...(way.rotation > 0.01 ? [`turned ${formatAngle(way.rotation)}`] : []),
    ...(way.clearance !== null ? [`nearest ${formatLength(way.clearance, unit)}`] : []),
  ].join(" · ");

const stepText = (way: Way, nameOf: (part: number) => string): string =>
  way.parts.length === 1
    ? nameOf(way.parts[0] as number)
    : `${nameOf(way.parts[0] as number)} and ${partsText(way.parts.length - 1, String)} more`;
