// The rows of the findings are fetched once a version, and a finding in the picture is left by the next thing that is done.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { isSame } from "../math/same";
import { FindingList } from "../model/findings";

/** Fetches `GET /findings/VERSION`. */
export type FetchRows = (version: string) => Promise<ArrayBuffer>;

/** Follows the document from now on; the function returned ends it. */
export function followFindings(wb: Workbench, fetchRows: FetchRows | null): () => void {
  const { findings, document, connection } = wb.store;
  let asked = "";
  const endRows = effect(() => {
    const version = document.value?.findings?.version ?? "";
    if (connection.value === "lost") asked = "";
    if (version === "" && connection.value === "open") {
      asked = "";
      findings.list.value = null;
      findings.endLook();
    }
    if (!fetchRows || version === "" || version === asked || version === findings.list.peek()?.version) return;
    if (connection.value !== "open") return;
    asked = version;
    findings.failed.value = null;
    fetchRows(version).then(
      (frame) => {
        if (asked === version) takeRows(wb, FindingList.decoded(frame));
      },
      (error: unknown) => {
        if (asked !== version) return;
        asked = "";
        findings.failed.value = error instanceof Error ? error.message : String(error);
      },
    );
  });
  const endFocus = followFocus(wb);
  return () => {
    endRows();
    endFocus();
  };
}

/** Takes rows in place of those of another version. */
export function takeRows(wb: Workbench, list: FindingList): void {
  const { findings } = wb.store;
  findings.endLook();
  findings.chosen.value = new Set();
  findings.list.value = list;
  if (list.rowOf(findings.current.peek()) < 0) findings.current.value = null;
}

/** What was done since a finding was shown ends the look at it: the picture is the document's again. */
function followFocus(wb: Workbench): () => void {
  const { store } = wb;
  let before: unknown = null;
  return effect(() => {
    const focus = store.findings.focus.value;
    const { hidden, ghost, isolated, moved, gripped, explode } = store.document.value ?? {};
    const now = [hidden, ghost, isolated, moved, gripped, explode, store.panel.value, store.selection.value.size > 0];
    if (focus && before && !isSame(before, now)) store.findings.endLook();
    before = focus ? now : null;
  });
}
