import assert from "node:assert/strict";
import { test } from "node:test";
import { COMMANDS, commandOf, hint } from "../src/actions/commands";
import { SYNONYMS } from "../src/actions/synonyms";
import { commandOfKey, isForCommands, keyOf } from "../src/input/keys";
import { pieces } from "../src/ui/names";
import { matchingCommands } from "../src/ui/ranking";
import { TOUR } from "../src/ui/tour";

test("no key has two meanings", () => {
  for (const mode of ["typing", undefined]) {
    const seen = new Map<string, string>();
    for (const command of COMMANDS.filter((each) => each.while === mode)) {
      for (const key of command.keys) {
        assert.equal(seen.get(key), undefined, `${key}: ${seen.get(key)} and ${command.id}`);
        seen.set(key, command.id);
      }
    }
  }
});

test("every command has an id of its own, a title, and a way to it", () => {
  assert.equal(new Set(COMMANDS.map((command) => command.id)).size, COMMANDS.length);
  for (const command of COMMANDS) {
    assert.ok(command.title.length > 2, command.id);
    assert.equal(commandOf(command.id), command);
    // Those that only make sense while the tool is moved have a key; all others are in the palette.
    if (command.while === "typing") assert.ok(command.keys.length > 0, command.id);
    else assert.ok(matchingCommands(command.title).includes(command), command.id);
  }
});

test("the keys of the field's conventions are there", () => {
  const keys: Record<string, string> = {
    G: "move",
    R: "turn",
    F: "fit",
    H: "hide",
    "Shift+H": "isolate",
    "Alt+H": "show-all",
    X: "ghost",
    S: "sections",
    M: "measure",
    Space: "mode",
    E: "grip",
    K: "snapshot",
    N: "next-finding",
    P: "previous-finding",
    "Ctrl+Z": "undo",
    "Ctrl+Y": "redo",
    "Ctrl+F": "search",
    "/": "search",
    "1": "view-front",
    "7": "view-corner",
    "?": "help",
    "Ctrl+K": "palette",
  };
  for (const [key, id] of Object.entries(keys)) assert.equal(commandOfKey(key, false), id, key);
  assert.equal(commandOfKey("X", true), "axis-X", "while the tool is moved, X is an axis");
  assert.equal(commandOfKey("Enter", true), "confirm");
  assert.equal(commandOfKey("Escape", true), "cancel");
  assert.equal(commandOfKey("H", true), null);
});

const press = (key: string, modifiers: Partial<KeyboardEvent> = {}, code = "") => ({
  key,
  code,
  ctrlKey: false,
  metaKey: false,
  altKey: false,
  shiftKey: false,
  ...modifiers,
});

test("keys are named alike whatever the keyboard makes of them", () => {
  assert.equal(keyOf(press("h")), "H");
  assert.equal(keyOf(press("H", { shiftKey: true })), "Shift+H");
  assert.equal(keyOf(press("˙", { altKey: true }, "KeyH")), "Alt+H");
  assert.equal(keyOf(press("?", { shiftKey: true })), "?");
  assert.equal(keyOf(press(" ")), "Space");
  assert.equal(keyOf(press("k", { metaKey: true })), "Ctrl+K");
  assert.equal(keyOf(press("Z", { ctrlKey: true, shiftKey: true })), "Ctrl+Shift+Z");
  assert.equal(keyOf(press("ArrowUp", { shiftKey: true })), "Shift+ArrowUp");
});

test("fields and buttons keep the keys that they need", () => {
  assert.equal(isForCommands("H", "text", true), false);
  assert.equal(isForCommands("Ctrl+Z", "text", true), false, "undo in a field undoes the typing");
  assert.equal(isForCommands("Ctrl+K", "text", true), true);
  assert.equal(isForCommands("Escape", "text", true), true);
  assert.equal(isForCommands("Space", "control", true), false);
  assert.equal(isForCommands("ArrowDown", "control", true), false);
  assert.equal(isForCommands("H", "control", true), true);
  assert.equal(isForCommands("Space", "picture", true), true);
});

test("single letters can be switched off", () => {
  for (const key of ["H", "Shift+H", "?", "1"]) assert.equal(isForCommands(key, "picture", false), false, key);
  for (const key of ["Ctrl+K", "Alt+H", "ArrowUp", "Space", "F6"]) {
    assert.equal(isForCommands(key, "picture", false), true, key);
  }
});

test("the palette finds by words and by letters, beginnings first", () => {
  assert.equal(matchingCommands("undo")[0]?.id, "undo");
  assert.equal(matchingCommands("isol")[0]?.id, "isolate");
  assert.ok(matchingCommands("glb").some((command) => command.id === "export_glb"));
  assert.deepEqual(matchingCommands("qqqq"), []);
  assert.ok(matchingCommands("").length > 50);
});

test("a title that is typed in full, or its beginning, is the first", () => {
  for (const command of COMMANDS.filter((each) => each.while !== "typing")) {
    assert.equal(matchingCommands(command.title)[0], command, command.title);
    assert.equal(matchingCommands(command.title.toUpperCase())[0], command, "capitals count for nothing");
  }
  assert.equal(matchingCommands("contact: pass")[0]?.id, "mode-pass");
  assert.equal(matchingCommands("contact pass")[0]?.id, "mode-pass");
  assert.equal(matchingCommands("Contact: glide")[0]?.id, "mode-glide");
  assert.equal(matchingCommands("stop")[0]?.id, "mode-stop");
  assert.equal(matchingCommands("pass")[0]?.id, "mode-pass");
  assert.equal(matchingCommands("measure point")[0]?.id, "measure");
  // What a command is called at present counts like its title.
  const labelled = matchingCommands("solid", COMMANDS, (each) => (each.id === "ghost" ? "Solid" : each.title));
  assert.equal(labelled[0]?.id, "ghost");
});

test("other words find the command, before letters in order do", () => {
  const first = (words: string): string | undefined => matchingCommands(words)[0]?.id;
  const wanted: Record<string, string> = {
    home: "home",
    transparent: "ghost",
    "see-through": "ghost",
    zoom: "zoom-in",
    "take out": "ask-removal",
    "way out": "ask-removal",
    clip: "sections",
    screenshot: "snapshot",
    rotate: "turn",
    distance: "measure",
    revert: "undo",
    preferences: "settings",
    tutorial: "tour",
    inches: "unit-in",
    report: "report",
  };
  for (const [words, id] of Object.entries(wanted)) assert.equal(first(words), id, words);
  const all = (words: string): string[] => matchingCommands(words).map((command) => command.id);
  assert.ok(all("report").slice(0, 3).includes("export_csv"), all("report").join());
  assert.ok(all("save").includes("snapshot") && all("save").includes("page"));
  assert.ok(all("clash").includes("open-findings") && all("interfere").includes("panel-findings"));
  assert.ok(all("timeline").includes("film") && all("clip box").includes("section-box"));
  assert.ok(all("access").includes("ask-access") && all("load").includes("open-findings"));
});

test("letters in order come last, and one letter is not enough", () => {
  const found = matchingCommands("dr");
  const word = found.findIndex((command) => command.title.toLowerCase().includes("dr"));
  const letters = found.findIndex((command) => !command.title.toLowerCase().includes("dr"));
  assert.ok(letters === -1 || word <= letters);
  const table = [
    { id: "a", title: "Load report", keys: [], group: "Page", run: () => null },
    { id: "b", title: "Look around", keys: [], group: "Look", run: () => null },
  ] as const;
  assert.deepEqual(
    matchingCommands("lod", table).map(({ id }) => id),
    ["a", "b"],
  );
  assert.deepEqual(
    matchingCommands("loa", table).map(({ id }) => id),
    ["a", "b"],
    "a beginning before letters in order",
  );
  assert.deepEqual(matchingCommands("z", table), []);
});

test("every other word belongs to a command; those of questions may come later", () => {
  const later = /^(?:ask-|check-clashes|clashes-of)/;
  for (const id of Object.keys(SYNONYMS)) assert.ok(later.test(id) || commandOf(id), id);
});

test("names are cut in the middle, by letters", () => {
  assert.deepEqual(pieces("bolt_012"), ["bolt_012", ""]);
  const long = "engine/externals/accessory_gearbox/bolt_012";
  assert.equal(pieces(long).join(""), long);
  assert.equal(pieces(long)[1], "/bolt_012");
  const wide = "\u{1f527}".repeat(30);
  assert.equal(pieces(wide)[1], "\u{1f527}".repeat(9));
});

test("hints and the tour name keys that exist", () => {
  assert.equal(hint("hide"), "Hide, or show (H)");
  const known = new Set(COMMANDS.flatMap((command) => command.keys));
  for (const step of TOUR) for (const key of step.keys) assert.ok(known.has(key), `${step.title}: ${key}`);
});
