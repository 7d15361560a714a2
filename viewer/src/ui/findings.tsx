// Findings of a clash check: groups, the deepest first; N and P step through them.

import { useSignal } from "@preact/signals";
import { lookAtFinding } from "../actions/findings";
import type { Finding, FindingGroup, FindingStatus } from "../link/protocol";
import { formatLength, type Unit } from "../math/units";
import { STATUSES, shownGroups } from "../model/findings";
import { useWorkbench } from "./context";
import { Choice, CommandButton } from "./fields";
import { counted } from "./words";

/** So many findings of a group are in the page at once; more by a button. */
const FIRST = 20;

export function FindingPanel() {
  const wb = useWorkbench();
  const { store } = wb;
  const { finding_query: query, finding_order: order } = store;
  const findings = store.document.value?.findings;
  if (!findings) {
    return (
      <div class="panel-body empty">
        <p>No findings are open.</p>
        <p class="note">
          A clash check writes them (feeler clash MOCKUP --json); the workbench then steps through them.
        </p>
        <CommandButton id="open-findings" icon="list" text="Open a file" />
      </div>
    );
  }
  const groups = shownGroups(findings, query.value, order.value);
  const count = groups.reduce((sum, group) => sum + group.findings.length, 0);
  return (
    <div class="panel-body">
      <section>
        <div class="button-row">
          <CommandButton id="previous-finding" icon="up" text="Previous" />
          <CommandButton id="next-finding" icon="down" text="Next" />
          <CommandButton id="open-findings" icon="list" text="Open" />
        </div>
        <input
          type="search"
          class="text-field"
          placeholder="Filter by words or status"
          aria-label="Filter findings"
          value={query.value}
          onInput={(event) => {
            query.value = event.currentTarget.value;
          }}
        />
        <Choice
          label="Order of findings"
          value={order.value}
          options={[
            { value: "depth", text: "Deepest first" },
            { value: "group", text: "By group" },
          ]}
          choose={(value) => {
            order.value = value;
          }}
        />
        <label class="check">
          <input
            type="checkbox"
            checked={findings.is_touching_hidden}
            disabled={!store.can_look.value}
            onChange={(event) => wb.run("finding_filter", { is_touching_hidden: event.currentTarget.checked })}
          />
          Hide contacts
        </label>
        <p class="note" role="status">{`${counted(count, "finding")} in ${counted(groups.length, "group")}`}</p>
      </section>
      {groups.map((group) => (
        <Group key={group.name} group={group} />
      ))}
    </div>
  );
}

function Group({ group }: { group: FindingGroup }) {
  const shown = useSignal(FIRST);
  return (
    <details class="group" open>
      <summary>
        <span class="row-name">{group.name}</span>
        <span class="row-count">{group.findings.length}</span>
      </summary>
      <ul class="card-list">
        {group.findings.slice(0, shown.value).map((finding) => (
          <FindingCard key={finding.id} finding={finding} />
        ))}
      </ul>
      {group.findings.length > shown.value && (
        <button
          type="button"
          class="button"
          onClick={() => {
            shown.value += 5 * FIRST;
          }}
        >
          {`${group.findings.length - shown.value} more`}
        </button>
      )}
    </details>
  );
}

function FindingCard({ finding }: { finding: Finding }) {
  const wb = useWorkbench();
  const { store } = wb;
  const status = store.document.value?.findings?.status[finding.id] ?? "new";
  const isCurrent = store.finding.value === finding.id;
  return (
    <li class={`card finding ${isCurrent ? "playing" : ""} status-${status}`} aria-current={isCurrent}>
      <button type="button" class="finding-text" onClick={() => lookAtFinding(wb, finding)}>
        {finding.sentence}
      </button>
      <div class="finding-line">
        <span class="note">{factsOf(finding, store.unit.value)}</span>
        <select
          aria-label={`Status of ${finding.sentence}`}
          value={status}
          disabled={store.is_read_only.value}
          onChange={(event) =>
            wb.run("finding_status", { id: finding.id, status: event.currentTarget.value as FindingStatus })
          }
        >
          {STATUSES.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
      </div>
    </li>
  );
}

function factsOf(finding: Finding, unit: Unit): string {
  if (finding.depth) return `${finding.verdict} · ${formatLength(finding.depth, unit)} deep`;
  return finding.gap ? `${finding.verdict} · ${formatLength(finding.gap, unit)} apart` : finding.verdict;
}
