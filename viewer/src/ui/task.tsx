// The panel of tasks: asks how parts are taken out, and lists the plans.

import { dropTimes, openTimes } from "../actions/tasks";
import { CardItem } from "./cards";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { partsText } from "./words";

const MOST_PEOPLE = 8;
/** Of a table of times. */
const ELEMENTS = 9;

/** The table of times of all plans. */
function TimesTable() {
  const wb = useWorkbench();
  const times = wb.store.document.value?.task_times;
  if (!times) return null;
  const isLocked = wb.store.is_read_only.value;
  const hasTable = times.name !== "";
  return (
    <div class="task-times">
      <span class="task-times-name">
        {hasTable ? `Times of ${times.name}` : "Times are examples, not measured"}
        {hasTable && <span class="note">{`${times.given} of ${ELEMENTS} elements; others are examples`}</span>}
      </span>
      <button
        type="button"
        class="button"
        disabled={isLocked}
        title="A table as feeler task --write-times writes it (TOML)"
        onClick={() => openTimes(wb)}
      >
        Open times
      </button>
      {hasTable && (
        <IconButton icon="close" label="Use the example times" disabled={isLocked} run={() => dropTimes(wb)} />
      )}
    </div>
  );
}

export function TaskPanel() {
  const { store } = useWorkbench();
  const cards = (store.document.value?.cards ?? []).filter((card) => card.question === "task");
  const selection = store.selection.value;
  const only = selection.size === 1 ? [...selection][0] : undefined;
  const what = only !== undefined ? store.nameOf(only) : partsText(selection.size, String);
  return (
    <div class="panel-body">
      <section>
        <h2>Task</h2>
        <p class="note">
          {selection.size > 0
            ? `Take out ${what}:`
            : "Select what is taken out, then ask: which fasteners and parts go before, with which tools, and how long it takes."}
        </p>
        <div class="task-asked">
          <label>
            <span>Tools</span>
            <select
              value={store.task_tools.value}
              onChange={(event) => {
                store.task_tools.value = event.currentTarget.value as typeof store.task_tools.value;
              }}
            >
              <option value="catalogue">of the catalogue</option>
              <option value="own">of the workbench</option>
              <option value="none">reach not checked</option>
            </select>
          </label>
          <label>
            <span>People</span>
            <select
              value={String(store.people_count.value)}
              onChange={(event) => {
                store.people_count.value = Number(event.currentTarget.value);
              }}
            >
              {Array.from({ length: MOST_PEOPLE }, (_, k) => (
                <option key={k} value={String(k + 1)}>
                  {k + 1}
                </option>
              ))}
            </select>
          </label>
        </div>
        <TimesTable />
        <div class="button-column">
          <CommandButton id="ask-task" icon="spanner" text="How is it taken out?" />
        </div>
      </section>
      <section>
        <h2>Plans</h2>
        {cards.length === 0 && <p class="note">A plan stays here until you remove it.</p>}
        <ul class="card-list" aria-label="Plans">
          {[...cards].reverse().map((card) => (
            <CardItem key={card.id} card={card} />
          ))}
        </ul>
      </section>
    </div>
  );
}
