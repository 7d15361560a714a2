// The mock-up in the room of a VR session: its place, its scale, and the effect of the thumbsticks. Numbers only.
//
// The room's frame is WebXR's: metres, y up, the floor at 0. A placement takes the world into the room by a turn, a
// shift and one scale for all axes, so that a rigid pose of a controller stays a rigid pose in the world.

import type { UpAxis } from "../link/protocol";
import {
  axis,
  fromAxes,
  IDENTITY,
  invert,
  multiply,
  type Pose,
  position,
  rotation,
  translation,
  turn,
} from "../math/matrix";
import { add, normalize, scale, subtract, type Vec3 } from "../math/vectors";
import type { VrSize } from "../model/settings";

export interface Placement {
  /** Metres in the room of one metre of the mock-up. */
  readonly scale: number;
  /** `x_room = pose * (scale * x_world)`. */
  readonly pose: Pose;
}

export interface RoomMockup {
  readonly lower: Vec3;
  readonly upper: Vec3;
  readonly up: UpAxis;
}

/** A thumbstick: right and towards the user, from -1 to 1, as WebXR has it. */
export type Stick = readonly [number, number];

const UP: Vec3 = [0, 1, 0];
const TABLE_SIZE_M = 0.8;
const TABLE_HEIGHT_M = 0.75;
const TABLE_DISTANCE_M = 0.7;
/** A mock-up smaller than twice this floats at the height of the chest; a larger one stands on the floor. */
const CHEST_M = 1.1;
const REAL_DISTANCE_M = 0.5;

const STICK_DEAD_ZONE = 0.15;
const WALK_M_PER_S = 1;
const SPIN_RAD_PER_S = 1.2;
/** At full size the view turns in steps: a smooth turn makes people sick. */
const SNAP_RAD = Math.PI / 6;
const SNAP_AT = 0.6;
const SNAP_AGAIN_AT = 0.3;

/** The turn that brings the mock-up's up axis to the room's. */
export function upright(up: UpAxis): Pose {
  if (up === "z") return rotation([1, 0, 0], -Math.PI / 2);
  if (up === "x") return rotation([0, 0, 1], Math.PI / 2);
  return [...IDENTITY];
}

/** Where the viewer looks, level with the floor. Straight down or up, the top of the head tells it. */
export function heading(room_from_viewer: ArrayLike<number>): Vec3 {
  const [x, y, z] = scale(axis(room_from_viewer, 2), -1);
  if (Math.hypot(x, z) > 0.1) return normalize([x, 0, z]);
  const [tx, , tz] = axis(room_from_viewer, 1);
  const sign = y > 0 ? -1 : 1;
  return normalize([sign * tx, 0, sign * tz], [0, 0, -1]);
}

/** Puts the mock-up before the viewer, its front towards them. */
export function placed(kind: VrSize, mockup: RoomMockup, room_from_viewer: ArrayLike<number>): Placement {
  const standing = upright(mockup.up);
  const size = turn(standing, subtract(mockup.upper, mockup.lower)).map(Math.abs) as Vec3;
  const middle = turn(standing, scale(add(mockup.lower, mockup.upper), 0.5));
  const largest = Math.max(...size, 1e-6);
  const by = kind === "table" ? TABLE_SIZE_M / largest : 1;
  const bottom: Vec3 = [middle[0] * by, (middle[1] - size[1] / 2) * by, middle[2] * by];
  const forward = heading(room_from_viewer);
  const distance = kind === "table" ? TABLE_DISTANCE_M : REAL_DISTANCE_M + size[2] / 2;
  const height = kind === "table" ? TABLE_HEIGHT_M : Math.max(0, CHEST_M - size[1] / 2);
  const viewer = position(room_from_viewer);
  const foot: Vec3 = [viewer[0] + forward[0] * distance, height, viewer[2] + forward[2] * distance];
  // The mock-up's front looks along z; turned so, it looks at the viewer.
  const facing = rotation(UP, Math.atan2(-forward[0], -forward[2]));
  const turned = multiply(facing, multiply(translation(scale(bottom, -1)), standing));
  return { scale: by, pose: multiply(translation(foot), turned) };
}

/** A rigid pose of the room, in the world. */
export function worldPose(placement: Placement, room_pose: ArrayLike<number>): Pose {
  const pose = multiply(invert(placement.pose), room_pose);
  const origin = scale(position(pose), 1 / placement.scale);
  return fromAxes(axis(pose, 0), axis(pose, 1), axis(pose, 2), origin);
}

/** A point of the world, in the room. */
export const roomPoint = (placement: Placement, point: Vec3): Vec3 =>
  add(turn(placement.pose, scale(point, placement.scale)), position(placement.pose));

/** `world_from_room`, row by row, with the scale in it, for the camera's rig. */
export function worldFromRoom(placement: Placement): Pose {
  const inverse = invert(placement.pose);
  return inverse.map((value, k) => (k < 12 ? value / placement.scale : value));
}

/** The placement turned about the vertical through a point of the room. */
export const turnedIn = (placement: Placement, about: Vec3, angle_rad: number): Placement => ({
  scale: placement.scale,
  pose: multiply(
    translation(about),
    multiply(rotation(UP, angle_rad), multiply(translation(scale(about, -1)), placement.pose)),
  ),
});

export const shifted = (placement: Placement, by: Vec3): Placement => ({
  scale: placement.scale,
  pose: multiply(translation(by), placement.pose),
});

const live = (value: number): number => (Math.abs(value) < STICK_DEAD_ZONE ? 0 : value);

/**
 * The thumbsticks' effect in a frame.
 *
 * The tool's hand turns the viewer (on a table: the mock-up about its middle) and raises or lowers them; the other hand
 * walks, ahead being where the head looks.
 */
export class Walk {
  private isSnapped = false;

  step(
    placement: Placement,
    kind: VrSize,
    sticks: { readonly tool: Stick; readonly other: Stick },
    room_from_viewer: ArrayLike<number>,
    middle: Vec3,
    seconds: number,
  ): Placement {
    const [turning, sinking] = [live(sticks.tool[0]), live(sticks.tool[1])];
    const [right, back] = [live(sticks.other[0]), live(sticks.other[1])];
    let next = placement;
    if (kind === "table") {
      if (turning !== 0) next = turnedIn(next, roomPoint(next, middle), turning * SPIN_RAD_PER_S * seconds);
    } else if (this.snaps(sticks.tool[0])) {
      // To the right, the room goes round to the left.
      next = turnedIn(next, position(room_from_viewer), Math.sign(turning) * SNAP_RAD);
    }
    if (sinking === 0 && right === 0 && back === 0) return next;
    const ahead = heading(room_from_viewer);
    const aside: Vec3 = [-ahead[2], 0, ahead[0]];
    const way = add(add(scale(aside, right), scale(ahead, -back)), [0, -sinking, 0]);
    // The viewer moves one way, the surroundings the other.
    return shifted(next, scale(way, -WALK_M_PER_S * seconds));
  }

  private snaps(turning: number): boolean {
    const size = Math.abs(turning);
    if (size < SNAP_AGAIN_AT) this.isSnapped = false;
    if (this.isSnapped || size < SNAP_AT) return false;
    this.isSnapped = true;
    return true;
  }
}

/** How the tool lies in the hand that holds the controller. */
export class GripTie {
  private grip_from_tool: Pose = [...IDENTITY];

  /** From now on the tool follows from its present place. */
  take(world_from_grip: ArrayLike<number>, world_from_tool: ArrayLike<number>): void {
    this.grip_from_tool = multiply(invert(world_from_grip), world_from_tool);
  }

  /** From now on the tool is in the hand, its pivot (hand frame) in the fist, turned as it is. */
  recall(world_from_grip: ArrayLike<number>, world_from_tool: ArrayLike<number>, pivot: Vec3): void {
    const from = turn(world_from_tool, pivot);
    const origin = subtract(position(world_from_grip), from);
    const at = fromAxes(axis(world_from_tool, 0), axis(world_from_tool, 1), axis(world_from_tool, 2), origin);
    this.take(world_from_grip, at);
  }

  /** Where the tool is wished. */
  wish(world_from_grip: ArrayLike<number>): Pose {
    return multiply(world_from_grip, this.grip_from_tool);
  }
}
