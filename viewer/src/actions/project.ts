// The project: how its saving is told, the download without one, and parts that a newer revision changed.

import type { LeftPattern, ProjectFacts } from "../link/protocol";
import { exportFile } from "./exports";
import type { Workbench } from "./workbench";

export const project = (wb: Workbench): ProjectFacts | null => wb.store.document.value?.project ?? null;

/** Whether parts differ from those that the answers of the project are about. */
export const isStale = (facts: ProjectFacts | null): facts is ProjectFacts =>
  facts !== null && (Object.keys(facts.stale).length > 0 || facts.gone.length > 0 || facts.left.length > 0);

/** What patterns of a requirement, or of the rules, do not name any more: "pipe* does not name hose, which was pipe_1". */
export function leftTexts(wb: Workbench, of: LeftPattern["of"], patterns: readonly string[]): string[] {
  const left = (project(wb)?.left ?? []).filter((each) => each.of === of && patterns.includes(each.pattern));
  return left.map(({ pattern, part, was }) => `${pattern} does not name ${part} any more, which was ${was}.`);
}

/** How far the saving is, in words. */
export function savingText(facts: ProjectFacts): string {
  switch (facts.state) {
    case "saved":
      return "Saved";
    case "saving":
      return "Saving";
    case "read only":
      return "Project is read only";
    case "failed":
      return "Not saved";
  }
}

/** What changed, by kind: "2 changed, 1 gone". */
export function staleText(facts: ProjectFacts): string {
  const counts = new Map<string, number>();
  for (const change of Object.values(facts.stale)) counts.set(change, (counts.get(change) ?? 0) + 1);
  const words = ["changed", "moved", "new"].flatMap((word) =>
    counts.has(word) ? [`${counts.get(word)} ${word}`] : [],
  );
  if (facts.gone.length > 0) words.push(`${facts.gone.length} gone`);
  const left = new Set(facts.left.map(({ part }) => part)).size;
  if (left > 0) words.push(`${left} left by a pattern`);
  return words.join(", ");
}

/** With a project all is saved already, and this tells so; without one, the project comes as a download. */
export function saveProject(wb: Workbench): unknown {
  const facts = project(wb);
  if (!facts) return exportFile(wb, "export_project");
  const text = facts.trouble
    ? `Not saved: ${facts.trouble}`
    : facts.state === "read only"
      ? `${facts.name} was opened read-only: changes are not saved`
      : `${facts.name} saves each change as you make it`;
  wb.store.notify(facts.state === "failed" ? "error" : "info", text);
  return undefined;
}

/** Selects the parts that changed, moved or are new, and those that patterns do not name any more. */
export function selectStale(wb: Workbench): void {
  const { stale = {}, left = [] } = project(wb) ?? {};
  const paths = wb.store.paths.peek();
  const renamed = left.map(({ part }) => paths.indexOf(part)).filter((part) => part >= 0);
  wb.select([...new Set([...Object.keys(stale).map(Number), ...renamed])]);
}
