// The card of the chosen findings: what is said of one, status, note and group, and "ignore like this".

import { useEffect, useRef, useState } from "preact/hooks";
import {
  beginIgnoring,
  changeIgnoring,
  confirmIgnoring,
  leaveFinding,
  lookAtFinding,
  makeGroup,
  mark,
  selectParts,
} from "../actions/findings";
import type { FindingStatus } from "../link/protocol";
import { formatCount } from "../math/units";
import { factsText, noteOf, STATUSES, sentence, statusOf, withOthers } from "../model/findings";
import { findingRevision } from "../model/stale";
import { useWorkbench } from "./context";

export function FindingCard() {
  const wb = useWorkbench();
  const { store } = wb;
  const { findings } = store;
  const [list, facts] = [findings.list.value, findings.facts.value];
  const chosen = findings.chosen.value;
  if (!list || !facts || chosen.size === 0) return null;
  const is_locked = store.is_read_only.value;
  const [first = -1] = chosen;
  const row = chosen.size === 1 ? first : -1;
  const finding = row >= 0 ? list.finding(row) : null;
  const gone = store.document.value?.project?.gone ?? [];
  const earlier = finding ? findingRevision(finding, facts.stale, gone, (part) => store.nameOf(part)) : "";
  const is_seen = finding !== null && findings.focus.value?.finding.id === finding.id;
  const is_ignoring = finding !== null && findings.ignoring.value !== null;
  const statuses = new Set([...chosen].map((each) => statusOf(list, facts, each)));
  const members = new Set([...chosen].map((each) => facts.members[list.ids[each] ?? ""] ?? 0));
  return (
    <section class="card finding-card" aria-label="Chosen finding">
      {finding ? (
        <>
          <p class="finding-said">{`${sentence(finding, store.unit.value)}.`}</p>
          <p class="note">{factsText(finding)}</p>
          {earlier && (
            <p class="note">
              <strong class="stale">{earlier}</strong>
            </p>
          )}
          <p class="note path">
            <span class="swatch a" aria-hidden="true" /> <bdi>{finding.path_a}</bdi>
          </p>
          <p class="note path">
            <span class="swatch b" aria-hidden="true" /> <bdi>{finding.path_b}</bdi>
          </p>
        </>
      ) : (
        <p class="finding-said">{`${formatCount(chosen.size)} findings`}</p>
      )}
      {is_ignoring ? <IgnoreForm /> : null}
      <div class="select-row" hidden={is_ignoring}>
        <select
          aria-label="Status of the finding"
          value={statuses.size === 1 ? [...statuses][0] : ""}
          disabled={is_locked}
          onChange={(event) => mark(wb, { status: event.currentTarget.value as FindingStatus })}
        >
          {statuses.size !== 1 && <option value="">several</option>}
          {STATUSES.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
        <GroupChoice member={members.size === 1 ? ([...members][0] ?? 0) : -1} />
      </div>
      {row >= 0 && !is_ignoring && <Note key={`${list.version} ${row}`} row={row} value={noteOf(list, facts, row)} />}
      {finding && !is_ignoring && (
        <div class="button-row">
          <button
            type="button"
            class="button"
            aria-pressed={is_seen}
            onClick={() => (is_seen ? leaveFinding(wb) : lookAtFinding(wb, finding.row))}
          >
            {is_seen ? "Leave (Esc)" : "Look"}
          </button>
          <button type="button" class="button" onClick={() => selectParts(wb, finding)}>
            Select both
          </button>
          <button type="button" class="button" disabled={is_locked} onClick={() => beginIgnoring(wb, finding)}>
            Ignore like this…
          </button>
        </div>
      )}
    </section>
  );
}

/** The groups made by hand, and a new one. */
function GroupChoice({ member }: { member: number }) {
  const wb = useWorkbench();
  const { store } = wb;
  const groups = store.findings.facts.value?.own_groups ?? [];
  return (
    <select
      aria-label="Group of the finding"
      value={`${member}`}
      disabled={store.is_read_only.value}
      onChange={(event) => {
        const { value } = event.currentTarget;
        if (value === "new") void makeGroup(wb, `Group ${groups.length + 1}`);
        else void mark(wb, { group: Number(value) });
      }}
    >
      {member < 0 && <option value="-1">several</option>}
      <option value="0">no group of ours</option>
      {groups.map(({ id, name }) => (
        <option key={id} value={`${id}`}>
          {name}
        </option>
      ))}
      <option value="new">New group…</option>
    </select>
  );
}

function Note({ row, value }: { row: number; value: string }) {
  const wb = useWorkbench();
  const [draft, setDraft] = useState<{ text: string; before: string } | null>(null);
  const settle = (): void => {
    setDraft(null);
    const next = draft && withOthers(draft.text.trim(), draft.before, value);
    if (next !== null && next !== value) void mark(wb, { note: next }, [row]);
  };
  return (
    <textarea
      class="text-field"
      rows={2}
      placeholder="Note"
      aria-label="Note of the finding"
      value={draft?.text ?? value}
      disabled={wb.store.is_read_only.value}
      onInput={(event) => setDraft({ text: event.currentTarget.value, before: draft?.before ?? value })}
      onBlur={settle}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key === "Escape") {
          setDraft(null);
          event.currentTarget.blur();
        } else if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) event.currentTarget.blur();
      }}
    />
  );
}

function IgnoreForm() {
  const wb = useWorkbench();
  const { ignoring } = wb.store.findings;
  const form = useRef<HTMLFormElement>(null);
  useEffect(() => form.current?.scrollIntoView({ block: "nearest" }), []);
  const given = ignoring.value;
  if (!given) return null;
  const field = (name: "name" | "a" | "b", label: string) => (
    <label class="ignore-field">
      <span class="note">{label}</span>
      <input
        class="text-field"
        type="text"
        spellcheck={false}
        autocomplete="off"
        value={given[name]}
        onInput={(event) => void changeIgnoring(wb, { [name]: event.currentTarget.value })}
      />
    </label>
  );
  const { count, trouble } = given;
  return (
    <form
      ref={form}
      class="ignore-form"
      aria-label="Ignore like this"
      onSubmit={(event) => {
        event.preventDefault();
        void confirmIgnoring(wb);
      }}
    >
      {field("name", "Name of the rule")}
      {field("a", "Parts")}
      {field("b", "against parts")}
      <p class="note" role="status">
        {trouble ??
          (count === null ? "Counting" : `Hides ${formatCount(count)} ${count === 1 ? "finding" : "findings"}`)}
      </p>
      <div class="button-row">
        <button type="submit" class="button" disabled={trouble !== null || count === null || given.name.trim() === ""}>
          Hide and keep as a rule
        </button>
        <button
          type="button"
          class="button"
          onClick={() => {
            ignoring.value = null;
          }}
        >
          Cancel
        </button>
      </div>
    </form>
  );
}
