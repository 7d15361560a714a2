// A dialog over the page: the browser's own, which keeps the focus inside and returns it.

import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";

export function Dialog(props: { title: string; kind: string; bare?: boolean; children: ComponentChildren }) {
  const wb = useWorkbench();
  const element = useRef<HTMLDialogElement>(null);
  // Before the browser does anything else, so that the next keys go into the dialog.
  useLayoutEffect(() => {
    const dialog = element.current;
    dialog?.showModal();
    return () => dialog?.close();
  }, []);
  const close = (): void => {
    wb.store.dialog.value = null;
  };
  return (
    <dialog
      ref={element}
      class={`dialog ${props.kind}`}
      aria-label={props.title}
      onCancel={(event) => {
        event.preventDefault();
        close();
      }}
      onClick={(event) => {
        if (event.target === element.current) close();
      }}
      onKeyDown={(event) => {
        if (event.key === "Escape") {
          event.preventDefault();
          event.stopPropagation();
          close();
        }
      }}
    >
      <div class="dialog-body">
        {!props.bare && (
          <header class="dialog-head">
            <h2>{props.title}</h2>
            <IconButton icon="close" label="Close" run={close} />
          </header>
        )}
        {props.children}
      </div>
    </dialog>
  );
}
