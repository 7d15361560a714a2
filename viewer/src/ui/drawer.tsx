// In a narrow window tree and panels are drawers, one at a time: the tree over the picture, panels beside it where there
// is room. The focus goes in and comes back.

import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";

// Of tabs the chosen one alone: the others leave the order of the Tab key.
const FIRST = "input:not([type=radio]), button:not([disabled]):not([tabindex='-1'])";

interface SideProps {
  side: "tree" | "panels";
  title: string;
  children: ComponentChildren;
}

/** Tree or panels, or their drawer. */
export function Side(props: SideProps) {
  const { store } = useWorkbench();
  return store.is_narrow.value ? <Drawer {...props} /> : props.children;
}

function Drawer({ side, title, children }: SideProps) {
  const wb = useWorkbench();
  const element = useRef<HTMLDivElement>(null);
  const body = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const drawer = element.current;
    const before = document.activeElement;
    // A field that asked for the focus has it already.
    if (!drawer?.contains(before)) body.current?.querySelector<HTMLElement>(FIRST)?.focus({ preventScroll: true });
    return () => {
      const isInside = drawer?.contains(document.activeElement) ?? false;
      if (!isInside && document.activeElement !== document.body) return;
      if (before instanceof HTMLElement && before.isConnected && before !== document.body) before.focus();
      else wb.canvas?.focus();
    };
  }, []);
  return (
    <div ref={element} class={`drawer drawer-${side}`}>
      <div class="drawer-head">
        <p class="drawer-title" aria-hidden="true">
          {title}
        </p>
        <IconButton icon="close" label={`Close: ${title}`} run={() => wb.store.showDrawer(null)} />
      </div>
      <div ref={body} class="drawer-body">
        {children}
      </div>
    </div>
  );
}
