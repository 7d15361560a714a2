// The project in the status line: whether all is saved, and what a newer revision made stale.

import { isStale, project, saveProject, savingText, selectStale, staleText } from "../actions/project";
import { useWorkbench } from "./context";

/** Names of missing parts that a tooltip lists. */
const MOST_NAMES = 12;

const ASIDE =
  "Removals, measures and answers whose parts are not in this revision: they come back with a revision that has these parts.";

export function ProjectStatus() {
  const wb = useWorkbench();
  const facts = project(wb);
  if (!facts || wb.store.connection.value === "offline") return null;
  const text = savingText(facts);
  const title = facts.trouble ? `${facts.name}: ${facts.trouble}` : facts.name;
  return (
    <span class="project-state">
      <button
        type="button"
        class={`link ${facts.state.replace(" ", "-")}`}
        title={title}
        onClick={() => saveProject(wb)}
      >
        {facts.trouble ? `${text}: ${facts.trouble}` : text}
      </button>
      {isStale(facts) && (
        <button type="button" class="link stale" title={staleTitle(facts.gone)} onClick={() => selectStale(wb)}>
          {`Parts: ${staleText(facts)}`}
        </button>
      )}
      {facts.aside > 0 && (
        <button type="button" class="link" title={ASIDE} onClick={() => wb.store.notify("info", ASIDE)}>
          {`${facts.aside} set aside`}
        </button>
      )}
    </span>
  );
}

function staleTitle(gone: readonly string[]): string {
  const what = "These parts differ from those that the saved answers are about. Click: select them.";
  if (gone.length === 0) return what;
  const names = gone.slice(0, MOST_NAMES).join(", ");
  return `${what} Gone: ${names}${gone.length > MOST_NAMES ? ` and ${gone.length - MOST_NAMES} more` : ""}`;
}
