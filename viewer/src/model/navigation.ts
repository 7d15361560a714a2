// Navigation styles: which buttons and keys turn, move and zoom the view. A table; `mouse.ts` reads it.

export type CameraAction = "orbit" | "pan" | "zoom";

/** `PointerEvent.buttons`. */
export const LEFT = 1;
export const RIGHT = 2;
export const MIDDLE = 4;

export interface Binding {
  /** All buttons that are down, `PointerEvent.buttons`. */
  readonly buttons: number;
  readonly shift?: boolean;
  readonly ctrl?: boolean;
  readonly alt?: boolean;
  readonly action: CameraAction;
  /** As the card of the style says it. */
  readonly text: string;
}

export interface NavigationStyle {
  readonly id: string;
  readonly title: string;
  readonly bindings: readonly Binding[];
  /** The action of the wheel, or of two fingers on a touchpad; with Ctrl (also by pinching) it is always zoom. */
  readonly wheel: "zoom" | "pan";
  /** 1: turning the wheel away from you goes nearer; -1: goes farther. */
  readonly wheel_sense: 1 | -1;
}

export const STYLES: readonly NavigationStyle[] = [
  {
    id: "feeler",
    title: "feeler",
    bindings: [
      { buttons: LEFT, action: "orbit", text: "Left drag" },
      { buttons: RIGHT, action: "pan", text: "Right drag" },
      { buttons: MIDDLE, action: "pan", text: "Middle drag" },
      { buttons: MIDDLE, ctrl: true, action: "zoom", text: "Ctrl + middle drag" },
    ],
    wheel: "zoom",
    wheel_sense: 1,
  },
  {
    id: "blender",
    title: "Blender",
    bindings: [
      { buttons: MIDDLE, action: "orbit", text: "Middle drag" },
      { buttons: MIDDLE, shift: true, action: "pan", text: "Shift + middle drag" },
      { buttons: MIDDLE, ctrl: true, action: "zoom", text: "Ctrl + middle drag" },
    ],
    wheel: "zoom",
    wheel_sense: 1,
  },
  {
    id: "solidworks",
    title: "SolidWorks",
    bindings: [
      { buttons: MIDDLE, action: "orbit", text: "Middle drag" },
      { buttons: MIDDLE, ctrl: true, action: "pan", text: "Ctrl + middle drag" },
      { buttons: MIDDLE, shift: true, action: "zoom", text: "Shift + middle drag" },
    ],
    wheel: "zoom",
    wheel_sense: -1,
  },
  {
    id: "catia",
    title: "CATIA, FreeCAD (CAD)",
    bindings: [
      { buttons: MIDDLE, action: "pan", text: "Middle drag" },
      { buttons: MIDDLE + LEFT, action: "orbit", text: "Middle + left drag" },
      { buttons: MIDDLE + RIGHT, action: "orbit", text: "Middle + right drag" },
      { buttons: MIDDLE, ctrl: true, action: "zoom", text: "Ctrl + middle drag" },
    ],
    wheel: "zoom",
    wheel_sense: 1,
  },
  {
    id: "onshape",
    title: "Onshape",
    bindings: [
      { buttons: RIGHT, action: "orbit", text: "Right drag" },
      { buttons: MIDDLE, action: "pan", text: "Middle drag" },
      { buttons: RIGHT, ctrl: true, action: "pan", text: "Ctrl + right drag" },
    ],
    wheel: "zoom",
    wheel_sense: -1,
  },
  {
    id: "touchpad",
    title: "Touchpad",
    bindings: [
      { buttons: LEFT, action: "orbit", text: "Drag" },
      { buttons: LEFT, shift: true, action: "pan", text: "Shift + drag" },
      { buttons: LEFT, alt: true, action: "zoom", text: "Alt + drag" },
      { buttons: RIGHT, action: "pan", text: "Two-finger drag" },
    ],
    wheel: "pan",
    wheel_sense: 1,
  },
];

/** The style of that id; our own style for an unknown one. */
export function styleOf(id: string): NavigationStyle {
  const found = STYLES.find((style) => style.id === id) ?? STYLES[0];
  if (!found) throw new RangeError("the table of navigation styles is empty");
  return found;
}

export interface Chord {
  readonly buttons: number;
  readonly shiftKey: boolean;
  readonly ctrlKey: boolean;
  readonly altKey: boolean;
}

/** The camera action of a chord of buttons and keys; null: none. */
export function actionOf(style: NavigationStyle, chord: Chord): CameraAction | null {
  const found = style.bindings.find(
    (binding) =>
      binding.buttons === chord.buttons &&
      (binding.shift ?? false) === chord.shiftKey &&
      (binding.ctrl ?? false) === chord.ctrlKey &&
      (binding.alt ?? false) === chord.altKey,
  );
  return found?.action ?? null;
}
