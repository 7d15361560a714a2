// Files that are dropped on the page, wherever they fall.

import { takeFiles } from "../actions/opening";
import type { Workbench } from "../actions/workbench";

/** Listens to drops on the whole page; the function returned ends it. */
export function listenToDrops(wb: Workbench): () => void {
  const { is_dropping } = wb.store;
  // Every element under the pointer tells that it is entered and left: the depth says whether the page is.
  let depth = 0;
  const hasFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  const listeners: { [Name in "dragenter" | "dragover" | "dragleave" | "drop"]: (event: DragEvent) => void } = {
    dragenter: (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      depth++;
      is_dropping.value = true;
    },
    dragover: (event) => {
      // Else the browser would leave the page and show the file.
      if (hasFiles(event)) event.preventDefault();
    },
    dragleave: (event) => {
      if (!hasFiles(event)) return;
      depth = Math.max(0, depth - 1);
      is_dropping.value = depth > 0;
    },
    drop: (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      depth = 0;
      is_dropping.value = false;
      takeFiles(wb, [...(event.dataTransfer?.files ?? [])]);
    },
  };
  for (const [name, listen] of Object.entries(listeners)) window.addEventListener(name, listen as EventListener);
  return () => {
    for (const [name, listen] of Object.entries(listeners)) window.removeEventListener(name, listen as EventListener);
  };
}
