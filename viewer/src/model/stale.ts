// Results of an earlier revision of the mock-up: which of their parts differ since, in words.

import type { StalePart } from "../link/protocol";
import type { Finding } from "./finding-list";
import { nameA, nameB } from "./findings";

const MOST_NAMES = 3;

/** "pump moved, lid changed and 4 more"; empty: the result is of the present revision. only: these parts. */
export function sinceText(
  stale: Readonly<Record<string, StalePart>>,
  nameOf: (part: number) => string,
  only?: readonly (number | null)[],
): string {
  const parts = only?.filter((part) => part !== null && stale[part] !== undefined) ?? Object.keys(stale).map(Number);
  const said = parts.slice(0, MOST_NAMES).map((part) => {
    const change = stale[part as number]?.change;
    return `${nameOf(part as number)} ${change === "new" ? "is new" : change}`;
  });
  const more = parts.length - said.length;
  return said.join(", ") + (more > 0 ? ` and ${more} more` : "");
}

/** "of an earlier revision: pump moved since"; empty likewise. */
export function revisionText(...given: Parameters<typeof sinceText>): string {
  return asRevision(sinceText(...given));
}

const asRevision = (since: string): string => (since === "" ? "" : `of an earlier revision: ${since} since`);

/** The same of a finding. gone: the paths of parts that this revision does not have. */
export function findingRevision(
  finding: Finding,
  stale: Readonly<Record<string, StalePart>>,
  gone: readonly string[],
  nameOf: (part: number) => string,
): string {
  const lost = [
    finding.part_a === null && gone.includes(finding.path_a) ? nameA(finding) : "",
    finding.part_b === null && gone.includes(finding.path_b) ? nameB(finding) : "",
  ];
  const since = sinceText(stale, nameOf, [finding.part_a, finding.part_b]);
  return asRevision([...lost.filter(Boolean).map((name) => `${name} gone`), since].filter(Boolean).join(", "));
}

/** What differs since a check of all: "1 part gone, pump moved". A check of this revision has nothing stale; what is gone is gone
 * until the revision is accepted. */
export function checkSince(
  stale: Readonly<Record<string, StalePart>>,
  gone: readonly string[],
  nameOf: (part: number) => string,
): string {
  const is_earlier = Object.keys(stale).length > 0;
  const lost = gone.length === 0 || !is_earlier ? "" : `${gone.length} ${gone.length === 1 ? "part" : "parts"} gone`;
  return [lost, sinceText(stale, nameOf)].filter(Boolean).join(", ");
}
