import assert from "node:assert/strict";
import { test } from "node:test";
import { cutMiddle, type Figure, layOut, MOST_TEXT_PX } from "../src/scene/labels";

const SIZE = { width: 60, height: 18 };

test("figures of one place do not cover one another, and stay in the picture", () => {
  const figures: Figure[] = [200, 204, 210, 196, 2, 398].map((x, k) => ({ x, y: k === 4 ? 3 : 100, ...SIZE }));
  const places = layOut(figures, 400, 300);
  const found = places.filter((place) => place !== null);
  assert.equal(found.length, figures.length);
  found.forEach((a, k) => {
    assert.ok(a.left >= 0 && a.top >= 0 && a.left + 60 <= 400 && a.top + 18 <= 300);
    for (const b of found.slice(k + 1)) {
      assert.ok(Math.abs(a.left - b.left) >= 60 || Math.abs(a.top - b.top) >= 18, "two figures overlap");
    }
  });
});

test("the first has the first choice", () => {
  const alone = layOut([{ x: 100, y: 100, ...SIZE }], 400, 300)[0];
  const crowd = layOut(
    Array.from({ length: 5 }, () => ({ x: 100, y: 100, ...SIZE })),
    400,
    300,
  );
  assert.deepEqual(crowd[0], alone);
});

test("a figure whose point is out of the picture is left out, as is one without room", () => {
  assert.deepEqual(
    layOut(
      [
        { x: -1, y: 50, ...SIZE },
        { x: 50, y: 301, ...SIZE },
      ],
      400,
      300,
    ),
    [null, null],
  );
  const crowd = layOut(
    Array.from({ length: 20 }, () => ({ x: 100, y: 150, ...SIZE })),
    400,
    300,
  );
  assert.ok(crowd.filter((place) => place !== null).length >= 12);
  const tight = layOut(
    Array.from({ length: 20 }, () => ({ x: 60, y: 30, ...SIZE })),
    140,
    60,
  );
  assert.ok(tight.filter((place) => place !== null).length < 6);
});

test("labels keep clear of what lies over the picture, and of the tool where there is room", () => {
  const gizmo = { left: 40, top: 40, right: 200, bottom: 160 };
  const overlaps = (place: { left: number; top: number } | null, area: typeof gizmo) =>
    place !== null &&
    place.left < area.right &&
    place.left + SIZE.width > area.left &&
    place.top < area.bottom &&
    place.top + SIZE.height > area.top;
  const figures = Array.from({ length: 6 }, (_, k) => ({ x: 100 + 4 * k, y: 100, ...SIZE }));
  for (const place of layOut(figures, 400, 300, { always: [gizmo], better: [] })) {
    assert.ok(place && !overlaps(place, gizmo));
  }
  for (const place of layOut(figures, 400, 300, { always: [], better: [gizmo] })) {
    assert.ok(place && !overlaps(place, gizmo));
  }
  const all = { left: 0, top: 0, right: 400, bottom: 300 };
  assert.ok(layOut(figures, 400, 300, { always: [], better: [all] }).every((place) => place !== null));
  assert.ok(layOut(figures, 400, 300, { always: [all], better: [] }).every((place) => place === null));
});

test("a label stays where it was to its point while that place is free", () => {
  const [first] = layOut([{ x: 100, y: 100, ...SIZE }], 400, 300);
  assert.ok(first);
  const before = { dx: 40, dy: 30 };
  const [again] = layOut([{ x: 110, y: 104, ...SIZE, before }], 400, 300);
  assert.deepEqual(again, { left: 150, top: 134 });
});

test("a wide name is cut in the middle by its width, and keeps both ends", () => {
  const widthOf = (text: string): number => Array.from(text).reduce((sum, each) => sum + (each === "W" ? 13.5 : 6), 0);
  const wide = cutMiddle("W".repeat(40), MOST_TEXT_PX, widthOf);
  assert.equal(wide, `${"W".repeat(9)}…${"W".repeat(8)}`);
  assert.ok(widthOf(wide) <= MOST_TEXT_PX && widthOf(`${wide}W`) > MOST_TEXT_PX);
  const narrow = "i".repeat(40);
  assert.equal(cutMiddle(narrow, MOST_TEXT_PX, widthOf), narrow, "as many letters, and they fit");
  assert.match(cutMiddle(`0.42 mm to ${"W".repeat(200)}_12`, MOST_TEXT_PX, widthOf), /^0\.42 mm to W*…W*_12$/);
  assert.equal(cutMiddle("🙂".repeat(60), 61, widthOf), "🙂🙂🙂🙂🙂…🙂🙂🙂🙂", "a letter stays whole");
  assert.equal(cutMiddle("WWW", 1, widthOf), "…");
});
