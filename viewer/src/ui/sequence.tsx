// The sequence of removals: parts, order, clearances, and exports.

import { endFilm, openSequenceFilm } from "../actions/cards";
import { EXPORTS, type Export } from "../actions/exports";
import { askOfLine } from "../actions/lines";
import type { Card, SequenceLine } from "../link/protocol";
import { formatLength, type Unit } from "../math/units";
import { revisionText } from "../model/stale";
import { CardItem } from "./cards";
import { useWorkbench } from "./context";
import { CommandButton, IconButton, NameField } from "./fields";
import { Icon } from "./icons";
import { FilmPlayer, GuideButton } from "./way";

const FILES = Object.keys(EXPORTS) as Export[];

export function SequencePanel() {
  const wb = useWorkbench();
  const sequence = wb.store.document.value?.sequence ?? [];
  return (
    <div class="panel-body">
      <section>
        <h2>Removals</h2>
        {sequence.length === 0 && (
          <p class="note">
            Select a part, grip it with E, move it away, and release it with E: that is the first line here.
          </p>
        )}
        {sequence.length > 0 && <SequenceFilmPlayer />}
        <ol class="card-list sequence" aria-label="Removals">
          {sequence.map((line, k) => (
            <Line key={line.id} line={line} at={k} count={sequence.length} />
          ))}
        </ol>
      </section>
      <section>
        <h2>Export</h2>
        <div class="button-column">
          {FILES.map((name) => (
            <CommandButton key={name} id={name} icon="download" text={EXPORTS[name]} />
          ))}
        </div>
      </section>
    </div>
  );
}

/** The whole sequence as a film: in the picture only, the scene stays as it is. */
function SequenceFilmPlayer() {
  const wb = useWorkbench();
  const { store } = wb;
  const ways = store.sequence_film.value;
  if (store.connection.value === "offline") return null;
  if (!ways || store.film.value?.card !== "sequence")
    return (
      <div class="button-row">
        <button type="button" class="button" disabled={store.is_read_only.value} onClick={() => openSequenceFilm(wb)}>
          <Icon name="play" size={14} />
          <span>Show as a film</span>
        </button>
      </div>
    );
  return (
    <article class="card playing" aria-label="Film of the sequence">
      <header>
        <span class="note">In the picture only: the parts stay where they are.</span>
        <IconButton icon="close" label="End the film" run={() => endFilm(wb)} />
      </header>
      <FilmPlayer of="sequence" ways={ways} name="the sequence" />
    </article>
  );
}

function Line({ line, at, count }: { line: SequenceLine; at: number; count: number }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isLocked = store.is_read_only.value;
  const cards = (store.document.value?.cards ?? []).filter((card) => card.line === line.id).reverse();
  const isReplaying = store.document.value?.replaying === line.id;
  const document = store.document.value;
  // The last line that moves its parts tells where they lie.
  const isLast = !document?.sequence
    .slice(at + 1)
    .some((later) => later.parts.some((each) => line.parts.includes(each)));
  const isInside =
    isLast &&
    !line.joint &&
    line.parts.some((part) => document?.moved[part] !== undefined && !document.out.includes(part));
  const check = cards.find((card) => card.question === "way" && card.state === "done" && !card.is_stale);
  const earlier = revisionText(line.stale, (part) => store.nameOf(part));
  return (
    <li class={`card ${isReplaying ? "playing" : ""}`}>
      <header>
        <NameField
          label={`Name of ${line.joint ? "step" : "removal"} ${at + 1}`}
          value={line.name}
          disabled={isLocked}
          change={(name) => wb.run("sequence_rename", { id: line.id, name })}
        />
        <IconButton
          icon="play"
          label={line.joint ? `Go to the position of ${line.name}` : `Replay ${line.name}`}
          disabled={!store.can_look.value || isReplaying || (line.joint !== null && isLocked)}
          run={() => wb.run(line.joint ? "joint_step_go" : "sequence_replay", { id: line.id })}
        />
        <IconButton
          icon="up"
          label={`Move ${line.name} up`}
          disabled={isLocked || at === 0}
          run={() => wb.run("sequence_move", { id: line.id, index: at - 1 })}
        />
        <IconButton
          icon="down"
          label={`Move ${line.name} down`}
          disabled={isLocked || at === count - 1}
          run={() => wb.run("sequence_move", { id: line.id, index: at + 1 })}
        />
        <IconButton
          icon="trash"
          label={`Remove ${line.name} from the sequence`}
          disabled={isLocked}
          run={() => wb.run("sequence_remove", { id: line.id })}
        />
      </header>
      <p class="note">
        <button type="button" class="link" onClick={() => wb.select(line.parts)}>
          {line.parts.length === 1 ? "1 part" : `${line.parts.length} parts`}
        </button>
        {` · ${line.joint ? "moved by a joint" : clearanceText(line, check, store.unit.value)}${line.tool ? ` · with ${line.tool}` : ""}`}
        {isInside && (
          <span class="tag violated" title="Its parts lie inside the box of the mock-up: this is not a removal yet">
            not out
          </span>
        )}
      </p>
      {earlier && (
        <p class="note">
          <strong class="stale">{earlier}</strong>
        </p>
      )}
      {line.touched.length > 0 && (
        <p class="note touched">
          <span class="swatch hit" aria-hidden="true" />
          {`touched ${touchedText(line.touched)}`}
        </p>
      )}
      <div class="button-row">
        <button
          type="button"
          class="button"
          disabled={isLocked}
          title="Is it free at every pose, and between them? With the lines before it done"
          onClick={() => askOfLine(wb, "way_check", line.id)}
        >
          Check this way
        </button>
        <button
          type="button"
          class="button"
          disabled={isLocked || line.joint !== null}
          title="Looks for a shorter way of straight legs, and checks it"
          onClick={() => askOfLine(wb, "way_shorten", line.id)}
        >
          Shorten it
        </button>
        {!line.joint && <GuideButton of={{ line: line.id }} parts={line.parts} />}
      </div>
      {cards.length > 0 && (
        <ul class="card-list" aria-label={`Answers about ${line.name}`}>
          {cards.map((card) => (
            <CardItem key={card.id} card={card} />
          ))}
        </ul>
      )}
    </li>
  );
}

/** Of its newest check, if that is of the line as it is now; else what was measured when it was moved. */
function clearanceText(line: SequenceLine, check: Card | undefined, unit: Unit): string {
  if (check?.is_good === false) return "does not hold";
  const least = check?.is_good && check.clearances.length > 0 ? check.clearances[0] : line.least_clearance;
  return least == null
    ? check
      ? "nothing near"
      : "no clearance measured"
    : `${formatLength(least, unit)} least clearance`;
}

const touchedText = (paths: readonly string[]): string => {
  const names = paths.slice(0, 3).map((path) => path.split("/").at(-1) ?? path);
  return names.join(", ") + (paths.length > 3 ? ` and ${paths.length - 3} more` : "");
};
