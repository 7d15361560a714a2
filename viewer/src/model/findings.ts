// The visible findings of a clash check, and their order. Pure.

import type { Finding, FindingGroup, FindingStatus, Findings } from "../link/protocol";

export type FindingOrder = "depth" | "group";

/** Groups with the visible findings: without contacts if they are hidden, filtered by the typed words. */
export function shownGroups(findings: Findings, query: string, order: FindingOrder): FindingGroup[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const isShown = (finding: Finding, group: FindingGroup): boolean => {
    if (findings.is_touching_hidden && finding.is_touching) return false;
    const text = `${group.name} ${finding.sentence} ${findings.status[finding.id] ?? "new"}`.toLowerCase();
    return words.every((word) => text.includes(word));
  };
  const deepest = (group: FindingGroup): number => Math.max(0, ...group.findings.map(depthOf));
  const groups = findings.groups
    .map((group) => ({
      ...group,
      findings: group.findings.filter((finding) => isShown(finding, group)).sort((a, b) => depthOf(b) - depthOf(a)),
    }))
    .filter((group) => group.findings.length > 0);
  return order === "depth" ? groups.sort((a, b) => deepest(b) - deepest(a)) : groups;
}

export const depthOf = (finding: Finding): number => finding.depth ?? 0;

/** The two parts, as far as this mock-up has them. */
export const partsOf = (finding: Finding): number[] => [finding.part_a, finding.part_b].filter((part) => part !== null);

/** The finding `step` further on, cyclically; null if there is none. */
export function neighbour(groups: readonly FindingGroup[], current: string | null, step: 1 | -1): Finding | null {
  const all = groups.flatMap((group) => group.findings);
  const at = all.findIndex((finding) => finding.id === current);
  if (at < 0) return (step > 0 ? all[0] : all.at(-1)) ?? null;
  return all[(at + step + all.length) % all.length] ?? null;
}

export const STATUSES: readonly FindingStatus[] = ["new", "active", "reviewed", "approved", "resolved"];
