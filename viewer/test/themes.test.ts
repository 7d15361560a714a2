import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { contrast } from "./contrast";

const style = readFileSync(new URL("../../viewer/src/ui/styles/themes.css", import.meta.url), "utf8");
const LETTERS = ["text", "soft", "accent", "hit", "near", "good", "bad", "warn"];
const BACKGROUNDS = ["back", "panel", "raised", "hover", "accent-back"];

test("letters of every colour are read on every background, in both themes", () => {
  const themes = [...style.matchAll(/^:root[^{]*\{([^}]*--text:[^}]*)\}/gm)].map(([, body = ""]) => body);
  assert.equal(themes.length, 2);
  for (const [k, body] of themes.entries()) {
    const colour = (name: string): number =>
      Number.parseInt(/#(\w{6})/.exec(body.split(`--${name}: `)[1] ?? "")?.[1] ?? "", 16);
    for (const letters of LETTERS)
      for (const back of BACKGROUNDS)
        assert.ok(contrast(colour(letters), colour(back)) >= 4.5, `${letters} on ${back}, theme ${k}`);
  }
});
