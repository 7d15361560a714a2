// Other people: tells the server where this page's person points and looks, while others are there, and shows them here.

import { computed, effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { type Here, LEAST_HERE_MS, MOST_SELECTED } from "../link/protocol";
import { isSame } from "../math/same";
import { colourOf } from "../model/people";
import type { Loop } from "./loop";

/** A page that says nothing for some seconds counts as away. */
const STILL_HERE_MS = 2000;

/** Follows the people from now on. */
export function followPeople(wb: Workbench, loop: Loop): void {
  const { link, store, stage } = wb;
  const { people } = store;
  if (!link) return;
  followName(wb);
  const presence = new Presence(wb);
  const isShared = computed(() => store.connection.value === "open" && people.others.value.length > 0);
  effect(() => presence.share(isShared.value));
  effect(() => {
    void [store.pointed.value, store.selection.value, people.you.value];
    presence.changed();
  });
  loop.after_frame.add(() => {
    presence.changed();
    return false;
  });
  const colours = computed(() => people.others.value.map(({ colour }) => colourOf(colour)).join());
  effect(() => {
    stage.setOthers(colours.value.split(",").map(Number));
    loop.request();
  });
  effect(() => {
    void [people.seen.value, people.others.value, people.turn.value];
    loop.remark();
  });
  followTurn(wb);
}

function followName({ link, store }: Workbench): void {
  const name = computed(() => store.settings.value.name);
  let isNamed = false;
  effect(() => {
    if (store.connection.value !== "open") {
      isNamed = false;
      return;
    }
    if (name.value !== "" || isNamed) link?.name(name.value);
    isNamed = name.value !== "";
  });
}

/** Says who asks for the tool, and that one has it. */
function followTurn(wb: Workbench): void {
  const { people } = wb.store;
  let hadAsked = false;
  effect(() => {
    if (hadAsked && people.is_mine.value) wb.store.notify("info", "You have the tool now");
    hadAsked = people.has_asked.value;
  });
  const asking = computed(() => people.asking.value.map(({ name }) => name).join(", "));
  effect(() => {
    if (asking.value !== "") wb.say(`${asking.value} asks for the tool`);
  });
}

/** Tells where the person is: at most once in a time, and only what is new, but now and then in any case. */
class Presence {
  private isShared = false;
  private told: Omit<Here, "kind"> | null = null;
  private waiting: ReturnType<typeof setTimeout> | null = null;
  private ticking: ReturnType<typeof setInterval> | null = null;

  constructor(private readonly wb: Workbench) {}

  /** Whether anybody is there to see it. */
  share(isShared: boolean): void {
    if (isShared === this.isShared) return;
    this.isShared = isShared;
    this.told = null;
    if (this.ticking !== null) clearInterval(this.ticking);
    this.ticking = isShared ? setInterval(() => this.tick(), STILL_HERE_MS) : null;
    this.changed();
  }

  changed(): void {
    if (!this.isShared || this.waiting !== null) return;
    this.waiting = setTimeout(() => {
      this.waiting = null;
      this.send(false);
    }, LEAST_HERE_MS);
  }

  private tick(): void {
    if (!document.hidden) this.send(true);
  }

  private send(isForced: boolean): void {
    if (!this.isShared) return;
    const here = this.here();
    if (!isForced && isSame(here, this.told)) return;
    this.told = here;
    this.wb.link?.here(here);
  }

  private here(): Omit<Here, "kind"> {
    const { store, stage, hand } = this.wb;
    const count = store.paths.peek().length;
    return {
      point: store.pointed.peek(),
      selection: [...store.selection.peek()].filter((part) => part < count).slice(0, MOST_SELECTED),
      camera: stage.camera.toJSON(),
      is_moving: hand.wish !== null || store.typed.peek() !== null,
    };
  }
}
