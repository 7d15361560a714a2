// The panel of tasks: asks how parts are taken out, and lists the plans.

import { dropTaskFile, openTaskFile } from "../actions/tasks";
import type { TaskFile } from "../model/store";
import { CardItem } from "./cards";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { partsText } from "./words";

const MOST_PEOPLE = 8;
/** Of a table of times. */
const ELEMENTS = 9;

/** A file that all plans use: its name, what is in it, and a way back. */
function FileRow(props: { kind: TaskFile; said: string; more: string; open: string; title: string; drop: string }) {
  const { kind, said, more, open, title, drop } = props;
  const wb = useWorkbench();
  const isLocked = wb.store.is_read_only.value;
  const trouble = wb.store.task_troubles[kind].value;
  return (
    <div class="task-file">
      <span class="task-file-name">
        {said}
        {more && <span class="note">{more}</span>}
      </span>
      <button type="button" class="button" disabled={isLocked} title={title} onClick={() => openTaskFile(wb, kind)}>
        {open}
      </button>
      {more && <IconButton icon="close" label={drop} disabled={isLocked} run={() => dropTaskFile(wb, kind)} />}
      {trouble && (
        <p class="task-file-trouble" role="alert">
          {trouble}
        </p>
      )}
    </div>
  );
}

/** The catalogue of tools and the table of times of all plans. */
function Files() {
  const document = useWorkbench().store.document.value;
  if (!document) return null;
  const { task_catalogue: tools, task_times: times } = document;
  return (
    <>
      <FileRow
        kind="task_catalogue"
        said={tools.name ? `Tools of ${tools.name}` : "Tools of the built-in catalogue"}
        more={tools.name && `${tools.tools} ${tools.tools === 1 ? "tool" : "tools"}`}
        open="Open catalogue"
        title="A catalogue as feeler access --write-catalogue writes it (TOML)"
        drop="Use the built-in catalogue"
      />
      <FileRow
        kind="task_times"
        said={times.name ? `Times of ${times.name}` : "Times are examples, not measured"}
        more={times.name && `${times.given} of ${ELEMENTS} elements; others are examples`}
        open="Open times"
        title="A table as feeler task --write-times writes it (TOML)"
        drop="Use the example times"
      />
    </>
  );
}

export function TaskPanel() {
  const { store } = useWorkbench();
  const cards = (store.document.value?.cards ?? []).filter((card) => card.question === "task");
  const selection = store.selection.value;
  const only = selection.size === 1 ? [...selection][0] : undefined;
  const group = store.tree.value.groupOf(selection)?.name;
  const what = only !== undefined ? store.nameOf(only) : (group ?? partsText(selection.size, String));
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
        <Files />
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
