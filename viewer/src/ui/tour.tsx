// The tour: eight steps in two minutes, each beside its subject.

import { useLayoutEffect, useRef } from "preact/hooks";
import { shownKey } from "../actions/commands";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";

interface Step {
  /** Its subject, as a selector; the card stands beside it. */
  readonly at: string;
  readonly title: string;
  readonly text: string;
  readonly keys: readonly string[];
}

export const TOUR: readonly Step[] = [
  {
    at: "#picture",
    title: "Look around",
    text: "Drag to turn the mock-up about the point under the pointer; the right button moves it, the wheel zooms to the pointer. F frames everything, and the cube in the corner turns the view to any side; O switches to parallel projection. The settings have the navigation of other programs.",
    keys: ["F", "1"],
  },
  {
    at: "#tree",
    title: "Find a part",
    text: "Search by any words of a part's path. Selected parts are highlighted in the tree and in the picture. H hides, X makes a ghost, Shift+H isolates, and Shift+H again ends the isolation.",
    keys: ["Ctrl+F", "H", "X", "Shift+H"],
  },
  {
    at: "#picture",
    title: "Cut it open",
    text: "S cuts through the selection, or through the middle. Cuts are filled, and geometry that is cut away can be neither picked nor measured.",
    keys: ["S"],
  },
  {
    at: "#panels",
    title: "Move the tool",
    text: "Drag the tool itself, or its arrows and rings. Or type: G moves, R turns, then X, Y or Z, a number, Enter. The ghost follows your hand; the solid tool stops at contact.",
    keys: ["G", "R"],
  },
  {
    at: "#modes",
    title: "Feel the contact",
    text: "Stop: the tool stops at the first contact, however fast you are. Glide: it slides along. Pass: it goes through and shows what it cuts. Orange parts touch; surfaces within 20 mm are coloured by their distance. Space switches to the next mode.",
    keys: ["Space"],
  },
  {
    at: "#panels",
    title: "Take a part out",
    text: "Select a part, grip it with E, move it away, release it with E. Each removal becomes a line of the sequence: its smallest clearance and the touched parts. Ctrl+Z undoes everything.",
    keys: ["E", "Ctrl+Z"],
  },
  {
    at: "#panels",
    title: "Measure and show",
    text: "M measures between points, with snapping; edges, angles and exact distances between parts are in the panel. K takes a picture and stores the viewpoint.",
    keys: ["M", "K"],
  },
  {
    at: "#bar",
    title: "Everything else",
    text: "Ctrl+K finds every command by its name, ? shows all keys.",
    keys: ["Ctrl+K", "?"],
  },
];

const GAP_PX = 12;

export function Tour() {
  const wb = useWorkbench();
  const { store } = wb;
  const at = store.tour_step.value;
  const card = useRef<HTMLDivElement>(null);
  const frame = useRef<HTMLDivElement>(null);
  const step = at === null ? undefined : TOUR[at];

  useLayoutEffect(() => {
    const place = (): void => {
      const target = step && document.querySelector(step.at)?.getBoundingClientRect();
      const box = card.current;
      const ring = frame.current;
      if (!target || !box || !ring) return;
      Object.assign(ring.style, {
        left: `${target.left}px`,
        top: `${target.top}px`,
        width: `${target.width}px`,
        height: `${target.height}px`,
      });
      const [width, height] = [box.offsetWidth, box.offsetHeight];
      const isWide = target.width > 2 * width;
      const left = isWide
        ? target.left + GAP_PX
        : target.left > window.innerWidth / 2
          ? target.left - width - GAP_PX
          : target.right + GAP_PX;
      const top =
        isWide && target.height > 2 * height
          ? target.bottom - height - GAP_PX
          : isWide
            ? target.bottom + GAP_PX
            : target.top + GAP_PX;
      box.style.left = `${Math.max(GAP_PX, Math.min(left, window.innerWidth - width - GAP_PX))}px`;
      box.style.top = `${Math.max(GAP_PX, Math.min(top, window.innerHeight - height - GAP_PX))}px`;
    };
    place();
    if (step) card.current?.focus();
    window.addEventListener("resize", place);
    return () => window.removeEventListener("resize", place);
  }, [step]);

  if (at === null || !step) return null;
  const go = (next: number | null): void => {
    store.tour_step.value = next !== null && next >= 0 && next < TOUR.length ? next : null;
    if (store.tour_step.peek() === null) store.set({ has_seen_tour: true });
  };
  return (
    <>
      <div ref={frame} class="tour-frame" aria-hidden="true" />
      <div ref={card} class="tour-card" role="dialog" aria-label={`Tour: ${step.title}`} tabIndex={-1}>
        <div class="tour-line">
          <h2>{step.title}</h2>
          <IconButton icon="close" label="End the tour" run={() => go(null)} />
        </div>
        <p>{step.text}</p>
        <p class="tour-keys">
          {step.keys.map((key) => (
            <kbd key={key}>{shownKey(key)}</kbd>
          ))}
        </p>
        <div class="tour-line">
          <span class="note">{`${at + 1} of ${TOUR.length}`}</span>
          {at > 0 && (
            <button type="button" class="button" onClick={() => go(at - 1)}>
              Back
            </button>
          )}
          <button type="button" class="button main" onClick={() => go(at + 1)}>
            {at + 1 < TOUR.length ? "Next" : "Done"}
          </button>
        </div>
      </div>
    </>
  );
}
