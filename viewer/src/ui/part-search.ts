// Searches for attributes of parts: the server knows them, so that the page loads none.

import { type ReadonlySignal, useComputed, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { wholesOf } from "../math/base64";
import { asksForAttributes } from "../model/part-tree";
import { useWorkbench } from "./context";

/** Answers are asked for once the typing rests. */
const REST_MS = 150;

/** The parts that the search finds, for one that asks for attributes; null for others, until it comes, and offline. */
export function useFoundParts(): ReadonlySignal<ReadonlySet<number> | null> {
  const wb = useWorkbench();
  const answered = useSignal<{ query: string; parts: ReadonlySet<number> } | null>(null);
  const query = wb.store.search.value;
  const manifest = wb.store.manifest.value;
  useEffect(() => {
    answered.value = null;
    if (!wb.link || !asksForAttributes(query)) return;
    let isWanted = true;
    const rest = setTimeout(() => {
      wb.ask("find", { query }).then(
        (answer) => {
          if (isWanted) answered.value = { query, parts: new Set(wholesOf(answer.parts)) };
        },
        () => null,
      );
    }, REST_MS);
    return () => {
      isWanted = false;
      clearTimeout(rest);
    };
  }, [query, manifest]);
  // At once, not when the effect has run: an answer is of its own search alone.
  return useComputed(() => (answered.value?.query === wb.store.search.value ? answered.value.parts : null));
}
