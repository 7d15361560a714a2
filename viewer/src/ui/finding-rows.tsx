// The list of findings: a hundred thousand of them, at most eighty rows in the page. Groups fold.

import { useSignalEffect } from "@preact/signals";
import { lookAtFinding } from "../actions/findings";
import { formatCount } from "../math/units";
import { factsText, lineOf, nameA, nameB, relation, sentence, statusOf } from "../model/findings";
import { findingRevision } from "../model/stale";
import { useWorkbench } from "./context";
import { NameField } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";
import { useVirtualList } from "./virtual-list";

const ROW_PX = 42;

export function FindingRows() {
  const wb = useWorkbench();
  const { findings } = wb.store;
  const { lines } = findings.shown.value;
  const rows = useVirtualList(lines.length, ROW_PX);
  const { show } = rows;

  // The current one comes into sight.
  useSignalEffect(() => {
    const row = findings.row.value;
    const line = row < 0 ? -1 : lineOf(findings.shown.value, row);
    if (line >= 0) show(line);
  });

  const groupAt = (line: number) => findings.shown.peek().groups[-1 - (findings.shown.peek().lines[line] ?? 0)];

  const choose = (line: number, event: MouseEvent | KeyboardEvent): void => {
    const row = lines[line] ?? -1;
    const group = groupAt(line);
    if (event.target instanceof HTMLInputElement) return; // the name of a group is written
    show(line);
    if (group) findings.fold(group.key);
    else if (event.shiftKey || event.ctrlKey || event.metaKey) alsoChoose(line, event.shiftKey);
    else void lookAtFinding(wb, row);
  };

  /** Ctrl adds one or takes it out, Shift adds all up to it. */
  const alsoChoose = (line: number, is_range: boolean): void => {
    const chosen = new Set(findings.chosen.peek());
    const row = lines[line] ?? -1;
    const from = is_range ? lineOf(findings.shown.peek(), findings.row.peek()) : -1;
    if (from >= 0) {
      for (const each of lines.subarray(Math.min(from, line), Math.max(from, line) + 1))
        if (each >= 0) chosen.add(each);
    } else if (!chosen.delete(row)) chosen.add(row);
    findings.chosen.value = chosen;
  };

  const onKey = (event: KeyboardEvent): void => {
    if (event.altKey || event.ctrlKey || event.metaKey || event.target instanceof HTMLInputElement) return;
    const at = rows.active.peek();
    const group = groupAt(at);
    const is_folded = group !== undefined && findings.folded.peek().has(group.key);
    const to = rows.target(event.key);
    if (to !== null) show(to);
    else if (event.key === "ArrowRight" && group && is_folded) findings.fold(group.key);
    else if (event.key === "ArrowLeft" && group && !is_folded) findings.fold(group.key);
    else if (event.key === "Enter" || event.key === " ") choose(at, event);
    else return;
    event.preventDefault();
    event.stopPropagation();
    rows.focus();
  };

  return (
    <div
      ref={rows.list}
      class="finding-list"
      role="tree"
      aria-label="Findings"
      aria-multiselectable="true"
      onScroll={rows.onScroll}
      onKeyDown={onKey}
    >
      <div class="finding-space" role="none" style={{ height: `${lines.length * ROW_PX}px` }}>
        {rows.shown.map((line) => {
          const at = lines[line] ?? -1;
          const props = { line, isActive: line === rows.current, choose: (event: MouseEvent) => choose(line, event) };
          return at < 0 ? (
            <GroupLine key={`g${at}`} index={-1 - at} {...props} />
          ) : (
            <FindingLine key={at} row={at} {...props} />
          );
        })}
      </div>
    </div>
  );
}

interface LineProps {
  line: number;
  isActive: boolean;
  choose: (event: MouseEvent) => void;
}

const placeOf = (line: number) => ({ transform: `translateY(${line * ROW_PX}px)`, height: `${ROW_PX}px` });

function GroupLine({ index, line, isActive, choose }: LineProps & { index: number }) {
  const wb = useWorkbench();
  const { findings } = wb.store;
  const group = findings.shown.value.groups[index];
  if (!group) return null;
  const is_open = !findings.folded.value.has(group.key);
  const { own } = group;
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the list takes the keys of all its rows
    <div
      role="treeitem"
      class="finding-group"
      tabIndex={isActive ? 0 : -1}
      aria-level={1}
      aria-selected={false}
      aria-expanded={is_open}
      aria-label={`${group.name} ${formatCount(group.count)}`}
      title={group.name}
      style={placeOf(line)}
      onClick={choose}
    >
      <span class={`twist ${is_open ? "open" : ""}`} aria-hidden="true">
        <Icon name="chevron" size={12} />
      </span>
      {own > 0 ? (
        <span class="row-name">
          <NameField
            label="Name of the group"
            value={group.name}
            disabled={wb.store.is_read_only.value}
            change={(name) => wb.run("finding_group_rename", { id: own, name })}
          />
        </span>
      ) : (
        <span class="row-name">
          <Name text={group.name} />
        </span>
      )}
      {own > 0 && (
        <button
          type="button"
          class="button square quiet"
          title="Dissolve the group"
          aria-label={`Dissolve ${group.name}`}
          tabIndex={-1}
          disabled={wb.store.is_read_only.value}
          onClick={(event) => {
            event.stopPropagation();
            void wb.run("finding_group_remove", { id: own });
          }}
        >
          <Icon name="close" size={14} />
        </button>
      )}
      <span class="row-count"> {formatCount(group.count)}</span>
    </div>
  );
}

function FindingLine({ row, line, isActive, choose }: LineProps & { row: number }) {
  const { store } = useWorkbench();
  const { findings } = store;
  const [list, facts] = [findings.list.value, findings.facts.value];
  if (!list || !facts) return null;
  const finding = list.finding(row);
  const unit = store.unit.value;
  const status = statusOf(list, facts, row);
  const is_current = findings.row.value === row;
  const whole = sentence(finding, unit);
  const gone = store.document.value?.project?.gone ?? [];
  const earlier = findingRevision(finding, facts.stale, gone, (part) => store.nameOf(part));
  // Begins with the visible text of the row, so that speech input can name it.
  const seen = [whole, factsText(finding), status === "new" ? "" : status, earlier && "earlier revision"];
  const label = [seen.filter(Boolean).join(" "), status === "new" ? status : "", earlier].filter(Boolean).join(", ");
  const classes = ["finding", `status-${status}`, is_current ? "current" : "", `severity-${finding.severity}`];
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the list takes the keys of all its rows
    <div
      role="treeitem"
      class={classes.join(" ")}
      tabIndex={isActive ? 0 : -1}
      aria-level={2}
      aria-selected={findings.chosen.value.has(row)}
      aria-current={is_current}
      aria-label={label}
      title={`${finding.path_a}\n${finding.path_b}${earlier && `\n${earlier}`}`}
      style={placeOf(line)}
      onClick={choose}
    >
      <span class="finding-text">
        {finding.verdict === "contained" ? (
          <bdi>{whole}</bdi>
        ) : (
          <>
            <Name text={nameA(finding)} title={finding.path_a} />
            <span>{` ${relation(finding, unit)} `}</span>
            <Name text={nameB(finding)} title={finding.path_b} />
          </>
        )}
      </span>{" "}
      <span class="finding-line">
        <span class="note">{factsText(finding)}</span>
        {status !== "new" && <span class="tag"> {status}</span>}
        {earlier && <strong class="stale"> earlier revision</strong>}
      </span>
    </div>
  );
}
