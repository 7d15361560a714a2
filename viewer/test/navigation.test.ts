import assert from "node:assert/strict";
import { test } from "node:test";
import { actionOf, LEFT, MIDDLE, RIGHT, STYLES, styleOf } from "../src/model/navigation";

const chord = (buttons: number, keys: { shiftKey?: boolean; ctrlKey?: boolean; altKey?: boolean } = {}) => ({
  buttons,
  shiftKey: false,
  ctrlKey: false,
  altKey: false,
  ...keys,
});

test("each style turns, moves and zooms, and no chord means two things", () => {
  assert.deepEqual(
    STYLES.map((style) => style.id),
    ["feeler", "blender", "solidworks", "catia", "onshape", "touchpad"],
  );
  for (const style of STYLES) {
    const actions = new Set(style.bindings.map((binding) => binding.action));
    assert.ok(actions.has("orbit") && (actions.has("pan") || style.wheel === "pan"), style.id);
    const chords = style.bindings.map(({ buttons, shift, ctrl, alt }) => `${buttons} ${!!shift} ${!!ctrl} ${!!alt}`);
    assert.equal(new Set(chords).size, chords.length, style.id);
  }
});

test("styles do what their programs do", () => {
  assert.equal(actionOf(styleOf("feeler"), chord(LEFT)), "orbit");
  assert.equal(actionOf(styleOf("feeler"), chord(RIGHT)), "pan");
  assert.equal(actionOf(styleOf("blender"), chord(LEFT)), null);
  assert.equal(actionOf(styleOf("blender"), chord(MIDDLE)), "orbit");
  assert.equal(actionOf(styleOf("blender"), chord(MIDDLE, { shiftKey: true })), "pan");
  assert.equal(actionOf(styleOf("blender"), chord(MIDDLE, { ctrlKey: true })), "zoom");
  assert.equal(actionOf(styleOf("solidworks"), chord(MIDDLE, { ctrlKey: true })), "pan");
  assert.equal(actionOf(styleOf("solidworks"), chord(MIDDLE, { shiftKey: true })), "zoom");
  assert.equal(actionOf(styleOf("catia"), chord(MIDDLE)), "pan");
  assert.equal(actionOf(styleOf("catia"), chord(MIDDLE + LEFT)), "orbit");
  assert.equal(actionOf(styleOf("onshape"), chord(RIGHT)), "orbit");
  assert.equal(actionOf(styleOf("touchpad"), chord(LEFT, { shiftKey: true })), "pan");
});

test("a style that is not known is the own one", () => {
  assert.equal(styleOf("no such style").id, "feeler");
});
