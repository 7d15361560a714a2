// A long list of rows of one height: at most eighty of them in the page, one of which has the focus.

import { type Signal, useSignal } from "@preact/signals";
import { type MutableRef, useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { scrollTo, visibleRows } from "./virtual";

export interface VirtualList {
  readonly list: MutableRef<HTMLDivElement | null>;
  /** The row that has the focus, or would have. */
  readonly current: number;
  readonly active: Signal<number>;
  /** The rows to draw. */
  readonly shown: readonly number[];
  /** Brings a row into sight, and makes it the current one. */
  show(at: number): void;
  /** The current row gets the focus once it is drawn. */
  focus(): void;
  /** The row that a key leads to; null: the key leads nowhere. */
  target(key: string): number | null;
  onScroll(event: { readonly currentTarget: HTMLElement }): void;
}

export function useVirtualList(count: number, row_px: number): VirtualList {
  const active = useSignal(0);
  const scroll_top = useSignal(0);
  const height = useSignal(600);
  const list = useRef<HTMLDivElement>(null);
  const is_focus_due = useRef(false);

  useEffect(() => {
    const element = list.current;
    if (!element) return;
    const observer = new ResizeObserver(() => {
      height.value = element.clientHeight;
    });
    observer.observe(element);
    return () => observer.disconnect();
  }, []);

  useLayoutEffect(() => {
    if (!is_focus_due.current) return;
    is_focus_due.current = false;
    list.current?.querySelector<HTMLElement>("[role=treeitem][tabindex='0']")?.focus({ preventScroll: true });
  });

  const current = Math.min(active.value, Math.max(0, count - 1));
  const { first, end } = visibleRows(scroll_top.value, height.value, row_px, count);
  const shown: number[] = [];
  for (let k = first; k < end; k++) shown.push(k);
  // The row with the focus stays in the page, so that scrolling does not lose it.
  if (count > 0 && (current < first || current >= end)) shown.push(current);

  return {
    list,
    current,
    active,
    shown,
    show: (at) => {
      active.value = at;
      const element = list.current;
      if (element) element.scrollTop = scrollTo(at, element.scrollTop, element.clientHeight, row_px);
    },
    focus: () => {
      is_focus_due.current = true;
    },
    target: (key) => {
      const page = Math.max(1, Math.floor(height.peek() / row_px) - 1);
      const at = active.peek();
      const moves: Readonly<Record<string, number>> = {
        ArrowDown: at + 1,
        ArrowUp: at - 1,
        PageDown: at + page,
        PageUp: at - page,
        Home: 0,
        End: count - 1,
      };
      const to = moves[key];
      return to === undefined ? null : Math.max(0, Math.min(count - 1, to));
    },
    onScroll: (event) => {
      scroll_top.value = event.currentTarget.scrollTop;
    },
  };
}
