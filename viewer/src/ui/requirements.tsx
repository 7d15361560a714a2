// Clearances that must hold: each with its patterns, its least distance, and what was found last.

import { leftTexts } from "../actions/project";
import {
  addRequirement,
  checkRequirements,
  exportRequirements,
  isStale,
  lookAtRequirement,
} from "../actions/requirements";
import type { KeptClear, LeftPattern } from "../link/protocol";
import { DISTANCES_M, formatLength } from "../math/units";
import { sinceText } from "../model/stale";
import { useWorkbench } from "./context";
import { Figure, IconButton, NameField } from "./fields";
import { counted } from "./words";

export function Requirements() {
  const wb = useWorkbench();
  const { store } = wb;
  const { are_requirements_open } = store.findings;
  const requirements = store.document.value?.requirements ?? [];
  const is_locked = store.is_read_only.value;
  const stale = requirements.filter(({ verdict }) => verdict && Object.keys(verdict.stale).length > 0).length;
  const wrong = requirements.filter(
    ({ verdict }) => verdict?.status === "violated" && Object.keys(verdict.stale).length === 0,
  ).length;
  const words = [wrong > 0 ? `${wrong} violated` : "", stale > 0 ? `${stale} of an earlier revision` : ""];
  const told = words.filter(Boolean).join(", ");
  const counts = told ? ` (${told})` : requirements.length > 0 ? ` (${requirements.length})` : "";
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
        range={DISTANCES_M}
        disabled={is_locked}
        change={(gap) => wb.run("requirement_edit", { id, gap })}
      />
      <Left of="requirement" patterns={[a, b]} />
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

/** Which parts have left patterns by another name: nothing else tells that they are checked no more. */
export function Left({ of, patterns }: { of: LeftPattern["of"]; patterns: readonly string[] }) {
  return (
    <>
      {leftTexts(useWorkbench(), of, patterns).map((text) => (
        <p key={text} class="note">
          <strong class="stale">{text}</strong>
        </p>
      ))}
    </>
  );
}

const PAST = { holds: "held", violated: "was violated", unknown: "was not known" } as const;

/** "holds", "violated: 3 mm, and 4 pairs more", "held; parts were moved since". */
function Said({ requirement }: { requirement: KeptClear }) {
  const wb = useWorkbench();
  const { verdict } = requirement;
  if (!verdict) return <span class="note">not checked</span>;
  const earlier = sinceText(verdict.stale, (part) => wb.store.nameOf(part));
  if (earlier)
    return <strong class="stale">{`${PAST[verdict.status]} in an earlier revision: ${earlier} since`}</strong>;
  if (isStale(wb, requirement)) return <span class="note">{`${PAST[verdict.status]}; parts were moved since`}</span>;
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
