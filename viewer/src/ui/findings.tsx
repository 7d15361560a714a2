// The panel of findings: the check, the filter, the list, and the card of the chosen ones.

import { runCommand } from "../actions/commands";
import { exportFindings, FORMATS } from "../actions/findings";
import type { FindingFormat } from "../link/protocol";
import { formatCount } from "../math/units";
import { type FindingOrder, type Grouping, STATUSES, statusOf } from "../model/findings";
import { checkSince } from "../model/stale";
import type { Store } from "../model/store";
import { useWorkbench } from "./context";
import { CommandButton } from "./fields";
import { FindingCard } from "./finding-card";
import { CheckSettings } from "./finding-check";
import { FindingRows } from "./finding-rows";
import { Requirements } from "./requirements";

const ORDERS: Readonly<Record<FindingOrder, string>> = {
  depth: "Worst first",
  part: "By part name",
  status: "By status",
};
const GROUPINGS: Readonly<Record<Grouping, string>> = {
  group: "Groups",
  part: "By part",
  rule: "By rule",
  verdict: "By verdict",
  none: "No groups",
};

export function FindingPanel() {
  const { store } = useWorkbench();
  const { facts, list, failed } = store.findings;
  if (!facts.value) return <NoFindings />;
  return (
    <div class="panel-body findings-body">
      <Head />
      {list.value?.version === facts.value.version ? (
        <>
          <Filter />
          <FindingRows />
          <FindingCard />
        </>
      ) : (
        <p class="note" role="status">
          {failed.value ? `The findings did not come: ${failed.value}` : "Loading the findings"}
        </p>
      )}
    </div>
  );
}

function NoFindings() {
  return (
    <div class="panel-body empty">
      <p>No findings are open.</p>
      <p class="note">A clash check finds the parts that overlap, touch, or are too near each other.</p>
      <CommandButton id="check-clashes" icon="alert" text="Check clashes" />
      <CommandButton id="open-findings" icon="list" text="Open a file" />
      <CheckSettings />
      <Requirements />
    </div>
  );
}

function Head() {
  const { store } = useWorkbench();
  const { facts, is_stale } = store.findings;
  const check = facts.value?.check;
  const gone = facts.value ? (store.document.value?.project?.gone ?? []) : [];
  const earlier = checkSince(facts.value?.stale ?? {}, gone, (part) => store.nameOf(part));
  return (
    <section>
      <div class="select-row">
        <CommandButton id="previous-finding" icon="up" />
        <CommandButton id="next-finding" icon="down" />
        <CommandButton id="check-clashes" icon="alert" text={check ? "Check again" : "Check clashes"} />
      </div>
      <div class="select-row">
        <OpenChoice />
        <ExportChoice />
        <CommandButton id="close-findings" icon="close" />
      </div>
      {earlier && (
        <p class="hint-bar" role="status">
          <strong class="stale">{`Of an earlier revision: ${earlier} since this check.`}</strong>
        </p>
      )}
      {is_stale.value && (
        <p class="hint-bar" role="status">
          Parts lie elsewhere since this check.
        </p>
      )}
      {check?.of && <p class="note">{`Only pairs with ${partsText(store, check.of)} were checked.`}</p>}
      <CheckSettings />
      <Requirements />
    </section>
  );
}

const partsText = (store: Store, parts: readonly number[]): string =>
  parts.length === 1 ? store.nameOf(parts[0] ?? -1) : `${formatCount(parts.length)} parts`;

/** A menu of files to open. */
function OpenChoice() {
  const wb = useWorkbench();
  return (
    <select
      aria-label="Open a file"
      value=""
      disabled={wb.store.is_read_only.value}
      onChange={(event) => {
        const id = event.currentTarget.value;
        event.currentTarget.value = "";
        if (id !== "") runCommand(wb, id);
      }}
    >
      <option value="">Open…</option>
      <option value="open-findings">Findings (JSON)</option>
      <option value="open-bcf">Statuses and comments (BCF)</option>
      <option value="open-rules">Rules (TOML)</option>
    </select>
  );
}

/** A menu of files: choosing one writes it. */
function ExportChoice() {
  const wb = useWorkbench();
  const { store } = wb;
  const has_rules = (store.document.value?.clash.rules ?? "") !== "";
  return (
    <select
      aria-label="Export findings"
      value=""
      disabled={store.is_read_only.value}
      onChange={(event) => {
        const format = event.currentTarget.value;
        event.currentTarget.value = "";
        if (format !== "") void exportFindings(wb, format as FindingFormat);
      }}
    >
      <option value="">Export…</option>
      {Object.entries(FORMATS).map(([format, title]) => (
        <option key={format} value={format} disabled={format === "rules" && !has_rules}>
          {title}
        </option>
      ))}
    </select>
  );
}

function Filter() {
  const wb = useWorkbench();
  const { store } = wb;
  const { findings } = store;
  const [facts, list] = [findings.facts.value, findings.list.value];
  const { query, verdict, status, part, order, grouping } = findings.filter.value;
  if (!facts || !list) return null;
  const count = findings.shown.value.rows.length;
  const hidden = Object.values(facts.hidden).reduce((sum, each) => sum + each, 0);
  return (
    <section>
      <input
        type="search"
        class="text-field"
        placeholder="Filter by words"
        aria-label="Filter findings"
        value={query}
        onInput={(event) => findings.set({ query: event.currentTarget.value })}
      />
      <div class="select-row">
        <select
          aria-label="Verdict"
          value={verdict}
          onChange={(event) => findings.set({ verdict: event.currentTarget.value })}
        >
          <option value="">All verdicts</option>
          {list.verdicts.map((each) => (
            <option key={each} value={each}>
              {`${each} (${formatCount(facts.counts[each] ?? 0)})`}
            </option>
          ))}
        </select>
        <StatusFilter status={status} />
      </div>
      <div class="select-row">
        <select
          aria-label="Order of findings"
          value={order}
          onChange={(event) => findings.set({ order: event.currentTarget.value as FindingOrder })}
        >
          {Object.entries(ORDERS).map(([value, text]) => (
            <option key={value} value={value}>
              {text}
            </option>
          ))}
        </select>
        <select
          aria-label="Groups of findings"
          value={grouping}
          onChange={(event) => findings.set({ grouping: event.currentTarget.value as Grouping })}
        >
          {Object.entries(GROUPINGS).map(([value, text]) => (
            <option key={value} value={value}>
              {text}
            </option>
          ))}
        </select>
      </div>
      {part >= 0 && (
        <div class="hint-bar">
          <span>{`Only with ${store.nameOf(part)}`}</span>
          <button type="button" class="button" onClick={() => findings.set({ part: -1 })}>
            All
          </button>
        </div>
      )}
      <div class="finding-line">
        <p class="note" role="status">
          {`${formatCount(count)} of ${formatCount(facts.count)}${hidden > 0 ? `; rules hide ${formatCount(hidden)}` : ""}`}
        </p>
        <label class="check">
          <input
            type="checkbox"
            checked={facts.is_touching_hidden}
            disabled={!store.can_look.value}
            onChange={(event) => wb.run("finding_filter", { is_touching_hidden: event.currentTarget.checked })}
          />
          Hide contacts
        </label>
      </div>
    </section>
  );
}

/** With the number of findings of each status. */
function StatusFilter({ status }: { status: string }) {
  const { findings } = useWorkbench().store;
  const [facts, list] = [findings.facts.value, findings.list.value];
  if (!facts || !list) return null;
  const counts = new Map<string, number>();
  for (let row = 0; row < list.count; row++) {
    const each = statusOf(list, facts, row);
    counts.set(each, (counts.get(each) ?? 0) + 1);
  }
  return (
    <select
      aria-label="Status"
      value={status}
      onChange={(event) => findings.set({ status: event.currentTarget.value })}
    >
      <option value="">All statuses</option>
      {STATUSES.map((each) => (
        <option key={each} value={each}>
          {`${each} (${formatCount(counts.get(each) ?? 0)})`}
        </option>
      ))}
    </select>
  );
}
