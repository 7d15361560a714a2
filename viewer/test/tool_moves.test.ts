import assert from "node:assert/strict";
import { test } from "node:test";
import { beginTyping, chooseAxis, confirmTyping, typeFigure } from "../src/actions/typed-move";
import { Workbench } from "../src/actions/workbench";
import { type Drag, dragged, dragOf } from "../src/input/drag";
import { hitGizmo, layGizmo } from "../src/input/gizmo";
import {
  anglesOf,
  axis,
  fromAngles,
  IDENTITY,
  isSamePose,
  multiply,
  type Pose,
  position,
  rotation,
  translation,
} from "../src/math/matrix";
import type { Point, Vec3 } from "../src/math/vectors";
import type { Hand } from "../src/model/hand";
import { Store } from "../src/model/store";
import {
  directionOf,
  isFigureKey,
  poseOfTyped,
  startTyped,
  withAxis,
  withKey,
  wrongFigure,
} from "../src/model/typed-move";
import { CameraRig } from "../src/scene/camera";
import type { Stage } from "../src/scene/stage";
import { poseHint } from "../src/ui/typing-hint";

/** Looks along +y at the origin from 2 m away, z up, 800 x 600 pixels. */
function camera(): CameraRig {
  const rig = new CameraRig();
  Object.assign(rig, { position: [0, -2, 0], target: [0, 0, 0], up: [0, 0, 1], width: 800, height: 600 });
  return rig;
}

const plain = (value: number): number => value;
const near = (a: readonly number[], b: readonly number[], tolerance = 1e-9): void => {
  assert.equal(a.length, b.length);
  for (const [k, value] of a.entries())
    assert.ok(Math.abs(value - (b[k] ?? Number.NaN)) <= tolerance, `${a} is not ${b}`);
};
const move = (direction: Vec3 | null): Drag => ({ kind: "move", start: [...IDENTITY], center: [0, 0, 0], direction });
const turn = (direction: Vec3 | null): Drag => ({ ...move(direction), kind: "turn" });
const MIDDLE = { x: 400, y: 300 };

test("what is dragged in the view plane stays under the pointer", () => {
  const view = camera();
  const to = { x: 520, y: 210 };
  const pose = dragged(move(null), view, MIDDLE, to, plain);
  const seen = view.project(position(pose));
  near([seen.x, seen.y, seen.depth], [to.x, to.y, 2]);
});

test("along an axis it goes only there, as far as the pointer", () => {
  const view = camera();
  const pose = dragged(move([1, 0, 0]), view, MIDDLE, { x: 480, y: 100 }, plain);
  const [x, y, z] = position(pose);
  near([y, z], [0, 0]);
  assert.ok(Math.abs(view.project([x, 0, 0]).x - 480) < 12, "perspective aside, it is under the pointer");
});

test("along an axis that points at the eye it moves by the way up the picture", () => {
  const away = position(dragged(move([0, 1, 0]), camera(), MIDDLE, { x: 400, y: 250 }, plain));
  assert.ok(away[1] > 0.05 && Number.isFinite(away[1]), "up is away from the eye");
  near([away[0], away[2]], [0, 0]);
});

test("about an axis it turns by the angle about the middle, whichever way the axis points", () => {
  const [from, to] = [
    { x: 500, y: 300 },
    { x: 400, y: 200 },
  ];
  // A quarter turn against the clock in the picture: about the direction towards the eye, -y.
  near(dragged(turn(null), camera(), from, to, plain), rotation([0, -1, 0], Math.PI / 2));
  near(dragged(turn([0, -1, 0]), camera(), from, to, plain), rotation([0, -1, 0], Math.PI / 2));
  near(dragged(turn([0, 1, 0]), camera(), from, to, plain), rotation([0, 1, 0], -Math.PI / 2));
});

test("a turn leaves its centre where it is", () => {
  const drag: Drag = { kind: "turn", start: translation([0.3, 0, 0]), center: [0.1, 0, 0.2], direction: [0, 0, 1] };
  const pose = dragged(drag, camera(), { x: 500, y: 300 }, { x: 420, y: 350 }, plain);
  near(
    multiply(pose, [1, 0, 0, -0.2, 0, 1, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 1])
      .filter((_, k) => k % 4 === 3)
      .slice(0, 3),
    [0.1, 0, 0.2],
  );
});

test("steps round the way, not the place", () => {
  const snap = (value: number): number => Math.round(value / 0.05) * 0.05;
  const drag: Drag = { ...move([1, 0, 0]), start: translation([0.013, 0, 0]) };
  const [x] = position(dragged(drag, camera(), MIDDLE, { x: 470, y: 300 }, snap));
  assert.ok(Math.abs((x - 0.013) / 0.05 - Math.round((x - 0.013) / 0.05)) < 1e-9);
});

test("a typed movement goes along its axis by the figure", () => {
  let typed = startTyped("move", translation([1, 0, 0]), [1, 0, 0], "world");
  typed = withAxis(typed, 1);
  for (const key of ["2", "5", "-"]) typed = withKey(typed, key);
  assert.equal(typed.text, "-25");
  const view = { right: [1, 0, 0] as Vec3, towards: [0, -1, 0] as Vec3 };
  near(position(poseOfTyped(typed, "mm", view) ?? []), [1, -0.025, 0]);
  near(position(poseOfTyped(typed, "in", view) ?? []), [1, -0.635, 0]);
  typed = withKey(withKey(typed, "-"), "Backspace");
  assert.equal(typed.text, "2");
  assert.equal(poseOfTyped({ ...typed, text: "" }, "mm", view), null);
  assert.equal(poseOfTyped({ ...typed, text: "-" }, "mm", view), null);
});

test("the same axis again is that of the other frame", () => {
  const start = rotation([0, 0, 1], Math.PI / 2);
  const once = withAxis(startTyped("move", start, [0, 0, 0], "world"), 0);
  near(directionOf(once) ?? [], [1, 0, 0]);
  near(directionOf(withAxis(once, 0)) ?? [], [0, 1, 0]);
  near(directionOf(withAxis(withAxis(once, 0), 2)) ?? [], [0, 0, 1]);
  assert.equal(directionOf(startTyped("turn", start, [0, 0, 0], "tool")), null);
  assert.deepEqual(dragOf(once).direction, directionOf(once));
});

test("a typed turn is about the axis through the centre, in degrees", () => {
  const typed = { ...withAxis(startTyped("turn", translation([1, 0, 0]), [0, 0, 0], "world"), 2), text: "90" };
  near(position(poseOfTyped(typed, "mm", { right: [1, 0, 0], towards: [0, 0, 1] }) ?? []), [0, 1, 0]);
});

test("no sign of a typed figure is lost: it is read as in a field, or refused", () => {
  const view = { right: [1, 0, 0] as Vec3, towards: [0, -1, 0] as Vec3 };
  const typed = (text: string, kind: "move" | "turn" = "move") => {
    let move = withAxis(startTyped(kind, [...IDENTITY], [0, 0, 0], "world"), 1);
    for (const key of text) if (isFigureKey(move, key)) move = withKey(move, key);
    assert.equal(move.text, text);
    return move;
  };
  for (const [text, mm] of Object.entries({ "1 1/2": 1.5, "1e-1": 0.1, "3/8in": 9.525, "2 MM": 2, '1"': 25.4 })) {
    near(position(poseOfTyped(typed(text), "mm", view) ?? []), [0, mm / 1000, 0]);
    assert.equal(wrongFigure(typed(text), "mm"), "");
  }
  for (const text of ["2*3", "*3", "1.5.2", "1/0", "1 1", "5k", "-", "1e", "½"]) {
    assert.equal(poseOfTyped(typed(text), "mm", view), null, text);
    assert.equal(wrongFigure(typed(text), "mm"), `${text} is no length`);
  }
  assert.equal(wrongFigure(typed("90 rad", "turn"), "mm"), "");
  assert.equal(wrongFigure(typed("90 mm", "turn"), "mm"), "90 mm is no angle");
});

test("a text that is no figure moves nothing, and Enter says so", () => {
  const store = new Store();
  const start = [...IDENTITY] as Pose;
  const done: unknown[] = [];
  const hand = {
    ...{ pose: start, center: [0, 0, 0], isLocked: false },
    move: (pose: Pose) => done.push(pose[7]),
    put: () => done.push("put"),
  } as unknown as Hand;
  const stage = { camera: { right: [1, 0, 0], forward: [0, 1, 0] } } as unknown as Stage;
  const wb = new Workbench({
    ...{ store, stage, hand, link: null, redraw() {} },
    fetchFile: () => Promise.reject(new Error()),
  });
  beginTyping(wb, "move");
  chooseAxis(wb, 1);
  for (const key of "2*") assert.ok(typeFigure(wb, key));
  assert.deepEqual(done, [0, 0.002, 0]);
  confirmTyping(wb);
  assert.deepEqual([done.length, store.spoken.value, store.typed.value?.text], [3, "2* is no length", "2*"]);
  assert.equal(poseHint(store), "Move along Y (world): 2* is no length · Enter, Esc");
  typeFigure(wb, "Backspace");
  confirmTyping(wb);
  assert.deepEqual([done.slice(3), store.typed.value], [[0.002, "put"], null]);
});

test("letters of a unit count as figures only behind a digit", () => {
  const empty = startTyped("move", [...IDENTITY], [0, 0, 0], "world");
  assert.equal(isFigureKey(empty, "m"), false);
  assert.equal(isFigureKey({ ...empty, text: "3" }, "m"), true);
  assert.equal(isFigureKey({ ...empty, text: "3" }, "x"), false, "X stays an axis");
  assert.equal(isFigureKey(empty, "Backspace"), false);
});

test("the gizmo is as large in the picture whatever the distance", () => {
  for (const far of [-0.5, -2, -50]) {
    const view = camera();
    view.position = [0, far, 0];
    const arrow = layGizmo([0, 0, 0], [...IDENTITY], "world", view).find(
      (each) => each.kind === "move" && each.axis === 0,
    );
    const tip = arrow?.line[1];
    assert.ok(tip && Math.abs(tip.x - 400 - 62) < 1, `${tip?.x}`);
  }
});

test("each handle is hit where it is drawn, and nothing elsewhere", () => {
  const view = camera();
  view.position = [1.1, -1.5, 0.8];
  const handles = layGizmo([0, 0, 0], rotation([0, 0, 1], 0.4), "tool", view);
  assert.equal(handles.length, 7);
  for (const handle of handles) {
    const isHit = (at: Point): boolean => {
      const hit = hitGizmo(handles, at);
      return hit?.kind === handle.kind && hit.axis === handle.axis;
    };
    // Rings cross arrows and each other: there another handle may be the nearer one.
    const [most, count] = [handle.line.filter(isHit).length, handle.line.length];
    assert.ok(
      handle.kind === "turn" ? most > count / 2 : isHit(handle.line.at(-1) ?? MIDDLE),
      `${handle.kind} ${handle.axis}`,
    );
  }
  assert.equal(hitGizmo(handles, { x: 20, y: 20 }), null);
  assert.equal(hitGizmo([], MIDDLE), null);
});

test("an arrow that points at the eye is not offered, and nothing behind it", () => {
  const view = camera();
  const arrows = layGizmo([0, 0, 0], [...IDENTITY], "world", view).filter((each) => each.kind === "move");
  assert.deepEqual(arrows.map((each) => each.axis).sort(), [0, 2, null].sort());
  assert.deepEqual(layGizmo([0, -5, 0], [...IDENTITY], "world", view), []);
});

test("only the half of a ring that faces the eye is there", () => {
  const view = camera();
  view.position = [0, -2, 1];
  const ring = layGizmo([0, 0, 0], [...IDENTITY], "world", view).find(
    (each) => each.kind === "turn" && each.axis === 2,
  );
  const middle = view.project([0, 0, 0]);
  assert.ok(
    ring?.line.every((point) => point.y >= middle.y - 1),
    "in front of the middle, so below it in the picture",
  );
});

test("angles read back as the pose that they were read from", () => {
  for (const angles of [
    [0.3, -0.7, 2.1],
    [-3, 1.2, -0.4],
    [0, Math.PI / 2, 0.8],
    [0, -Math.PI / 2, 0],
  ] as Vec3[]) {
    const pose = fromAngles(angles, [1, 2, 3]);
    assert.ok(isSamePose(fromAngles(anglesOf(pose), position(pose)), pose, 1e-7), `${angles}`);
  }
  near(axis(fromAngles([0, 0, Math.PI / 2], [0, 0, 0]), 0), [0, 1, 0]);
});
