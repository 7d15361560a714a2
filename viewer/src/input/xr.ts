// VR by WebXR: the tool in the hand that holds the controller, the mock-up on a table or at full size.
//
//     trigger           grip while pressed: the touched parts, or the part that the ray hits
//     squeeze           the tool stays while the hand moves; the other hand's: the tool changes hands
//     thumbstick        tool's hand: turn, rise and sink; the other hand: walk
//     thumbstick press  the tool comes to the hand
//     A or X   contact mode      B or Y   undo

import {
  BufferGeometry,
  ConeGeometry,
  Float32BufferAttribute,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  type PerspectiveCamera,
  type WebGLRenderer,
} from "three";
import { outputsOf, type RumbleOutput } from "../feel/rumble";
import { axis, type Pose, position } from "../math/matrix";
import { add, normalize, scale, type Vec3 } from "../math/vectors";
import type { Hand } from "../model/hand";
import type { VrSize } from "../model/settings";
import { pressedAnew } from "./gamepad";
import { GripTie, type Placement, placed, type RoomMockup, type Stick, Walk, worldFromRoom, worldPose } from "./room";

/** A ray in the world. */
export interface WorldRay {
  readonly origin: Vec3;
  readonly direction: Vec3;
}

export type XrHand = Pick<Hand, "move" | "put" | "pose" | "pivot">;

export interface XrHost {
  readonly renderer: WebGLRenderer;
  /** The camera that draws; the session moves it, and its near and far planes are the session's meanwhile. */
  readonly eye: PerspectiveCamera;
  /** Holds the camera. It is moved as the viewer walks; its own parent's frame is the scene's. */
  readonly rig: Object3D;
  /** Takes the models of the controllers, in world coordinates. */
  readonly overlay: Object3D;
  readonly hand: XrHand;
  /** `middle`: the world point at the scene's origin. Null while nothing is loaded. */
  mockup(): (RoomMockup & { readonly middle: Vec3 }) | null;
  /** Draws a frame, for both eyes. */
  frame(now_ms: number): void;
  /** The trigger is pressed: grip the touched parts, or the part that the ray hits. */
  grip(ray: WorldRay): void;
  release(): void;
  command(command: "mode" | "undo"): void;
  /** The session is over; the camera is where the headset was. */
  ended(): void;
}

const STICK_BUTTON = 3;
const COMMANDS: Readonly<Record<number, "mode" | "undo">> = { 4: "mode", 5: "undo" };
const LONGEST_STEP_S = 0.05;
const RAY_LENGTH_M = 3;
/** Metres of the room, independent of the mock-up's scale: a tool may come close to the face, a hall has walls. */
const NEAR_M = 0.02;
const FAR_M = 200;
const MODEL_COLOR = 0x9ecbff;

/** WebXR's column by column as a pose row by row. */
export function poseOfColumns(columns: ArrayLike<number>): Pose {
  const pose: number[] = [];
  for (let row = 0; row < 4; row++)
    for (let column = 0; column < 4; column++) pose.push(columns[4 * column + row] ?? 0);
  return pose;
}

/** The stick of a controller: that of the thumb, else the touchpad's. */
export function stickOf(axes: readonly (number | null)[]): Stick {
  return axes.length >= 4 ? [axes[2] ?? 0, axes[3] ?? 0] : [axes[0] ?? 0, axes[1] ?? 0];
}

/**
 * Makes a projection for a depth buffer from 1 (near) to 0 (far): `z' = (w - z) / 2`.
 *
 * The headset gives projections to -1 (near) and 1 (far), which a renderer with a reversed depth buffer takes as they are.
 */
export function reverseDepth(columns: number[]): void {
  for (let column = 0; column < 4; column++) {
    const z = 4 * column + 2;
    columns[z] = ((columns[z + 1] ?? 0) - (columns[z] ?? 0)) / 2;
  }
}

/** Whether a headset is there. */
export async function hasHeadset(): Promise<boolean> {
  try {
    return (await navigator.xr?.isSessionSupported("immersive-vr")) ?? false;
  } catch {
    return false;
  }
}

export class XrRoom {
  /** In which hand the tool is. */
  tool_hand: XRHandedness = "right";

  private session: XRSession | null = null;
  private kind: VrSize = "table";
  private placement: Placement | null = null;
  private readonly walk = new Walk();
  private readonly tie = new GripTie();
  private isTied = false;
  private isClutched = false;
  private isGripping = false;
  private last_ms: number | null = null;
  private readonly held = new Map<XRInputSource, boolean[]>();
  private readonly models = new Map<XRInputSource, Group>();

  constructor(private readonly host: XrHost) {}

  get isPresenting(): boolean {
    return this.session !== null;
  }

  /** Opens the session; to be called in a user's gesture. Rejects where the browser or the headset refuses. */
  async enter(kind: VrSize = this.kind): Promise<void> {
    if (this.session) return;
    if (!navigator.xr) throw new Error("This browser has no WebXR: use that of the headset, or Chrome or Edge");
    const session = await navigator.xr.requestSession("immersive-vr", { requiredFeatures: ["local-floor"] });
    this.session = session;
    this.kind = kind;
    session.addEventListener("end", this.onEnd);
    session.addEventListener("selectstart", this.onSelectStart);
    session.addEventListener("selectend", this.onSelectEnd);
    session.addEventListener("squeezestart", this.onSqueezeStart);
    session.addEventListener("squeezeend", this.onSqueezeEnd);
    const { renderer } = this.host;
    renderer.xr.enabled = true;
    renderer.xr.setReferenceSpaceType("local-floor");
    try {
      await renderer.xr.setSession(session);
    } catch (error) {
      await session.end();
      throw error;
    }
    Object.assign(this.host.eye, { near: NEAR_M, far: FAR_M });
    renderer.setAnimationLoop(this.onFrame);
  }

  async leave(): Promise<void> {
    await this.session?.end();
  }

  /** Puts the mock-up anew before the viewer, on a table or at its size. */
  place(kind: VrSize): void {
    this.kind = kind;
    this.placement = null;
  }

  /** The motors of the hand that has the tool. */
  outputs(): RumbleOutput[] {
    const sources = [...(this.session?.inputSources ?? [])];
    return outputsOf(sources.filter((source) => this.isToolHand(source)).map((source) => source.gamepad));
  }

  private readonly onFrame = (now_ms: number, frame?: XRFrame): void => {
    const { renderer } = this.host;
    const space = renderer.xr.getReferenceSpace();
    if (!frame || !space || !this.session) return;
    const seconds = this.last_ms === null ? 0 : Math.min(LONGEST_STEP_S, Math.max(0, (now_ms - this.last_ms) / 1000));
    this.last_ms = now_ms;
    const viewer = frame.getViewerPose(space);
    const mockup = this.host.mockup();
    // A session behind the system's menu gives no poses of hands.
    if (viewer && mockup && this.session.visibilityState === "visible") {
      this.step(frame, space, poseOfColumns(viewer.transform.matrix), mockup, seconds, now_ms);
    }
    this.readyEyes();
    this.host.frame(now_ms);
  };

  private step(
    frame: XRFrame,
    space: XRReferenceSpace,
    room_from_viewer: Pose,
    mockup: RoomMockup & { readonly middle: Vec3 },
    seconds: number,
    now_ms: number,
  ): void {
    const sources = [...frame.session.inputSources];
    this.chooseHand(sources);
    if (!this.placement) {
      this.placement = placed(this.kind, mockup, room_from_viewer);
      this.isTied = false;
    }
    const stick = (isTool: boolean): Stick => {
      const pad = sources.find((source) => source.gamepad && this.isToolHand(source) === isTool)?.gamepad;
      return pad ? stickOf(pad.axes) : [0, 0];
    };
    const middle = scale(add(mockup.lower, mockup.upper), 0.5);
    const sticks = { tool: stick(true), other: stick(false) };
    this.placement = this.walk.step(this.placement, this.kind, sticks, room_from_viewer, middle, seconds);
    this.setRig(mockup.middle);
    for (const source of sources) {
      this.showModel(source, this.worldOf(frame, space, source.targetRaySpace));
      const grip = source.gripSpace && this.isToolHand(source) ? this.worldOf(frame, space, source.gripSpace) : null;
      if (grip) this.moveTool(grip, now_ms);
      this.readButtons(source);
    }
    for (const source of this.models.keys()) if (!sources.includes(source)) this.forget(source);
  }

  private isToolHand(source: XRInputSource): boolean {
    return source.handedness === this.tool_hand;
  }

  /** With one controller, the tool is in its hand. */
  private chooseHand(sources: readonly XRInputSource[]): void {
    const first = sources.find((source) => source.gripSpace);
    if (!first || sources.some((source) => source.gripSpace && this.isToolHand(source))) return;
    this.takeIn(first);
  }

  private takeIn(source: XRInputSource): void {
    this.tool_hand = source.handedness;
    this.isTied = false;
    this.isClutched = false;
  }

  private worldOf(frame: XRFrame, reference: XRReferenceSpace, space: XRSpace): Pose | null {
    const pose = this.placement && frame.getPose(space, reference);
    return this.placement && pose ? worldPose(this.placement, poseOfColumns(pose.transform.matrix)) : null;
  }

  private moveTool(world_from_grip: Pose, now_ms: number): void {
    const { hand } = this.host;
    const tool = hand.pose;
    if (!tool) return;
    if (this.isClutched) {
      this.tie.take(world_from_grip, tool);
      return;
    }
    if (!this.isTied) this.tie.recall(world_from_grip, tool, hand.pivot);
    this.isTied = true;
    hand.move(this.tie.wish(world_from_grip), "xr", now_ms);
  }

  private readButtons(source: XRInputSource): void {
    const now = (source.gamepad?.buttons ?? []).map((button) => button.pressed);
    const anew = pressedAnew(this.held.get(source) ?? now, now);
    this.held.set(source, now);
    for (const index of anew) {
      const command = COMMANDS[index];
      if (command) this.host.command(command);
      if (index !== STICK_BUTTON) continue;
      if (this.isToolHand(source)) this.isTied = false;
      else this.place(this.kind === "table" ? "real" : "table");
    }
  }

  private readonly onSelectStart = (event: XRInputSourceEvent): void => {
    const ray = this.rayOf(event);
    if (!ray || !this.isToolHand(event.inputSource)) return;
    this.isGripping = true;
    this.host.grip(ray);
  };

  private readonly onSelectEnd = (event: XRInputSourceEvent): void => {
    if (!this.isGripping || !this.isToolHand(event.inputSource)) return;
    this.isGripping = false;
    this.host.release();
  };

  private readonly onSqueezeStart = (event: XRInputSourceEvent): void => {
    if (!this.isToolHand(event.inputSource)) {
      if (!this.isGripping) this.takeIn(event.inputSource);
      return;
    }
    this.isClutched = true;
    this.host.hand.put();
  };

  private readonly onSqueezeEnd = (event: XRInputSourceEvent): void => {
    if (this.isToolHand(event.inputSource)) this.isClutched = false;
  };

  private rayOf(event: XRInputSourceEvent): WorldRay | null {
    const space = this.host.renderer.xr.getReferenceSpace();
    const world = space && this.worldOf(event.frame, space, event.inputSource.targetRaySpace);
    return world && { origin: position(world), direction: normalize(scale(axis(world, 2), -1)) };
  }

  private setRig(middle: Vec3): void {
    if (!this.placement) return;
    const { rig } = this.host;
    const [a, b, c, x, d, e, f, y, g, h, i, z] = worldFromRoom(this.placement) as [
      ...[number, number, number, number],
      ...[number, number, number, number],
      ...[number, number, number, number],
    ];
    rig.matrixAutoUpdate = false;
    rig.matrix.set(a, b, c, x - middle[0], d, e, f, y - middle[1], g, h, i, z - middle[2], 0, 0, 0, 1);
    rig.matrixWorldNeedsUpdate = true;
    rig.updateMatrixWorld(true);
  }

  /** Suits the eyes' projections to the renderer's depth buffer. */
  private readyEyes(): void {
    const { renderer } = this.host;
    if (!renderer.state.buffers.depth.getReversed()) return;
    const eyes = renderer.xr.getCamera();
    for (const eye of [eyes, ...eyes.cameras] as PerspectiveCamera[]) {
      // Without the mark the renderer computes the projection anew, as for a camera that is not a headset's.
      Reflect.set(eye, "_reversedDepth", true);
      if (eye === (eyes as object)) continue;
      reverseDepth(eye.projectionMatrix.elements);
      eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert();
    }
  }

  private showModel(source: XRInputSource, world_from_ray: Pose | null): void {
    let model = this.models.get(source);
    if (!model) {
      model = controllerModel();
      this.models.set(source, model);
      this.host.overlay.add(model);
    }
    model.visible = world_from_ray !== null;
    if (!world_from_ray || !this.placement) return;
    const origin = position(world_from_ray);
    const size = 1 / this.placement.scale;
    const [x, y, z] = [0, 1, 2].map((k) => scale(axis(world_from_ray, k), size)) as [Vec3, Vec3, Vec3];
    model.matrix.set(x[0], y[0], z[0], origin[0], x[1], y[1], z[1], origin[1], x[2], y[2], z[2], origin[2], 0, 0, 0, 1);
    model.matrixWorldNeedsUpdate = true;
  }

  private forget(source: XRInputSource): void {
    const model = this.models.get(source);
    if (model) dispose(model);
    this.models.delete(source);
    this.held.delete(source);
  }

  private readonly onEnd = (): void => {
    const { renderer, rig, hand } = this.host;
    renderer.setAnimationLoop(null);
    renderer.xr.enabled = false;
    for (const source of [...this.models.keys()]) this.forget(source);
    this.held.clear();
    // The rig's own position, turn and scale were never touched.
    rig.matrixAutoUpdate = true;
    rig.updateMatrixWorld(true);
    if (this.isGripping) this.host.release();
    hand.put();
    this.session = null;
    this.placement = null;
    this.isTied = false;
    this.isClutched = false;
    this.isGripping = false;
    this.last_ms = null;
    this.host.ended();
  };
}

/** A cone at the hand and a ray, along -z. */
function controllerModel(): Group {
  const model = new Group();
  model.matrixAutoUpdate = false;
  const cone = new Mesh(new ConeGeometry(0.012, 0.08, 16), new MeshBasicMaterial({ color: MODEL_COLOR }));
  cone.rotation.x = -Math.PI / 2;
  const line = new BufferGeometry();
  line.setAttribute("position", new Float32BufferAttribute([0, 0, -0.04, 0, 0, -RAY_LENGTH_M], 3));
  model.add(cone, new Line(line, new LineBasicMaterial({ color: MODEL_COLOR, transparent: true, opacity: 0.5 })));
  return model;
}

function dispose(model: Group): void {
  model.removeFromParent();
  for (const child of model.children as (
    | Mesh<BufferGeometry, MeshBasicMaterial>
    | Line<BufferGeometry, LineBasicMaterial>
  )[]) {
    child.geometry.dispose();
    child.material.dispose();
  }
}
