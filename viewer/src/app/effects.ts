// From what is known to what is drawn: each change of the store reaches the stage once.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { saveSettings } from "../model/settings";
import type { Drawing } from "./loop";
import { partStates } from "./part-states";

/** Follows the store from now on; the function returned ends it. */
export function feed(wb: Workbench, drawing: Drawing): () => void {
  const { store, stage, hand } = wb;
  const ends = [
    effect(() => {
      const document = store.document.value;
      const count = store.paths.value.length;
      if (document) drawing.setPartStates(partStates(count, document, store.selection.value));
    }),
    effect(() => {
      // Another mock-up in the stage has its parts at home.
      void store.manifest.value;
      const moved = store.document.value?.moved ?? {};
      stage.setMoved(new Map(Object.entries(moved).map(([part, pose]) => [Number(part), [...pose]])));
      drawing.request();
    }),
    effect(() => {
      void store.manifest.value;
      stage.setExplode(store.document.value?.explode ?? 0);
      drawing.request();
    }),
    effect(() => {
      stage.setSections(store.drawn_sections.value.map(({ normal, offset }) => ({ normal, offset })));
      drawing.request();
    }),
    effect(() => {
      const theme = store.theme.value;
      document.documentElement.dataset.theme = theme;
      stage.setTheme(theme);
      drawing.request();
    }),
    // The figures of marks depend on the unit; measures and picks are marks themselves.
    effect(() => {
      void [store.unit.value, store.document.value?.measures, store.measuring.value, store.snap.value];
      drawing.remark();
    }),
    effect(() => {
      hand.isLocked = store.is_read_only.value || !store.has_hand.value;
      if (hand.isLocked) store.typed.value = null;
      drawing.request();
    }),
    effect(() => {
      const settings = store.settings.value;
      saveSettings(settings);
      hand.step_m = settings.is_snapping ? settings.step_m : null;
      hand.step_rad = settings.is_snapping ? settings.step_rad : null;
      drawing.request();
    }),
    effect(() => {
      const name = store.document.value?.mockup?.name;
      document.title = name ? `${name} – feeler` : "feeler";
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}

/** Keeps the exact outlines of the cuts that are on beside the picture: asked for once a drag has ended. */
export function followOutlines(wb: Workbench, drawing: Drawing): () => void {
  let asked = 0;
  return effect(() => {
    const document = wb.store.document.value;
    const isDragging = wb.store.section_draft.value !== null;
    const sections = (document?.sections ?? []).filter((section) => section.is_on);
    // What is hidden has no outline, and what was put down has its own: the engine is asked again.
    void [document?.hidden, document?.gripped, document?.moved];
    const mine = ++asked;
    wb.stage.setOutlines(null);
    // Outlines are of parts where they are: an exploded mock-up has none.
    if (isDragging || sections.length === 0 || (document?.explode ?? 0) > 0) return;
    if (wb.store.is_read_only.value || !wb.store.manifest.value) return;
    wb.link
      ?.job("outline", {})
      .result.then((result) => {
        if (mine !== asked) return;
        wb.stage.setOutlines(floatsOf((result as { segments: string }).segments));
        drawing.request();
      })
      .catch((error: unknown) => {
        if (mine === asked) wb.tell(error);
      });
  });
}

/** Little-endian float32 out of base64. */
function floatsOf(text: string): Float32Array {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}
