// Searches for attributes of parts: the server knows them, so that the page loads none.

import { type Signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { wholesOf } from "../link/base64";
import { asksForAttributes } from "../model/part-tree";
import { useWorkbench } from "./context";

/** Answers are asked for once the typing rests. */
const REST_MS = 150;

/** The parts that the search finds, for one that asks for attributes; null for others, until it comes, and offline. */
export function useFoundParts(): Signal<ReadonlySet<number> | null> {
  const wb = useWorkbench();
  const found = useSignal<ReadonlySet<number> | null>(null);
  const query = wb.store.search.value;
  const manifest = wb.store.manifest.value;
  useEffect(() => {
    found.value = null;
    if (!wb.link || !asksForAttributes(query)) return;
    let isWanted = true;
    const rest = setTimeout(() => {
      wb.ask("find", { query }).then(
        (answer) => {
          if (isWanted) found.value = new Set(wholesOf(answer.parts));
        },
        () => null,
      );
    }, REST_MS);
    return () => {
      isWanted = false;
      clearTimeout(rest);
    };
  }, [query, manifest]);
  return found;
}
