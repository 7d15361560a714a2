// docs/workbench-keys.md has all keys, as the table of commands has them.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { COMMANDS, type PageCommand, shownKey } from "../src/actions/commands";

const said = ({ keys, title }: PageCommand): string =>
  `${keys.map((key) => `<kbd>${shownKey(key)}</kbd>`).join(" ")} ${title.toLowerCase()}`;

/** A line for each group, and one for the keys that count while the tool is moved by keys. */
function linesOfKeys(): string[] {
  const withKeys = COMMANDS.filter((command) => command.keys.length > 0);
  const groups = [...new Set(withKeys.map((command) => command.group))];
  const line = (name: string, commands: PageCommand[]): string => `| ${name} | ${commands.map(said).join("; ")} |`;
  return [
    ...groups.map((group) =>
      line(
        group,
        withKeys.filter((command) => command.group === group && !command.while),
      ),
    ),
    line(
      "After G or R",
      withKeys.filter((command) => command.while === "typing"),
    ),
  ];
}

test("docs/workbench-keys.md has all keys", () => {
  const page = readFileSync("../docs/workbench-keys.md", "utf8");
  const missing = linesOfKeys().filter((line) => !page.includes(`${line}\n`));
  assert.equal(missing.length, 0, `put these lines into its table of keys:\n${missing.join("\n")}`);
});
