// Connects sound, rumble and devices: the engine's contacts become sound and rumble, device motion moves the tool.

import { computed, effect } from "@preact/signals";
import { runCommand } from "../actions/commands";
import type { Workbench } from "../actions/workbench";
import { Feel } from "../feel/events";
import { outputsOf, Rumble } from "../feel/rumble";
import { Sound } from "../feel/sound";
import { GamepadInput, type PadHost } from "../input/gamepad";
import type { RateSpeeds, RateTarget } from "../input/rate";
import { browserHid, type CapStatus, SpaceMouse } from "../input/spacemouse";
import { hasHeadset, type WorldRay, XrRoom } from "../input/xr";
import type { Impact, State } from "../link/protocol";
import { scale } from "../math/vectors";
import type { Loop } from "./loop";

/** At full deflection a rate device moves by this share of the view per second. */
const VIEW_SHARE_PER_S = 0.4;
const TURN_RAD_PER_S = 1.2;

export interface Devices {
  state(state: State): void;
  impact(impact: Impact): void;
  /** The link is down, or another mock-up is open. */
  reset(): void;
}

export function createDevices(wb: Workbench, loop: Loop): Devices {
  const { store } = wb;
  const feel = new Feel();
  const sound = new Sound();
  let room: XrRoom | null = null;
  const rumble = new Rumble(() => [...outputsOf(navigator.getGamepads?.() ?? []), ...(room?.outputs() ?? [])]);
  const target = (): RateTarget => (wb.hand.isLocked ? cameraTarget(wb) : wb.hand);
  const host: PadHost = {
    target,
    speeds: () => speedsOf(wb),
    command: (command) => runCommand(wb, command),
    notice: (text) => store.notify("warning", text),
  };
  const pads = new GamepadInput(host);
  const cap = new SpaceMouse({
    target,
    speeds: host.speeds,
    button: (number) => runCommand(wb, number === 1 ? "fit" : "mode"),
    status: (status) => tellCap(wb, status),
    moved: loop.request,
  });

  sound.unlockOn(window);
  window.addEventListener("gamepadconnected", loop.request);
  effect(() => {
    const { is_muted, volume, has_rumble, has_event_rumble, has_force_rumble, dead_zone } = store.settings.value;
    sound.isMuted = is_muted;
    sound.volume = volume;
    Object.assign(rumble.settings, { isOn: has_rumble, hasEvents: has_event_rumble, hasForce: has_force_rumble });
    pads.settings.dead_zone = dead_zone;
  });
  const vr_size = computed(() => store.settings.value.vr_size);
  effect(() => {
    const kind = vr_size.value;
    room?.place(kind);
  });
  effect(() => {
    feel.material = store.document.value?.material ?? null;
  });
  loop.each_frame.add((now) => {
    const isPadMoving = pads.frame(now);
    const isCapMoving = cap.frame(now);
    const felt = feel.step(now);
    sound.play(felt);
    const isRumbling = rumble.play(felt, now);
    // Impacts ring on by themselves; what rumbles and slides lasts only as long as frames tell it.
    return isRumbling || isPadMoving || isCapMoving || felt.press_n > 0 || felt.slide.speed_m_per_s > 0;
  });

  if (browserHid()) {
    wb.connectSpaceMouse = () => void cap.connect();
    void cap.reconnect();
  }
  void hasHeadset().then((isThere) => {
    if (!isThere) return;
    room = createRoom(wb, loop);
    wb.toggleXr = () => {
      const turned = room?.isPresenting ? room.leave() : room?.enter(vr_size.peek());
      turned?.catch((error: unknown) => wb.tell(error));
    };
    store.is_xr_there.value = true;
  });

  return {
    state: (state) => feel.state(state, performance.now()),
    impact: (impact) => feel.strike(impact, performance.now()),
    reset: () => feel.reset(),
  };
}

/** The camera behind the calls of a rate device: an empty hand moves the view. */
function cameraTarget(wb: Workbench): RateTarget {
  return {
    nudge(increment) {
      const { camera } = wb.stage;
      const [right, up, near] = increment.translation;
      // The device moves the scene, so the eye goes the other way.
      // Nearer is larger: in parallel projection only zooming makes it so.
      if (camera.isParallel) camera.dolly(Math.exp(-near / camera.reach));
      const ahead = camera.isParallel ? 0 : near;
      camera.translate(addAll(scale(camera.right, -right), scale(camera.top, -up), scale(camera.forward, ahead)));
      const [over, about] = increment.rotation;
      camera.orbit(about, over, camera.target);
      wb.redraw();
    },
    put() {},
  };
}

const addAll = (...vectors: [number, number, number][]): [number, number, number] =>
  vectors.reduce((sum, each) => [sum[0] + each[0], sum[1] + each[1], sum[2] + each[2]]);

function speedsOf(wb: Workbench): RateSpeeds {
  const { camera } = wb.stage;
  const center = wb.hand.center ?? camera.target;
  const depth = Math.max(camera.project(center).depth, 1e-3);
  return {
    translation_m_per_s: VIEW_SHARE_PER_S * camera.metresPerPixel(depth) * camera.height,
    rotation_rad_per_s: TURN_RAD_PER_S,
  };
}

function tellCap(wb: Workbench, status: CapStatus): void {
  if (status.kind === "failed") wb.store.notify("error", status.text);
  else if (status.kind === "open") wb.store.notify("info", `${status.name} moves the tool`);
}

function createRoom(wb: Workbench, loop: Loop): XrRoom {
  const { stage, hand } = wb;
  return new XrRoom({
    renderer: stage.renderer,
    eye: stage.eye,
    rig: stage.rig,
    overlay: stage.overlay,
    hand,
    mockup: () => wb.store.manifest.peek(),
    frame: (now) => loop.drawNow(now),
    grip: (ray) => void gripAlong(wb, ray),
    release: () => void wb.run("release"),
    command: (command) => runCommand(wb, command),
    ended: () => {
      stage.camera.moved = true;
      loop.request();
    },
  });
}

/** The trigger in VR: grips the touched parts, else the part that the ray hits. */
async function gripAlong(wb: Workbench, ray: WorldRay): Promise<void> {
  const touched = wb.store.state.peek()?.parts ?? [];
  if (touched.length > 0) {
    await wb.run("grip", { parts: touched });
    return;
  }
  try {
    const found = await wb.ask("ray", { origin: ray.origin, direction: ray.direction });
    if (found) await wb.run("grip", { parts: [found.part] });
  } catch (error) {
    wb.tell(error);
  }
}
