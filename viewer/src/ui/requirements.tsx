// Clearances that must hold: each with its patterns, its least distance, and what was found last.

import {
  addRequirement,
  checkRequirements,
  exportRequirements,
  isStale,
  lookAtRequirement,
} from "../actions/requirements";
import type { KeptClear } from "../link/protocol";
import { formatLength } from "../math/units";
import { useWorkbench } from "./context";
import { Figure, IconButton, NameField } from "./fields";
import { counted } from "./words";

export function Requirements() {
  const wb = useWorkbench();
  const { store } = wb;
  const { are_requirements_open } = store.findings;
  const requirements = store.document.value?.requirements ?? [];
  const is_locked = store.is_read_only.value;
  const wrong = requirements.filter(({ verdict }) => verdict?.status === "violated").length;
  const counts = wrong > 0 ? ` (${wrong} violated)` : requirements.length > 0 ? ` (${requirements.length})` : "";
  return (
    <details
      class="check-settings"
      open={are_requirements_open.value}
      onToggle={(event) => {
        are_requirements_open.value = event.currentTarget.open;
      }}
    >
      <summary>{`Clearances that must hold${counts}`}</summary>
      <div class="select-row">
        <button type="button" class="button" disabled={is_locked} onClick={() => addRequirement(wb)}>
          Add
        </button>
        <button
          type="button"
          class="button"
          disabled={is_locked || requirements.length === 0}
          onClick={() => checkRequirements(wb)}
        >
          Check
        </button>
        <button
          type="button"
          class="button"
          disabled={is_locked || requirements.length === 0}
          onClick={() => exportRequirements(wb)}
        >
          Export
        </button>
      </div>
      <ul class="card-list" aria-label="Clearances that must hold">
        {requirements.map((each) => (
          <RequirementCard key={each.id} requirement={each} />
        ))}
      </ul>
    </details>
  );
}

function RequirementCard({ requirement }: { requirement: KeptClear }) {
  const wb = useWorkbench();
  const { store } = wb;
  const { id, name, a, b, gap, verdict } = requirement;
  const is_locked = store.is_read_only.value;
  const field = (side: "a" | "b", value: string) => (
    <NameField
      label={`${side === "a" ? "Parts" : "Away from"}: ${name}`}
      value={value}
      disabled={is_locked}
      change={(next) => wb.run("requirement_edit", { id, [side]: next })}
    />
  );
  return (
    <li class="card requirement">
      <header>
        <NameField
          label="Name of the requirement"
          value={name}
          disabled={is_locked}
          change={(next) => wb.run("requirement_edit", { id, name: next })}
        />
        <IconButton
          icon="close"
          label={`Remove ${name}`}
          disabled={is_locked}
          run={() => wb.run("requirement_remove", { id })}
        />
      </header>
      {field("a", a)}
      {field("b", b)}
      <Figure
        label="Least distance"
        kind="length"
        unit={store.unit.value}
        value={gap}
        step={1e-3}
        disabled={is_locked}
        change={(next) => wb.run("requirement_edit", { id, gap: Math.max(0, next) })}
      />
      <div class="finding-line">
        <Said requirement={requirement} />
        {verdict?.status === "violated" && (
          <button type="button" class="button" onClick={() => lookAtRequirement(wb, requirement)}>
            Look
          </button>
        )}
      </div>
    </li>
  );
}

/** "holds", "violated: 3 mm, and 4 pairs more", "moved since: check again". */
function Said({ requirement }: { requirement: KeptClear }) {
  const wb = useWorkbench();
  const { verdict } = requirement;
  if (!verdict) return <span class="note">not checked</span>;
  if (isStale(wb, requirement)) return <span class="note">{`was ${verdict.status}; parts moved since`}</span>;
  if (verdict.status === "unknown") return <span class="note">{verdict.trouble ?? "not known"}</span>;
  if (verdict.status === "holds") return <span class="tag">holds</span>;
  const unit = wb.store.unit.value;
  const how = verdict.depth
    ? `${formatLength(verdict.depth, unit)} deep`
    : verdict.gap
      ? formatLength(verdict.gap, unit)
      : "touches";
  const more = verdict.pairs > 1 ? `, and ${counted(verdict.pairs - 1, "pair")} more` : "";
  return <span class="tag violated">{`violated: ${how}${more}`}</span>;
}
