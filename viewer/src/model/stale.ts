// Results of an earlier revision of the mock-up: which of their parts differ since, in words.

import type { StalePart } from "../link/protocol";

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
  const since = sinceText(...given);
  return since === "" ? "" : `of an earlier revision: ${since} since`;
}
