// The tree of parts: ten thousand of them, at most eighty rows in the page.

import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { formatCount } from "../math/units";
import type { TreeRow } from "../model/part-tree";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";
import { useFoundParts } from "./part-search";
import { Properties } from "./properties";
import { useVirtualList } from "./virtual-list";
import { partsText } from "./words";

/** For a mouse, and for a finger. */
const ROW_PX = 26;
const COARSE_ROW_PX = 44;
const INDENT_PX = 14;

type Share = "none" | "some" | "all";

function shareOf(parts: readonly number[], chosen: ReadonlySet<number>): Share {
  if (chosen.size === 0) return "none";
  let count = 0;
  for (const part of parts) if (chosen.has(part)) count++;
  return count === 0 ? "none" : count === parts.length ? "all" : "some";
}

export function Tree() {
  const wb = useWorkbench();
  const { store } = wb;
  const open = useSignal<ReadonlySet<number>>(new Set());
  const shut = useSignal<ReadonlySet<number>>(new Set());
  const anchor = useSignal(0);
  const row_px = store.is_coarse.value ? COARSE_ROW_PX : ROW_PX;

  const answered = useFoundParts();
  const rows = useComputed(() => store.tree.value.rows(open.value, store.search.value, shut.value, answered.value));
  const found = useComputed(() =>
    store.search.value.trim() === "" ? null : store.tree.value.matching(store.search.value, answered.value),
  );

  const virtual = useVirtualList(rows.value.length, row_px);
  const { active, list, show } = virtual;

  // Another mock-up: its first levels are open.
  useSignalEffect(() => {
    const tree = store.tree.value;
    open.value = new Set(tree.roots.length === 1 ? tree.roots : []);
    active.value = 0;
  });

  // A part chosen in the picture comes into sight.
  useSignalEffect(() => {
    const selection = store.selection.value;
    const part = [...selection].at(-1);
    const tree = store.tree.peek();
    if (part === undefined || selection.size > 1 || list.current?.contains(document.activeElement)) return;
    const node = tree.nodeOf(part);
    if (node < 0) return;
    open.value = new Set([...open.peek(), ...tree.above(node)]);
    const at = rows.peek().findIndex((row) => row.node === node);
    if (at >= 0) show(at);
  });

  const partsOf = (row: TreeRow | undefined): number[] => (row ? store.tree.peek().partsUnder(row.node) : []);

  const toggle = (row: TreeRow, isOpen = !row.isOpen): void => {
    if (!row.isGroup) return;
    const isSearching = store.search.peek().trim() !== "";
    const [set, has] = isSearching ? [shut, !isOpen] : [open, isOpen];
    const next = new Set(set.peek());
    if (has) next.add(row.node);
    else next.delete(row.node);
    set.value = next;
  };

  const choose = (at: number, event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }): void => {
    const row = rows.peek()[at];
    if (!row) return;
    if (event.shiftKey) {
      const [from, to] = [Math.min(anchor.peek(), at), Math.max(anchor.peek(), at)];
      wb.select(
        rows
          .peek()
          .slice(from, to + 1)
          .flatMap(partsOf),
      );
    } else {
      wb.select(partsOf(row), event.ctrlKey || event.metaKey ? "toggle" : "only");
      anchor.value = at;
    }
    show(at);
  };

  const go = (at: number, event: KeyboardEvent): void => {
    const next = Math.max(0, Math.min(rows.peek().length - 1, at));
    virtual.focus();
    if (event.shiftKey) choose(next, event);
    else {
      anchor.value = next;
      show(next);
    }
  };

  const onKey = (event: KeyboardEvent): void => {
    if (event.altKey || ((event.ctrlKey || event.metaKey) && event.key !== " ")) return;
    const at = active.peek();
    const row = rows.peek()[at];
    if (!row) return;
    const to = virtual.target(event.key);
    const moves: Record<string, () => void> = {
      ArrowRight: () => (row.isGroup && !row.isOpen ? toggle(row, true) : go(at + (row.isGroup ? 1 : 0), event)),
      ArrowLeft: () => {
        if (row.isGroup && row.isOpen) toggle(row, false);
        else {
          const parent = store.tree.peek().node(row.node).parent;
          const up = rows.peek().findIndex((each) => each.node === parent);
          if (up >= 0) go(up, event);
        }
      },
      Enter: () => choose(at, event),
      " ": () => choose(at, event),
    };
    const move = to === null ? moves[event.key] : () => go(to, event);
    if (!move) return;
    event.preventDefault();
    event.stopPropagation();
    virtual.focus();
    move();
  };

  const count = rows.value.length;

  return (
    <nav id="tree" class="tree" aria-label="Parts">
      <div class="tree-head">
        <div class="search-box">
          <Icon name="search" size={14} />
          <input
            id="search"
            type="search"
            placeholder="Search parts"
            aria-label="Search parts"
            title="Words of paths, or attributes: material:steel"
            autocomplete="off"
            spellcheck={false}
            value={store.search.value}
            onInput={(event) => {
              store.search.value = event.currentTarget.value;
              shut.value = new Set();
            }}
            onKeyDown={(event) => {
              if (event.key === "Enter" && found.peek()) wb.select(found.peek() ?? []);
              else if (event.key === "Escape" && store.search.peek() !== "") {
                event.stopPropagation();
                store.search.value = "";
              } else if (event.key === "ArrowDown") {
                event.preventDefault();
                virtual.focus();
                active.value = 0;
                list.current?.querySelector<HTMLElement>("[role=treeitem]")?.focus();
              }
            }}
          />
        </div>
        <div class="tree-tools">
          <CommandButton id="hide" icon="eye" />
          <CommandButton id="ghost" icon="ghost" />
          <CommandButton id="isolate" icon="isolate" pressed={store.document.value?.isolated ?? false} />
          <CommandButton id="show-all" icon="list" text="Show all" />
        </div>
        <p class="tree-count" aria-live="polite">
          {found.value
            ? `${formatCount(found.value.length)} of ${formatCount(store.part_count.value)} found`
            : `${partsText(store.part_count.value, formatCount)}${store.hidden.value.size > 0 ? `, ${formatCount(store.hidden.value.size)} hidden` : ""}`}
        </p>
      </div>
      <div
        ref={list}
        class="tree-list"
        role="tree"
        aria-label="Parts"
        aria-multiselectable="true"
        onScroll={virtual.onScroll}
        onKeyDown={onKey}
      >
        <div class="tree-space" role="none" style={{ height: `${count * row_px}px` }}>
          {virtual.shown.map((at) => {
            const row = rows.value[at];
            return (
              row && (
                <Row
                  key={row.node}
                  row={row}
                  at={at}
                  isActive={at === virtual.current}
                  toggle={() => toggle(row)}
                  choose={(event) => choose(at, event)}
                />
              )
            );
          })}
        </div>
      </div>
      <Properties />
    </nav>
  );
}

interface RowProps {
  row: TreeRow;
  at: number;
  isActive: boolean;
  toggle: () => void;
  choose: (event: MouseEvent) => void;
}

function Row({ row, at, isActive, toggle, choose }: RowProps) {
  const wb = useWorkbench();
  const { store } = wb;
  const node = store.tree.value.node(row.node);
  const parts = store.tree.value.partsUnder(row.node);
  const selected = shareOf(parts, store.selection.value);
  const hidden = shareOf(parts, store.hidden.value);
  const ghost = shareOf(parts, store.ghost.value);
  const document = store.document.value;
  const isHeld = node.part >= 0 && (document?.gripped.includes(node.part) ?? false);
  const isOut = node.part >= 0 && (document?.out.includes(node.part) ?? false);
  const classes = [
    "row",
    selected === "all" ? "selected" : selected === "some" ? "partly" : "",
    hidden === "all" ? "is-hidden" : "",
    ghost === "all" ? "is-ghost" : "",
    store.hover.value === node.part && node.part >= 0 ? "hovered" : "",
  ];
  const isLocked = !store.can_look.value;
  // Begins with the visible text of the row, so that speech input can name it.
  const seen = [node.name, isHeld ? "held" : "", isOut ? "out" : "", row.isGroup ? formatCount(parts.length) : ""];
  const states = [hidden === "all" ? "hidden" : "", ghost === "all" ? "ghost" : ""];
  const label = [seen.filter(Boolean).join(" "), ...states.filter(Boolean)].join(", ");
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the tree takes the keys of all its rows
    <div
      role="treeitem"
      class={classes.join(" ")}
      tabIndex={isActive ? 0 : -1}
      aria-level={row.depth + 1}
      aria-posinset={row.place}
      aria-setsize={row.siblings}
      aria-selected={selected === "all"}
      aria-expanded={row.isGroup ? row.isOpen : undefined}
      aria-label={label}
      title={node.path}
      style={{
        transform: `translateY(${at * (store.is_coarse.value ? COARSE_ROW_PX : ROW_PX)}px)`,
        paddingLeft: `${6 + row.depth * INDENT_PX}px`,
      }}
      onClick={choose}
      onDblClick={() => wb.fit(parts)}
      onContextMenu={(event) => {
        event.preventDefault();
        if (selected !== "all") wb.select(parts);
        const at = { x: event.clientX, y: event.clientY };
        store.menu.value = { ...at, part: parts[0] ?? -1, point: null, at };
      }}
    >
      <span
        class={`twist ${row.isGroup ? (row.isOpen ? "open" : "") : "leaf"}`}
        aria-hidden="true"
        onClick={(event) => {
          event.stopPropagation();
          toggle();
        }}
      >
        {row.isGroup && <Icon name="chevron" size={12} />}
      </span>
      <span class="row-name">
        <Name text={node.name} title={node.path} />
      </span>
      {isHeld && <span class="tag held"> held</span>}
      {isOut && <span class="tag"> out</span>}
      {row.isGroup && <span class="row-count"> {formatCount(parts.length)}</span>}
      <span class="row-tools">
        <IconButton
          icon="isolate"
          label={`Isolate ${node.name}`}
          tabIndex={-1}
          disabled={isLocked}
          run={() => wb.run("isolate", { parts })}
        />
        <IconButton
          icon="ghost"
          label={`Ghost ${node.name}`}
          tabIndex={-1}
          pressed={ghost === "all"}
          disabled={isLocked}
          run={() => wb.run("ghost", { parts, is_on: ghost !== "all" })}
        />
        <IconButton
          icon={hidden === "all" ? "eyeOff" : "eye"}
          label={`${hidden === "all" ? "Show" : "Hide"} ${node.name}`}
          tabIndex={-1}
          pressed={hidden === "all"}
          disabled={isLocked}
          run={() => wb.run(hidden === "all" ? "show" : "hide", { parts })}
        />
      </span>
    </div>
  );
}
