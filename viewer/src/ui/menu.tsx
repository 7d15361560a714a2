// The context menu of a part, or of the background.

import { useLayoutEffect, useRef } from "preact/hooks";
import { commandOf, runCommand, shownKey } from "../actions/commands";
import { labelOf } from "../actions/labels";
import { measureFrom } from "../actions/measures";
import { addSection, cutAlongFace } from "../actions/sections";
import { useWorkbench } from "./context";
import { Name } from "./names";

const PART_ITEMS = ["hide", "isolate", "ghost", "grip", "put-back", "fit", "section-box-fit", "clashes-of"] as const;
const ASK_ITEMS = ["ask-removal", "ask-order", "ask-tools", "ask-swept"] as const;
const EMPTY_ITEMS = ["fit", "show-all", "undo", "redo", "snapshot", "palette"] as const;

export function ContextMenu() {
  const wb = useWorkbench();
  const { store } = wb;
  const menu = store.menu.value;
  const element = useRef<HTMLDivElement>(null);
  const opener = useRef<HTMLElement | null>(null);

  useLayoutEffect(() => {
    const box = element.current;
    if (!menu || !box) return;
    box.style.left = `${Math.max(4, Math.min(menu.x, window.innerWidth - box.offsetWidth - 4))}px`;
    box.style.top = `${Math.max(4, Math.min(menu.y, window.innerHeight - box.offsetHeight - 4))}px`;
    const before = document.activeElement instanceof HTMLElement ? document.activeElement : null;
    if (!box.contains(before)) opener.current = before;
    box.querySelector<HTMLElement>("[role=menuitem]:not([disabled])")?.focus();
    const onPress = (event: PointerEvent): void => {
      if (!box.contains(event.target as Node)) store.menu.value = null;
    };
    window.addEventListener("pointerdown", onPress, true);
    return () => window.removeEventListener("pointerdown", onPress, true);
  }, [menu]);

  if (!menu) return null;
  const close = (): void => {
    store.menu.value = null;
    if (opener.current?.isConnected && opener.current !== document.body) opener.current.focus();
    else wb.canvas?.focus();
  };
  const { point } = menu;
  const isLocked = store.is_read_only.value;
  const extra =
    menu.part >= 0 && point
      ? [
          { text: "Cut here", run: () => addSection(wb, undefined, point), isOff: !store.can_look.value },
          { text: "Cut along this face", run: () => cutAlongFace(wb, menu.at), isOff: isLocked },
          { text: "Measure from here", run: () => measureFrom(wb, menu.at), isOff: isLocked },
        ]
      : [];
  const onKey = (event: KeyboardEvent): void => {
    const items = [...(element.current?.querySelectorAll<HTMLElement>("[role=menuitem]:not([disabled])") ?? [])];
    const at = items.indexOf(document.activeElement as HTMLElement);
    const next = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: items.length - 1 }[event.key];
    if (next !== undefined) items[(next + items.length) % items.length]?.focus();
    else if (event.key === "Escape" || event.key === "Tab") close();
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div
      ref={element}
      class="menu"
      role="menu"
      tabIndex={-1}
      aria-label={menu.items ? "More" : menu.part >= 0 ? wb.path(menu.part) : "Picture"}
      onKeyDown={onKey}
    >
      {menu.part >= 0 && (
        <div class="menu-title" role="presentation" title={wb.path(menu.part)}>
          {store.selection.value.size > 1 ? (
            `${store.selection.value.size} parts`
          ) : (
            <Name text={store.nameOf(menu.part)} title={wb.path(menu.part)} />
          )}
        </div>
      )}
      {(menu.items ?? (menu.part >= 0 ? [...PART_ITEMS, ...ASK_ITEMS] : EMPTY_ITEMS)).map((id) => {
        const command = commandOf(id);
        const canRun = command.when?.(wb) ?? true;
        return (
          <button
            type="button"
            role="menuitem"
            key={id}
            disabled={!canRun}
            onClick={() => {
              close();
              runCommand(wb, id);
            }}
          >
            <span class="row-name">{labelOf(wb, command)}</span>
            {command.keys[0] && <kbd>{shownKey(command.keys[0])}</kbd>}
          </button>
        );
      })}
      {extra.map(({ text, run, isOff }) => (
        <button
          type="button"
          role="menuitem"
          key={text}
          disabled={isOff}
          onClick={() => {
            close();
            run();
          }}
        >
          <span class="row-name">{text}</span>
        </button>
      ))}
    </div>
  );
}
