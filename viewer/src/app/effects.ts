// From the store to the stage: each change of the store is drawn once.

import { computed, effect } from "@preact/signals";
import { waysOf } from "../actions/cards";
import type { Workbench } from "../actions/workbench";
import { saveSettings } from "../model/settings";
import { goneParts } from "../model/task";
import type { Loop } from "./loop";
import { answerTints, findingTints, partStates } from "./part-states";

/** Follows the store from now on; the function returned ends it. */
export function followStore(wb: Workbench, loop: Loop): () => void {
  const { store, stage, hand } = wb;
  // A film goes on in each frame, and what is out in it at each step.
  const step = computed(() => (store.film.value ? `${store.film.value.card} ${store.film.value.step}` : ""));
  const ends = [
    effect(() => {
      const document = store.document.value;
      const count = store.paths.value.length;
      const focus = store.findings.focus.value;
      const others = store.people.selections.value;
      void step.value;
      const gone = goneParts(store.film.peek(), document?.cards ?? [], store.answers.value, store.paths.value);
      // What a film moves is seen, though the sequence has it out.
      const filmed = new Set(waysOf(wb, store.film.peek()?.card).flatMap((way) => way.parts));
      const shown = document && {
        ...document,
        ghost: [...document.ghost, ...gone],
        out: document.out.filter((part) => !filmed.has(part)),
      };
      if (shown) loop.setPartStates(partStates(count, shown, store.selection.value, focus, others));
    }),
    effect(() => {
      // Another mock-up in the stage has its own colours.
      void store.manifest.value;
      const focus = store.findings.focus.value;
      const answer = store.card.value === null ? undefined : store.answers.value.get(store.card.value);
      stage.setTints(focus ? findingTints(focus) : answerTints(answer));
      loop.remark();
    }),
    effect(() => {
      void store.manifest.value;
      stage.setExplode(store.document.value?.explode ?? 0);
      loop.request();
    }),
    effect(() => {
      const cuts = store.drawn_sections.value.map(({ normal, offset }) => ({ normal, offset }));
      stage.setSections(cuts, store.drawn_box.value);
      loop.request();
    }),
    effect(() => {
      stage.camera.setParallel(store.settings.value.is_parallel);
      loop.request();
    }),
    effect(() => {
      const theme = store.theme.value;
      document.documentElement.dataset.theme = theme;
      stage.setTheme(theme);
      loop.request();
    }),
    // The figures of marks depend on the unit; measures and picks are marks themselves.
    effect(() => {
      void [
        store.unit.value,
        store.document.value?.measures,
        store.measuring.value,
        store.snap.value,
        store.typed.value,
      ];
      loop.remark();
    }),
    effect(() => {
      const is_barred = store.people.is_barred.value;
      if (is_barred && hand.wish) hand.drop();
      hand.isLocked = store.is_read_only.value || !store.has_hand.value || is_barred;
      // The keys that follow were meant for the tool.
      if (hand.isLocked && store.typed.peek()) {
        store.typed.value = null;
        store.is_typing_refused.value = true;
      }
      loop.request();
    }),
    effect(() => {
      const panel = store.panel.value;
      if (panel !== store.settings.peek().panel) store.set({ panel });
    }),
    effect(() => {
      const settings = store.settings.value;
      saveSettings(settings);
      hand.step_m = settings.is_snapping ? settings.step_m : null;
      hand.step_rad = settings.is_snapping ? settings.step_rad : null;
      loop.request();
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
