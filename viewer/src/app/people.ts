// Other people: shows them here, and this page's person to them.

import { computed, effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { colourOf } from "../model/people";
import type { Loop } from "./loop";
import { Presence } from "./presence";

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
