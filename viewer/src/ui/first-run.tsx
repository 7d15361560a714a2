// The first start: the sample gearbox, and the three questions that one comes with, each answered on it.

import { commandOf, hasCommand, runCommand } from "../actions/commands";
import type { Workbench } from "../actions/workbench";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";
import { Icon } from "./icons";

interface Question {
  readonly text: string;
  /** The command that answers it: the first of these that is there. */
  readonly ask: readonly string[];
  /** The parts that it is about; empty: all. */
  readonly parts: readonly string[];
  /** What is around them, which the picture shows as well. */
  readonly around?: readonly string[];
  /** How to find out by hand. */
  readonly how: string;
}

const QUESTIONS: readonly Question[] = [
  {
    text: "What clashes?",
    ask: ["ask-clash", "check-clashes"],
    parts: [],
    how: "A clash check classifies every pair of parts. Open one with Ctrl+K, “findings”, and step through it with N.",
  },
  {
    text: "Does the starter come out?",
    ask: ["ask-removal"],
    parts: ["body", "drive_shaft", "o_ring", "terminal_stud", "terminal_nut", "terminal_washer"].map(
      (name) => `gearbox/starter/${name}`,
    ),
    how: "It is selected. Press E to grip it, then drag an arrow: contact stops it where something is in the way.",
  },
  {
    text: "Which tool undoes this bolt?",
    ask: ["ask-tools"],
    parts: ["gearbox/covers/main_rear/bolt_1"],
    around: ["gearbox/covers/main_rear/cover"],
    how: "The bolt is selected. Bring the wrench to it: drag it, or press G, an axis, a length and Enter.",
  },
];

/** The card stands on the gearbox until it is closed; the palette opens it again. */
export function FirstRun() {
  const wb = useWorkbench();
  const { store } = wb;
  const { has_first_run, first_run_step } = store.settings.value;
  const isThere = store.paths.value.includes("gearbox/starter/body");
  // The bar of a record has the same place, and comes first.
  const isFirst = store.tour_step.value === null && store.document.value?.record == null;
  if (!has_first_run || !isThere || store.connection.value !== "open" || !isFirst) return null;
  return (
    <section class="first-run" aria-label="Three questions to begin with">
      <header>
        <h2>Three questions to begin with</h2>
        <IconButton icon="close" label="Close the questions" run={() => store.set({ has_first_run: false })} />
      </header>
      <ol>
        {QUESTIONS.map((question, k) => (
          <li key={question.text}>
            <button
              type="button"
              class="part-line"
              aria-expanded={first_run_step === k}
              onClick={() => {
                store.set({ first_run_step: first_run_step === k ? -1 : k });
                if (first_run_step !== k) show(wb, question);
              }}
            >
              <span class="step-number" aria-hidden="true">
                {k + 1}
              </span>
              <span class="row-name">{question.text}</span>
              <Icon name="chevron" size={14} />
            </button>
            {first_run_step === k && <Answer question={question} />}
          </li>
        ))}
      </ol>
      <p class="note">
        {store.opens.value ? "Then your own: drop a file here, or " : "Start with your own: feeler view FILE."}
        {store.opens.value && (
          <button type="button" class="link" onClick={() => runCommand(wb, "open-file")}>
            open a file
          </button>
        )}
      </p>
    </section>
  );
}

function Answer({ question }: { question: Question }) {
  const wb = useWorkbench();
  const id = question.ask.find(hasCommand);
  const command = id === undefined ? null : commandOf(id);
  if (!command) return <p class="note step-text">{question.how}</p>;
  return (
    <div class="step-text">
      <button
        type="button"
        class="button main"
        disabled={command.when ? !command.when(wb) : false}
        onClick={() => runCommand(wb, command.id)}
      >
        <Icon name="play" size={14} />
        <span>Find out</span>
      </button>
    </div>
  );
}

/** Selects the parts of a question and looks at them. */
function show(wb: Workbench, { parts, around = [] }: Question): void {
  const paths = wb.store.paths.peek();
  const numbers = (given: readonly string[]): number[] =>
    given.map((path) => paths.indexOf(path)).filter((part) => part >= 0);
  wb.select(numbers(parts));
  if (parts.length > 0) wb.fit(wb.visible(numbers([...parts, ...around])));
}
