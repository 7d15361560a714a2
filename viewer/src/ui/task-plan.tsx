// The plan of a task: a Gantt chart by person, the step that is looked at, and the edits.

import { useSignal } from "@preact/signals";
import { useEffect, useId, useState } from "preact/hooks";
import { showPart } from "../actions/cards";
import { editTask, showStep } from "../actions/tasks";
import type { Card, CardAnswer, TaskAnswer, TaskSight, TaskStepFacts } from "../link/protocol";
import type { Way } from "../model/film";
import {
  clockText,
  endOf,
  type Lane,
  lanesOf,
  minutesText,
  parseSeconds,
  shortNames,
  sightText,
  ticksOf,
  VERBS,
  verbClass,
} from "../model/task";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";
import { WayPlayer, wayText } from "./way";

/** Share of the axis from which a figure has no room to the right of its mark. */
const LATE = 0.9;

/** The answer of a task. */
export function TaskPlan({ card, answer, task }: { card: Card; answer: CardAnswer; task: TaskAnswer }) {
  const { store } = useWorkbench();
  const film = store.film.value?.card === card.id ? store.film.value : null;
  const number = Math.min(film?.step ?? 0, task.steps.length - 1);
  const step = task.steps[number];
  const { off, times, before } = card.edits;
  const edited = [...off, ...times.map(([path]) => path), ...before.flat()];
  const paths = store.paths.value;
  const names = shortNames([...task.steps.map((each) => paths[each.part] ?? ""), ...edited]);
  const nameOf = (part: number): string => names.get(paths[part] ?? "") || store.nameOf(part);
  return (
    <div class="task">
      {!task.is_complete && <p class="note">The search ended at its limit: there may be a quicker plan.</p>}
      {step && (
        <>
          <Gantt card={card} answer={answer} task={task} current={number} nameOf={nameOf} />
          <StepDetail
            key={`${card.id} ${number}`}
            card={card}
            task={task}
            step={step}
            number={number}
            way={answer.ways[number]}
            nameOf={nameOf}
          />
          <WayPlayer card={card} answer={answer} />
        </>
      )}
      <Blocked task={task} />
      <Edits card={card} names={names} />
      {task.notes.map((note) => (
        <p key={note} class="note">
          {note}
        </p>
      ))}
    </div>
  );
}

interface GanttProps {
  card: Card;
  answer: CardAnswer;
  task: TaskAnswer;
  current: number;
  nameOf: (part: number) => string;
}

function Gantt(props: GanttProps) {
  const { task } = props;
  const end = endOf(task);
  const lanes = lanesOf(task);
  return (
    <div class="gantt">
      <ul class="gantt-legend" aria-label="Colours of the bars">
        {VERBS.filter((verb) => task.steps.some((step) => step.verb === verb)).map((verb) => (
          <li key={verb}>
            <span class={`swatch ${verbClass(verb)}`} aria-hidden="true" />
            {verb}
          </li>
        ))}
      </ul>
      {lanes.map((lane) => (
        <LaneRows key={lane.person} lane={lane} end={end} isAlone={lanes.length === 1} {...props} />
      ))}
      <div class="gantt-axis" aria-hidden="true">
        {ticksOf(end).map((tick) => (
          <span key={tick} class={tick > LATE * end ? "late" : ""} style={{ left: `${(100 * tick) / end}%` }}>
            {minutesText(tick)}
          </span>
        ))}
      </div>
      <p class="note gantt-unit">minutes</p>
    </div>
  );
}

interface LaneProps {
  lane: Lane;
  end: number;
  isAlone: boolean;
  card: Card;
  answer: CardAnswer;
  current: number;
  nameOf: (part: number) => string;
}

function LaneRows({ lane, end, isAlone, card, answer, current, nameOf }: LaneProps) {
  const wb = useWorkbench();
  const name = `Steps of person ${lane.person + 1}`;
  return (
    <>
      {!isAlone && <h3>{`Person ${lane.person + 1}`}</h3>}
      <ol class="gantt-rows" aria-label={isAlone ? "Steps" : name}>
        {lane.bars.map(({ number, step }) => (
          <li key={number}>
            <button
              type="button"
              class="gantt-row"
              aria-current={number === current ? "step" : undefined}
              title={`${step.verb} ${wb.path(step.part)}${step.tool ? ` with ${step.tool}` : ""}`}
              onClick={() => showStep(wb, card.id, answer, number)}
            >
              <span class="gantt-name">
                {`${number + 1} ${step.verb} ${nameOf(step.part)}`}
                <span class="note">{`${step.is_typed ? "typed · " : ""}${clockText(step.seconds)}`}</span>
              </span>
              <span class="gantt-track">
                <span
                  class={`gantt-bar ${verbClass(step.verb)}`}
                  style={{ left: `${(100 * step.start) / end}%`, width: `${(100 * step.seconds) / end}%` }}
                />
              </span>
            </button>
          </li>
        ))}
      </ol>
    </>
  );
}

interface StepProps {
  card: Card;
  task: TaskAnswer;
  step: TaskStepFacts;
  number: number;
  way: Way | undefined;
  nameOf: (part: number) => string;
}

function StepDetail({ card, task, step, number, way, nameOf }: StepProps) {
  const wb = useWorkbench();
  const { store } = wb;
  const later = useSignal("");
  const isLocked = store.is_read_only.value;
  const path = wb.path(step.part);
  const others = task.steps.flatMap((other, k) => (k < number && other.part !== step.part ? [{ other, k }] : []));
  return (
    <section class="task-step" aria-label={`Step ${number + 1}`}>
      <h3>{`${number + 1} ${step.verb} ${nameOf(step.part)}`}</h3>
      <dl class="facts">
        <div>
          <dt>tool</dt>
          <dd>{step.tool || (step.verb === "take out" ? "by hand" : "not checked")}</dd>
        </div>
        {step.strokes > 0 && (
          <div>
            <dt>strokes</dt>
            <dd>{`${step.strokes} of ${Math.round(Math.min(step.swing_deg ?? 360, 360))}°`}</dd>
          </div>
        )}
        <div>
          <dt>time</dt>
          <dd>{`${clockText(step.seconds)} ± ${clockText(step.spread)}${step.is_typed ? ", typed" : ""}`}</dd>
        </div>
        {way && way.length > 0 && (
          <div>
            <dt>way</dt>
            <dd>{wayText(way, store.unit.value)}</dd>
          </div>
        )}
      </dl>
      <p class="note">{step.arithmetic.replaceAll("+-", "±")}</p>
      {step.verb !== "take out" && <Sight card={card.id} task={task} number={number} />}
      <p class="note">{step.because}</p>
      <div class="button-row">
        <TimeField
          seconds={card.edits.times.find(([each]) => each === path)?.[1] ?? null}
          disabled={isLocked}
          change={(seconds) => editTask(wb, card, "time", step.part, seconds === null ? {} : { seconds })}
        />
        <button
          type="button"
          class="button"
          disabled={isLocked}
          title="Plans as if it was off at the beginning"
          onClick={() => editTask(wb, card, "off", step.part)}
        >
          Already off
        </button>
      </div>
      {others.length > 0 && (
        <div class="button-row">
          <label class="task-before">
            <span>Do it before</span>
            <select
              value={later.value}
              disabled={isLocked}
              onChange={(event) => {
                later.value = event.currentTarget.value;
              }}
            >
              <option value="">choose a step</option>
              {others.map(({ other, k }) => (
                <option key={k} value={String(other.part)}>
                  {`${k + 1} ${other.verb} ${nameOf(other.part)}`}
                </option>
              ))}
            </select>
          </label>
          <button
            type="button"
            class="button"
            disabled={isLocked || later.value === ""}
            onClick={() => editTask(wb, card, "before", step.part, { later: Number(later.value) })}
          >
            Force the order
          </button>
        </div>
      )}
    </section>
  );
}

/** What the mechanic sees of a fastener from the best eye: a picture and the share. */
function Sight(props: { card: number; task: TaskAnswer; number: number }) {
  const { card, task, number } = props;
  const wb = useWorkbench();
  const [seen, setSeen] = useState<TaskSight | null | undefined>(undefined);
  const [trouble, setTrouble] = useState("");
  useEffect(() => {
    let isOver = false;
    const known = sights.get(task) ?? new Map<number, Promise<TaskSight | null>>();
    sights.set(task, known);
    const asked = known.get(number) ?? wb.ask("task_sight", { id: card, step: number });
    known.set(number, asked);
    asked.then(
      (found) => {
        if (!isOver) setSeen(found);
      },
      (error: unknown) => {
        known.delete(number);
        if (!isOver) setTrouble(error instanceof Error ? error.message : String(error));
      },
    );
    return () => {
      isOver = true;
    };
  }, [wb, card, task, number]);
  if (trouble) return <p class="note">{`What is seen is not known: ${trouble}`}</p>;
  if (seen === null) return null;
  const name = wb.store.nameOf(task.steps[number]?.part ?? -1);
  const said = seen && sightText(seen.share);
  const hidden = seen && seen.share < 1 ? seen.hidden_by.map((part) => wb.store.nameOf(part)).join(", ") : "";
  return (
    <figure class="task-sight" aria-busy={seen === undefined}>
      {seen ? (
        <img
          src={`data:image/png;base64,${seen.picture}`}
          width={seen.size[0]}
          height={seen.size[1]}
          alt={`${name}, in blue, from where it is seen best`}
        />
      ) : (
        <div class="task-sight-waiting" aria-hidden="true" />
      )}
      <figcaption class="note">
        {seen ? `${said}${hidden ? `; in front of it: ${hidden}` : ""}` : "Looking at it…"}
      </figcaption>
    </figure>
  );
}

const sights = new WeakMap<TaskAnswer, Map<number, Promise<TaskSight | null>>>();

/** The seconds of a step that are typed: empty, they are counted. */
function TimeField(props: { seconds: number | null; disabled: boolean; change: (seconds: number | null) => void }) {
  const [draft, setDraft] = useState<string | null>(null);
  const shown = props.seconds === null ? "" : String(props.seconds);
  const [isTold, setTold] = useState(false);
  const id = useId();
  const isWrong = draft !== null && draft.trim() !== "" && parseSeconds(draft) === null;
  const reset = (): void => {
    setDraft(null);
    setTold(false);
  };
  const settle = (): void => {
    setTold(isWrong);
    if (isWrong) return;
    const next = !draft?.trim() ? null : parseSeconds(draft);
    if (draft !== null && next !== props.seconds) props.change(next);
    reset();
  };
  return (
    <>
      <label class="figure task-time">
        <span class="figure-label">Time</span>
        <input
          type="text"
          inputMode="decimal"
          autocomplete="off"
          spellcheck={false}
          placeholder="counted"
          title="Seconds, or 1.5 min, or 1:30; empty: counted"
          value={draft ?? shown}
          aria-invalid={isWrong}
          aria-describedby={isTold && isWrong ? id : undefined}
          disabled={props.disabled}
          onInput={(event) => setDraft(event.currentTarget.value)}
          onBlur={settle}
          onKeyDown={(event) => {
            if (event.key === "Enter") settle();
            else if (event.key === "Escape") {
              event.stopPropagation();
              reset();
            }
          }}
        />
        <span class="figure-unit">s</span>
      </label>
      {isTold && isWrong && (
        <p id={id} class="field-error" role="alert">
          Type seconds such as 90, or 1.5 min, or 1:30
        </p>
      )}
    </>
  );
}

function Blocked({ task }: { task: TaskAnswer }) {
  const wb = useWorkbench();
  if (task.blocked.length === 0) return null;
  return (
    <ul class="blockers" aria-label="What blocks it">
      {task.blocked.map(({ part, because, blockers }, k) => (
        <li key={k}>
          {part === null ? (
            <span>all together</span>
          ) : (
            <button type="button" class="link" title={wb.path(part)} onClick={() => showPart(wb, part)}>
              {wb.store.nameOf(part)}
            </button>
          )}
          <span class="note">
            {because}
            {blockers.length > 0 && `; in its way: ${blockers.map((each) => wb.store.nameOf(each)).join(", ")}`}
          </span>
        </li>
      ))}
    </ul>
  );
}

/** What the user changed of the plan, to take back. */
function Edits({ card, names }: { card: Card; names: ReadonlyMap<string, string> }) {
  const wb = useWorkbench();
  const isLocked = wb.store.is_read_only.value;
  const { off, times, before } = card.edits;
  if (off.length + times.length + before.length === 0) return null;
  const last = (path: string): string => names.get(path) ?? path;
  const rows = [
    ...off.map((path) => ({ text: `${last(path)} is already off`, undo: () => editTask(wb, card, "on", path) })),
    ...times.map(([path, seconds]) => ({
      text: `${last(path)} takes ${clockText(seconds)}, typed`,
      undo: () => editTask(wb, card, "time", path),
    })),
    ...before.map(([first, then]) => ({
      text: `${last(first)} goes before ${last(then)}`,
      undo: () => editTask(wb, card, "free", first, { later: then }),
    })),
  ];
  return (
    <section class="task-edits">
      <h3>Your changes</h3>
      <ul aria-label="Your changes">
        {rows.map(({ text, undo }) => (
          <li key={text}>
            <span>{text}</span>
            <IconButton icon="close" label={`Take back: ${text}`} disabled={isLocked} run={undo} />
          </li>
        ))}
      </ul>
    </section>
  );
}
