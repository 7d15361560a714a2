// The pointer on the picture: turns, moves and zooms the view, selects, drags the tool. Styles assign the buttons.

import { draggableBy, moverOf } from "../actions/joints";
import { clickMeasure, hoverMeasure } from "../actions/measures";
import { cutAlongFace, draftFace, draftSection, settleBox, settleSection } from "../actions/sections";
import { cancelTyping, confirmTyping } from "../actions/typed-move";
import type { Workbench } from "../actions/workbench";
import type { Source } from "../link/protocol";
import { isUpper } from "../math/box-faces";
import type { Pose } from "../math/matrix";
import { alongAxis } from "../math/pointing";
import { type Point, subtract, type Vec3 } from "../math/vectors";
import { axisNow, beginDrag, type JointDrag } from "../model/joints";
import { actionOf, type CameraAction, LEFT, styleOf } from "../model/navigation";
import type { Area } from "../scene/labels";
import { type CutHandle, faceOf, hitCut, layCuts } from "./cuts";
import { type Drag, dragged, dragOf, type Snap } from "./drag";
import { type Handle, hitGizmo, layGizmo, shifted } from "./gizmo";
import { areaOf, type GizmoPlace, hullOf, isInPicture, placeGizmo, pointsOf } from "./gizmo-place";

/** A press that moves less is a click. */
const CLICK_PX = 4;
/** Half a turn of the view is as many pixels as the picture is high. */
const HALF_TURN_RAD = Math.PI;
const ZOOM_PER_PX = 0.0015;
const ZOOM_PER_DRAGGED_PX = 0.006;
/** One line and one page of a wheel that does not count in pixels. */
const WHEEL_PX = [1, 32, 400] as const;
/** While the wheel turns and the pointer rests, it zooms to the same point. */
const WHEEL_REST_MS = 300;
const FINE = 0.1;
/** A finger that rests so long opens the menu. */
const LONG_PRESS_MS = 500;

type Gesture =
  | { readonly kind: "camera"; buttons: number; action: CameraAction | null; pivot: Vec3; last: Point }
  | { readonly kind: "joint"; readonly name: string; readonly value: number; readonly drag: JointDrag }
  | { readonly kind: "cut"; readonly cut: CutHandle; readonly from: Point; to: Point; last: Point }
  | {
      readonly kind: "tool";
      readonly drag: Drag;
      readonly source: Source;
      readonly from: Point;
      to: Point;
      last: Point;
    };

export class Pointer {
  /** Where the pointer is; null while it is elsewhere. */
  at: Point | null = null;
  /** The handle under it, or being dragged. */
  handle: Handle | null = null;
  /** The cut whose arrow is under it, or being dragged; null: none. */
  cut: number | null = null;
  /** What lies over the picture: the gizmo stands elsewhere. */
  taken: () => readonly Area[] = () => [];
  /** How far the gizmo stands from the point that it moves. */
  place_of_gizmo: GizmoPlace = { dx: 0, dy: 0, way: null };
  private laid: readonly Handle[] = [];
  private laid_for = "";
  private laid_beside: readonly Area[] = [];
  private gesture: Gesture | null = null;
  private pressed: { at: Point; button: number; time_ms: number } | null = null;
  private readonly touches = new Map<number, Point>();
  private typed_from: Point | null = null;
  private wheel: { at: Point; time_ms: number; point: Vec3 } | null = null;
  private is_hover_due = false;
  private is_joint_moving = false;
  private long_press: ReturnType<typeof setTimeout> | null = null;

  constructor(
    private readonly wb: Workbench,
    private readonly canvas: HTMLElement,
  ) {
    const on = <K extends keyof HTMLElementEventMap>(name: K, run: (event: HTMLElementEventMap[K]) => void): void =>
      canvas.addEventListener(name, run as EventListener, { passive: false });
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.up(event));
    on("pointercancel", (event) => this.end(event));
    on("pointerleave", () => this.leave());
    on("wheel", (event) => this.turnWheel(event));
    on("dblclick", (event) => this.center(event));
    on("contextmenu", (event) => event.preventDefault());
    on("auxclick", (event) => event.preventDefault());
  }

  /** The handles of the held mesh, at their present places in the picture. */
  handles(): readonly Handle[] {
    const { hand, store, stage } = this.wb;
    const { pose, center } = hand;
    if (!pose || !center || hand.isLocked || !store.has_hand.peek()) return [];
    const { camera } = stage;
    const isDragged = this.gesture?.kind === "tool";
    const { position, up, width, height, isParallel, target } = camera;
    const { frame } = store.settings.peek();
    const key = [...pose, ...position, ...target, ...up, width, height, isParallel, frame, isDragged].join();
    // Asked for by the painter, the labels and the pointer: laid out once.
    if (key !== this.laid_for || this.taken() !== this.laid_beside) {
      this.laid_for = key;
      this.laid_beside = this.taken();
      this.laid = this.layHandles(pose, center, isDragged);
    }
    return this.laid;
  }

  private layHandles(pose: Pose, center: Vec3, isDragged: boolean): readonly Handle[] {
    const { store, stage } = this.wb;
    const { camera } = stage;
    const tool = pointsOf(stage.heldCorners(pose), camera);
    if (!isDragged && tool.length > 0 && !isInPicture(areaOf(tool), camera.width, camera.height)) return [];
    const handles = layGizmo(center, pose, store.settings.peek().frame, camera);
    const middle = handles[0]?.line[0];
    if (!middle) return [];
    // What is dragged goes with the hand, wherever that is.
    if (!isDragged)
      this.place_of_gizmo = placeGizmo(middle, hullOf(tool), camera, this.taken(), this.place_of_gizmo.way);
    return shifted(handles, this.place_of_gizmo.dx, this.place_of_gizmo.dy);
  }

  /** Where the tool lies in the picture, if it is out of it; null: it is in sight, or the hand is empty. */
  outOfSight(): Point | null {
    const { hand, store, stage } = this.wb;
    const { pose, center } = hand;
    if (!pose || !center || !store.has_hand.peek() || !store.manifest.peek()) return null;
    const { camera } = stage;
    if (isInPicture(areaOf(pointsOf(stage.heldCorners(pose), camera)), camera.width, camera.height)) return null;
    const { x, y, isAhead } = camera.project(center);
    // Behind the eye: the shorter turn is to the other side.
    return isAhead ? { x, y } : { x: camera.width - x, y: camera.height - y };
  }

  /** The arrows of the cuts, as they lie in the picture now. */
  cuts(): CutHandle[] {
    const { store, stage } = this.wb;
    const manifest = store.manifest.peek();
    if (!manifest || !store.can_look.peek()) return [];
    return layCuts(store.drawn_sections.peek(), manifest, stage.camera, store.drawn_box.peek());
  }

  /** The pick under the pointer, at most once a frame and only while the view rests. */
  frame(): void {
    if (!this.is_hover_due || this.gesture || !this.at || this.wb.stage.camera.isGliding) return;
    this.is_hover_due = false;
    const { store, stage } = this.wb;
    const picked = stage.pick(this.at.x, this.at.y);
    store.hover.value = picked && !picked.held ? picked.part : -1;
    store.pointed.value = picked?.point ?? null;
    hoverMeasure(this.wb, this.at);
  }

  private down(event: PointerEvent): void {
    const { wb } = this;
    const at = this.place(event);
    this.wb.stage.camera.finish();
    this.canvas.focus({ preventScroll: true });
    wb.store.menu.value = null;
    wb.store.is_typing_refused.value = false;
    if (wb.store.typed.peek()) {
      if (event.button === 0) confirmTyping(wb);
      else cancelTyping(wb);
      this.typed_from = null;
      return;
    }
    this.canvas.setPointerCapture(event.pointerId);
    if (event.pointerType === "touch") {
      this.touches.set(event.pointerId, at);
      this.awaitLongPress(event, at);
      if (this.touches.size > 1) {
        this.gesture = null;
        this.pressed = null;
        return;
      }
    }
    this.pressed = { at, button: event.button, time_ms: event.timeStamp };
    this.is_joint_moving = false;
    this.gesture = this.grab(event, at) ?? this.steer(event, at);
    if (event.button === 1) event.preventDefault();
  }

  /** The gesture that begins on the gizmo, on a cut's arrow or on the held mesh; null elsewhere. */
  private grab(event: PointerEvent, at: Point): Gesture | null {
    const { hand, stage, store } = this.wb;
    const { pose, center } = hand;
    if (event.buttons !== LEFT || event.altKey) return null;
    this.handle = hitGizmo(this.handles(), at);
    const cut = this.handle ? null : hitCut(this.cuts(), at);
    this.cut = cut?.id ?? null;
    if (cut) return { kind: "cut", cut, from: at, to: at, last: at };
    if (store.people.is_barred.peek() && stage.pick(at.x, at.y)?.held) store.people.tried();
    if (!pose || !center || hand.isLocked) return this.handle ? null : this.grabJoint(at);
    if (this.handle) {
      const { kind, direction } = this.handle;
      const { dx, dy } = this.place_of_gizmo;
      // As if the gizmo were where it moves the tool.
      const from = { x: at.x - dx, y: at.y - dy };
      return {
        kind: "tool",
        drag: { kind, start: pose, center, direction },
        source: "gizmo",
        from,
        to: from,
        last: at,
      };
    }
    if (store.measuring.peek()) return null;
    const picked = stage.pick(at.x, at.y);
    if (!picked?.held) return this.grabJoint(at);
    const drag: Drag = { kind: "move", start: pose, center: picked.point, direction: null };
    return { kind: "tool", drag, source: "mouse", from: at, to: at, last: at };
  }

  /** The gesture that moves the part under the pointer by its joint; null: it has none. */
  private grabJoint(at: Point): Gesture | null {
    const { stage, store } = this.wb;
    const mechanism = this.wb.document?.mechanism;
    if (!mechanism || store.measuring.peek() || store.is_picking_face.peek()) return null;
    const picked = stage.pick(at.x, at.y);
    const number = picked && !picked.held ? draggableBy(this.wb, picked.part) : null;
    if (!picked || !number) return null;
    const drag = beginDrag(number.kind, axisNow(mechanism, number), picked.point, stage.camera, at);
    return { kind: "joint", name: number.name, value: mechanism.values[number.name] ?? 0, drag };
  }

  private steer(event: PointerEvent, at: Point): Gesture {
    const chord = event.pointerType === "touch" ? { ...keysOf(event), buttons: LEFT } : keysOf(event);
    const style = styleOf(this.wb.store.settings.peek().style);
    const action = event.pointerType === "touch" ? "orbit" : actionOf(style, chord);
    return { kind: "camera", buttons: event.buttons, action, pivot: this.wb.pointAt(at.x, at.y), last: at };
  }

  private move(event: PointerEvent): void {
    const at = this.place(event);
    if (this.touches.size > 1 && this.touches.has(event.pointerId)) {
      this.pinch(event.pointerId, at);
      return;
    }
    if (this.wb.store.typed.peek()) {
      this.followTyped(event, at);
      return;
    }
    this.typed_from = null;
    const { gesture } = this;
    if (!gesture) {
      this.hover(at);
      return;
    }
    if (this.isClick(at)) return;
    if (gesture.kind === "tool") this.dragTool(gesture, event, at);
    else if (gesture.kind === "joint") this.dragJoint(gesture, at);
    else if (gesture.kind === "cut") this.dragCut(gesture, event, at);
    else {
      if (event.buttons !== gesture.buttons) {
        // Another button joined or left: the chord may mean something else from here on.
        gesture.buttons = event.buttons;
        gesture.action = actionOf(styleOf(this.wb.store.settings.peek().style), keysOf(event));
        gesture.last = at;
      }
      this.moveCamera(gesture, at);
    }
  }

  private hover(at: Point): void {
    const before = this.handle;
    this.handle = hitGizmo(this.handles(), at);
    this.cut = this.handle ? null : (hitCut(this.cuts(), at)?.id ?? null);
    this.is_hover_due = true;
    this.canvas.style.cursor = this.handle || this.cut !== null ? "grab" : "";
    if (before !== this.handle || !this.wb.stage.camera.moved) this.wb.redraw();
  }

  private moveCamera(gesture: Extract<Gesture, { kind: "camera" }>, at: Point): void {
    const { camera } = this.wb.stage;
    const [dx, dy] = [at.x - gesture.last.x, at.y - gesture.last.y];
    gesture.last = at;
    const turn = HALF_TURN_RAD / Math.max(camera.height, 1);
    if (gesture.action === "orbit") camera.orbit(dx * turn, dy * turn, gesture.pivot);
    else if (gesture.action === "pan") camera.pan(dx, dy, camera.project(gesture.pivot).depth);
    else if (gesture.action === "zoom") camera.dolly(Math.exp(dy * ZOOM_PER_DRAGGED_PX), gesture.pivot);
    else return;
    this.wb.redraw();
  }

  /** The cut follows in the picture at once; the server gets it at the end. */
  private dragCut(gesture: Extract<Gesture, { kind: "cut" }>, event: PointerEvent, at: Point): void {
    goOn(gesture, event, at);
    const { center, id, normal, offset } = gesture.cut;
    const face = faceOf(gesture.cut);
    const box = this.wb.store.drawn_box.peek();
    if (face !== null && box) {
      const by = alongAxis(center, normal, this.wb.stage.camera, gesture.from, gesture.to);
      const sense = isUpper(face) ? -1 : 1;
      draftFace(this.wb, box, face, sense * (offset + this.snap(event)(by, "length")));
      return;
    }
    const section = this.wb.document?.sections.find((each) => each.id === id);
    if (!section) return;
    const by = alongAxis(center, normal, this.wb.stage.camera, gesture.from, gesture.to);
    draftSection(this.wb, section, offset + this.snap(event)(by, "length"));
  }

  /** The part goes with the pointer as far as contact lets it; after Esc it stays where it was. */
  private dragJoint({ name, value, drag }: Extract<Gesture, { kind: "joint" }>, at: Point): void {
    const mover = moverOf(this.wb);
    const by = drag.by(this.wb.stage.camera, at);
    if (this.is_joint_moving && mover.name === null) return;
    mover.to(name, value + by);
    this.is_joint_moving = true;
    this.wb.redraw();
  }

  private dragTool(gesture: Extract<Gesture, { kind: "tool" }>, event: PointerEvent, at: Point): void {
    goOn(gesture, event, at);
    const pose = dragged(gesture.drag, this.wb.stage.camera, gesture.from, gesture.to, this.snap(event));
    this.wb.hand.move(pose, gesture.source, event.timeStamp);
  }

  private followTyped(event: PointerEvent, at: Point): void {
    const move = this.wb.store.typed.peek();
    this.typed_from ??= at;
    if (move?.text !== "") return;
    const pose = dragged(dragOf(move), this.wb.stage.camera, this.typed_from, at, this.snap(event));
    this.wb.hand.move(pose, "mouse", event.timeStamp);
  }

  /** Steps if snapping is on; Ctrl inverts that. */
  private snap(event: PointerEvent): Snap {
    const { is_snapping, step_m, step_rad } = this.wb.store.settings.peek();
    if (is_snapping === event.ctrlKey) return (value) => value;
    return (value, kind) => {
      const step = kind === "length" ? step_m : step_rad;
      return Math.round(value / step) * step;
    };
  }

  private up(event: PointerEvent): void {
    const at = this.place(event);
    const { gesture, pressed } = this;
    this.forgetLongPress();
    if (event.pointerType === "touch") this.touches.delete(event.pointerId);
    if (pressed && this.isClick(at)) this.click(event, at, pressed.button);
    else this.settle(gesture);
    this.end(event);
  }

  /** The dragged thing stays where it is. */
  private settle(gesture: Gesture | null): void {
    if (gesture?.kind === "tool") this.wb.hand.put();
    else if (gesture?.kind === "joint") moverOf(this.wb).settle();
    else if (gesture?.kind === "cut") void (faceOf(gesture.cut) === null ? settleSection(this.wb) : settleBox(this.wb));
  }

  private end(event: PointerEvent): void {
    this.forgetLongPress();
    this.touches.delete(event.pointerId);
    if (event.type === "pointercancel") this.settle(this.gesture);
    this.gesture = null;
    this.pressed = null;
    this.is_hover_due = true;
    this.wb.redraw();
  }

  private leave(): void {
    this.at = null;
    this.wb.store.hover.value = -1;
    this.wb.store.pointed.value = null;
    if (!this.gesture) this.handle = this.cut = null;
    this.wb.redraw();
  }

  /** One finger that stays where it is opens the menu, as the right button does. */
  private awaitLongPress(event: PointerEvent, at: Point): void {
    this.forgetLongPress();
    if (this.touches.size > 1) return;
    const { clientX, clientY } = event;
    this.long_press = setTimeout(() => {
      this.long_press = null;
      if (this.touches.size !== 1 || !this.pressed || !this.isClick(this.at ?? at)) return;
      // Neither a click nor a drag any more.
      this.pressed = null;
      this.gesture = null;
      this.openMenu({ clientX, clientY }, at);
    }, LONG_PRESS_MS);
  }

  private forgetLongPress(): void {
    if (this.long_press !== null) clearTimeout(this.long_press);
    this.long_press = null;
  }

  private openMenu({ clientX, clientY }: Pick<PointerEvent, "clientX" | "clientY">, at: Point): void {
    const { store, stage } = this.wb;
    const picked = stage.pick(at.x, at.y);
    const part = picked && !picked.held ? picked.part : -1;
    if (part >= 0 && !store.selection.peek().has(part)) this.wb.select([part]);
    store.menu.value = { x: clientX, y: clientY, part, point: picked?.point ?? null, at };
  }

  private click(event: PointerEvent, at: Point, button: number): void {
    const { wb } = this;
    const picked = wb.stage.pick(at.x, at.y);
    if (button === 2) this.openMenu(event, at);
    else if (button === 0 && wb.store.is_picking_face.peek()) void cutAlongFace(wb, at);
    else if (button === 0 && wb.store.measuring.peek()) clickMeasure(wb, at);
    else if (button === 0 && !this.handle && this.cut === null) {
      const isAdding = event.ctrlKey || event.metaKey || event.shiftKey;
      if (picked?.held === false) wb.select([picked.part], isAdding ? "toggle" : "only");
      else if (!isAdding && !picked) wb.select([]);
    }
  }

  private center(event: MouseEvent): void {
    const at = this.place(event);
    const picked = this.wb.stage.pick(at.x, at.y);
    if (!picked || this.wb.store.measuring.peek()) return;
    this.wb.look((camera) => camera.translate(subtract(picked.point, camera.target)));
  }

  private turnWheel(event: WheelEvent): void {
    event.preventDefault();
    const { camera } = this.wb.stage;
    const at = this.place(event);
    const style = styleOf(this.wb.store.settings.peek().style);
    const unit = WHEEL_PX[event.deltaMode as 0 | 1 | 2] ?? 1;
    const anchor = this.wheelPoint(at, event.timeStamp);
    if (style.wheel === "pan" && !event.ctrlKey) {
      camera.pan(-event.deltaX * unit, -event.deltaY * unit, camera.project(anchor).depth);
    } else {
      // A pinch comes as small steps with Ctrl.
      const pixels = event.deltaY * unit * (event.ctrlKey ? 6 : style.wheel_sense);
      camera.dolly(Math.exp(Math.max(-300, Math.min(300, pixels)) * ZOOM_PER_PX), anchor);
    }
    this.wb.redraw();
  }

  private wheelPoint(at: Point, time_ms: number): Vec3 {
    const last = this.wheel;
    const isMoving = !last || time_ms - last.time_ms > WHEEL_REST_MS || !isNear(last.at, at);
    const point = isMoving ? this.wb.pointAt(at.x, at.y) : last.point;
    this.wheel = { at, time_ms, point };
    return point;
  }

  /** Two fingers: their middle moves the view, their distance zooms. */
  private pinch(id: number, at: Point): void {
    const other = [...this.touches].find(([key]) => key !== id)?.[1];
    const before = this.touches.get(id);
    this.touches.set(id, at);
    if (!other || !before) return;
    const { camera } = this.wb.stage;
    const spread = (a: Point): number => Math.max(Math.hypot(a.x - other.x, a.y - other.y), 1);
    camera.pan((at.x - before.x) / 2, (at.y - before.y) / 2, camera.reach);
    camera.dolly(spread(before) / spread(at), this.wb.pointAt((at.x + other.x) / 2, (at.y + other.y) / 2));
    this.wb.redraw();
  }

  private isClick(at: Point): boolean {
    if (this.pressed && !isNear(this.pressed.at, at)) this.pressed = { ...this.pressed, at: FAR };
    return this.pressed !== null && this.pressed.at !== FAR;
  }

  private place(event: MouseEvent): Point {
    const box = this.canvas.getBoundingClientRect();
    this.at = { x: event.clientX - box.left, y: event.clientY - box.top };
    return this.at;
  }
}

/** The pointer moves; with Shift the dragged thing follows finely. */
function goOn(drag: { to: Point; last: Point }, event: PointerEvent, at: Point): void {
  const factor = event.shiftKey ? FINE : 1;
  drag.to = { x: drag.to.x + factor * (at.x - drag.last.x), y: drag.to.y + factor * (at.y - drag.last.y) };
  drag.last = at;
}

const FAR: Point = { x: Number.POSITIVE_INFINITY, y: Number.POSITIVE_INFINITY };
const isNear = (a: Point, b: Point): boolean => Math.hypot(a.x - b.x, a.y - b.y) < CLICK_PX;

const keysOf = (event: PointerEvent) => ({
  buttons: event.buttons,
  shiftKey: event.shiftKey,
  ctrlKey: event.ctrlKey || event.metaKey,
  altKey: event.altKey,
});
