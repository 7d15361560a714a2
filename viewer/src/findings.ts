// The findings in the order in which they are stepped through, and what looking at one does. Mostly pure.

import type { Document, Finding, FindingGroup, Findings } from "./document";
import { add, scale } from "./scene/vectors";
import type { Workbench } from "./workbench";

export type FindingOrder = "depth" | "group";

/** Groups with the findings that are shown: not those that only touch where they are hidden, words as typed. */
export function shownGroups(findings: Findings, query: string, order: FindingOrder): FindingGroup[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const isShown = (finding: Finding, group: FindingGroup): boolean => {
    if (findings.is_touching_hidden && finding.kind === "touching") return false;
    const text = `${group.name} ${finding.sentence} ${findings.status[finding.id] ?? "new"}`.toLowerCase();
    return words.every((word) => text.includes(word));
  };
  const deepest = (group: FindingGroup): number => Math.max(0, ...group.findings.map((finding) => finding.depth));
  const groups = findings.groups
    .map((group) => ({
      ...group,
      findings: group.findings.filter((finding) => isShown(finding, group)).sort((a, b) => b.depth - a.depth),
    }))
    .filter((group) => group.findings.length > 0);
  return order === "depth" ? groups.sort((a, b) => deepest(b) - deepest(a)) : groups;
}

/** The finding `step` further on, round and round; null where there is none. */
export function neighbour(groups: readonly FindingGroup[], current: string | null, step: 1 | -1): Finding | null {
  const all = groups.flatMap((group) => group.findings);
  const at = all.findIndex((finding) => finding.id === current);
  if (at < 0) return (step > 0 ? all[0] : all.at(-1)) ?? null;
  return all[(at + step + all.length) % all.length] ?? null;
}

export const STATUSES = ["new", "active", "reviewed", "approved", "resolved"] as const;

/** N and P. */
export async function stepFinding(wb: Workbench, step: 1 | -1): Promise<void> {
  const findings = wb.document?.findings;
  if (!findings) return;
  const next = neighbour(shownGroups(findings, "", "depth"), wb.store.finding.peek(), step);
  if (next) await lookAtFinding(wb, next);
}

/** The rest becomes ghost; camera and pivot go to the contact, not to the middle of both parts. */
export async function lookAtFinding(wb: Workbench, finding: Finding): Promise<void> {
  wb.store.panel.value = "findings";
  wb.store.finding.value = finding.id;
  wb.select(finding.parts);
  const { camera } = wb.stage;
  const size = reachOf(wb, finding);
  const away = scale(camera.forward, -size);
  camera.target = [...finding.point];
  camera.position = add(finding.point, away);
  camera.moved = true;
  wb.redraw();
  wb.say(finding.sentence);
  if (!wb.store.is_read_only.peek()) await ghostOthers(wb, wb.document, finding.parts);
}

/** How far away the eye stays: enough to see what is around, near enough to see the contact. */
function reachOf(wb: Workbench, finding: Finding): number {
  const sizes = finding.parts.map((part) => {
    const box = wb.boxOf([part]);
    return Math.hypot(...box.upper.map((value, k) => value - (box.lower[k] ?? 0)));
  });
  const smallest = Math.min(...sizes.filter((size) => Number.isFinite(size) && size > 0), 0.5);
  return Math.max(2.5 * smallest, 20 * finding.depth, 1e-3);
}

async function ghostOthers(wb: Workbench, document: Document | null, parts: readonly number[]): Promise<void> {
  if (!document) return;
  const count = wb.store.paths.peek().length;
  const solid = new Set(parts);
  const others = Array.from({ length: count }, (_, part) => part).filter((part) => !solid.has(part));
  await wb.run("show", { parts });
  if (document.ghost.some((part) => solid.has(part))) await wb.run("ghost", { parts, is_on: false });
  const ghost = new Set(document.ghost);
  const fresh = others.filter((part) => !ghost.has(part));
  if (fresh.length > 0) await wb.run("ghost", { parts: fresh, is_on: true });
}
