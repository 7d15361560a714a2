// Questions about parts, and their answers: cards that stay.

import { useState } from "preact/hooks";
import { ask, askAgain, isAway, openCard, removeCard, showPart } from "../actions/cards";
import type { Card, CardAnswer, CardQuestion } from "../link/protocol";
import { formatShare } from "../math/units";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { Icon } from "./icons";
import { ReachList } from "./reaches";
import { TaskPlan } from "./task-plan";
import { WayPlayer } from "./way";
import { partsText } from "./words";

/** The questions, in the words of somebody who has them. */
export const QUESTIONS: Readonly<Record<Exclude<CardQuestion, "task">, string>> = {
  removal: "Can it come out?",
  order: "What has to go first?",
  access: "Which tool reaches its bolts?",
  swept: "What room does it need?",
};

/** So many blockers are named at first; the others are rarely to blame. */
const MOST_BLOCKERS = 5;

export function AskPanel() {
  const { store } = useWorkbench();
  const cards = (store.document.value?.cards ?? []).filter((card) => card.question !== "task");
  const selection = store.selection.value;
  const only = selection.size === 1 ? [...selection][0] : undefined;
  const what = only !== undefined ? store.nameOf(only) : partsText(selection.size, String);
  return (
    <div class="panel-body">
      <section>
        <h2>Ask</h2>
        <p class="note">
          {selection.size > 0
            ? `About ${what}:`
            : "Select one part or several, then ask. Hidden parts count, parts that are out do not."}
        </p>
        <div class="button-column">
          {(Object.keys(QUESTIONS) as (keyof typeof QUESTIONS)[]).map((question) => (
            <CommandButton
              key={question}
              id={`ask-${question === "access" ? "tools" : question}`}
              icon={ICONS[question]}
              text={QUESTIONS[question]}
            />
          ))}
          <CommandButton id="clashes-of" icon="alert" text="What clashes with it?" />
        </div>
      </section>
      <section>
        <h2>Answers</h2>
        {cards.length === 0 && (
          <p class="note">An answer stays here until you remove it. You can go on working meanwhile.</p>
        )}
        <ul class="card-list" aria-label="Answers">
          {[...cards].reverse().map((card) => (
            <CardItem key={card.id} card={card} />
          ))}
        </ul>
      </section>
    </div>
  );
}

const ICONS = { removal: "back", order: "list", access: "turn", swept: "explode" } as const;

/** A question and its answer; a click on it opens the whole answer. */
export function CardItem({ card }: { card: Card }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isLocked = store.is_read_only.value;
  const isOpen = store.card.value === card.id;
  const isBusy = card.state === "waiting" || card.state === "running";
  const answer = store.answers.value.get(card.id);
  return (
    <li class={`card question ${isOpen ? "playing" : ""} ${tone(card)}`}>
      <header>
        <button
          type="button"
          class="finding-text"
          aria-expanded={isOpen}
          onClick={() => openCard(wb, isOpen ? null : card.id)}
        >
          {card.title}
        </button>
        {!isBusy && (
          <IconButton
            icon="turn"
            label={`Ask again: ${card.title}`}
            disabled={isLocked}
            run={() => askAgain(wb, card.id)}
          />
        )}
        <IconButton
          icon={isBusy ? "close" : "trash"}
          label={`${isBusy ? "Cancel" : "Remove"}: ${card.title}`}
          disabled={isLocked}
          run={() => (isBusy ? wb.run("card_cancel", { id: card.id }) : removeCard(wb, card.id))}
        />
      </header>
      {isBusy ? (
        <p class="note" role="status">
          {card.state === "waiting"
            ? "Waits for the question before it."
            : `${card.stage || "Searching"} · ${formatShare(card.share)}`}
          <progress value={card.state === "waiting" ? undefined : card.share} max={1} aria-label={card.title} />
        </p>
      ) : (
        <p class="answer" role="status">
          <Icon name={card.is_good ? "check" : "alert"} size={14} />
          <span>{card.sentence}</span>
        </p>
      )}
      <p class="note">
        {card.setting}
        {card.is_stale && (
          <strong class="stale">
            {card.is_earlier
              ? " · about an earlier revision"
              : card.line === null
                ? " · parts were moved since"
                : " · the way, or what is around it, changed since"}
          </strong>
        )}
      </p>
      {isOpen && answer && <Answer card={card} answer={answer} />}
    </li>
  );
}

const tone = (card: Card): string =>
  card.state !== "done"
    ? card.state === "failed"
      ? "is-bad"
      : ""
    : card.is_good
      ? "is-good"
      : card.is_good === false
        ? "is-bad"
        : "";

function Answer({ card, answer }: { card: Card; answer: CardAnswer }) {
  if (answer.task) return <TaskPlan card={card} answer={answer} task={answer.task} />;
  return (
    <>
      {answer.facts.length > 0 && (
        <dl class="facts">
          {answer.facts.map(({ name, figure }) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{figure}</dd>
            </div>
          ))}
        </dl>
      )}
      {answer.ways.length > 0 && <WayPlayer card={card} answer={answer} />}
      {answer.ways.length === 0 && card.line === null && <Blockers card={card} answer={answer} />}
      {answer.reaches.length > 0 && <ReachList answer={answer} />}
    </>
  );
}

function Blockers({ card, answer }: { card: Card; answer: CardAnswer }) {
  const wb = useWorkbench();
  const { store } = wb;
  const [is_whole, setWhole] = useState(false);
  const more = is_whole ? 0 : answer.blockers.length - MOST_BLOCKERS;
  if (answer.blockers.length === 0) return null;
  return (
    <ul class="blockers" aria-label="What stops it">
      {answer.blockers
        .slice(0, is_whole ? answer.blockers.length : MOST_BLOCKERS)
        .map(({ part, attempts, is_proof }) => (
          <li key={part}>
            <button type="button" class="link" title={wb.path(part)} onClick={() => showPart(wb, part)}>
              {store.nameOf(part)}
            </button>
            <span class="note">
              {is_proof ? "holds it: proven" : `stopped ${attempts} ${attempts === 1 ? "attempt" : "attempts"}`}
            </span>
            <span class="button-row">
              <button
                type="button"
                class="button small"
                disabled={store.is_read_only.value || isAway(wb, part)}
                title={isAway(wb, part) ? "It is out already" : undefined}
                onClick={() => ask(wb, "removal", [part])}
              >
                Take it out first
              </button>
              <button
                type="button"
                class="button small"
                disabled={store.is_read_only.value}
                onClick={() => ask(wb, card.question as CardQuestion, card.parts, [...card.without, part])}
              >
                Try without
              </button>
            </span>
          </li>
        ))}
      {more > 0 && (
        <li>
          <button type="button" class="link" onClick={() => setWhole(true)}>
            {`and ${more} more`}
          </button>
        </li>
      )}
    </ul>
  );
}
