// Several people on one project: who is there in the bar, the dialog about them, and the turn of the tool.

import { commandOf } from "../actions/commands";
import { labelOf } from "../actions/labels";
import { lookWhere, wishTurn } from "../actions/people";
import type { Person, Turn } from "../link/protocol";
import { MOST_NAME } from "../link/protocol";
import { numberOf } from "../model/people";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";
import { CommandButton, IconButton } from "./fields";
import { Icon } from "./icons";
import { initials, isolated } from "./words";

function Avatar({ person, hasTool }: { person: Person; hasTool: boolean }) {
  const classes = [
    "avatar",
    `person-${numberOf(person.colour)}`,
    person.is_away ? "away" : "",
    hasTool ? "holder" : "",
  ];
  return (
    <span class={classes.join(" ")} aria-hidden="true">
      <bdi>{initials(person.name)}</bdi>
      {hasTool && (
        <span class="avatar-tool">
          <Icon name="grip" size={10} />
        </span>
      )}
    </span>
  );
}

/** Who is there; nothing while nobody else is. */
export function PeopleStrip() {
  const { store } = useWorkbench();
  const { people, others, turn, you } = store.people;
  if (others.value.length === 0) return null;
  const said = people.value.map((person) => isolated(person.name) + tailOf(person, you.value, holderOf(turn.value)));
  return (
    <button
      type="button"
      class="people-strip"
      title={said.join("\n")}
      onClick={() => {
        store.dialog.value = "people";
      }}
    >
      <span class="visually-hidden">{`People: ${said.join(", ")}`}</span>
      {people.value.map((person) => (
        <Avatar key={person.id} person={person} hasTool={person.id === holderOf(turn.value)} />
      ))}
    </button>
  );
}

/** Who has the tool now; null: it is free. */
const holderOf = (turn: Turn): number | null => (turn.is_free ? null : turn.person);

const tailOf = (person: Person, you: number, holder: number | null): string =>
  `${person.id === you ? " (you)" : ""}${person.id === holder ? ", has the tool" : ""}${person.is_away ? ", away" : ""}`;

export function PeopleDialog() {
  const wb = useWorkbench();
  const { people, turn, you, is_mine, holder } = wb.store.people;
  const { kind, person, is_free } = turn.value;
  return (
    <Dialog title="People on this project" kind="people">
      <ul class="people-list">
        {people.value.map((each) => (
          <li key={each.id}>
            <Avatar person={each} hasTool={each.id === person && !is_free} />
            <span class="people-name">
              <bdi>{each.name}</bdi>
              {tailOf(each, you.value, is_free ? null : person)}
            </span>
            {each.id !== you.value && wb.store.people.seen.value.has(each.id) && (
              <button type="button" class="button" onClick={() => lookWhere(wb, each.id)}>
                <span>
                  Look where <bdi>{each.name}</bdi> looks
                </span>
              </button>
            )}
            {each.id !== you.value && is_mine.value && (
              <button type="button" class="button" onClick={() => wishTurn(wb, "give", each.id)}>
                <span>
                  Give <bdi>{each.name}</bdi> the tool
                </span>
              </button>
            )}
          </li>
        ))}
      </ul>
      <p class="note">
        {kind === null ? (
          "Nobody has the tool: who moves it first has it."
        ) : (
          <HolderText name={holder.value} isFree={is_free} />
        )}
      </p>
      <div class="button-row">
        <CommandButton id="take-turn" icon="grip" text={labelOf(wb, commandOf("take-turn"))} />
      </div>
      <NameSetting />
      <p class="note">
        Hidden parts, cuts, measures, findings and undo are common to all; selection and view are each one's own.
      </p>
    </Dialog>
  );
}

function HolderText({ name, isFree }: { name: string; isFree: boolean }) {
  return (
    <>
      <bdi>{name}</bdi>
      {isFree ? " had the tool. It is free: who moves it next has it." : " has the tool."}
    </>
  );
}

/** The name that others see. */
export function NameSetting() {
  const { store } = useWorkbench();
  const { people, you } = store.people;
  const shown = people.value.find(({ id }) => id === you.value)?.name ?? "Guest 1";
  return (
    <label class="field">
      Your name
      <input
        class="text-field"
        type="text"
        maxLength={MOST_NAME}
        autocomplete="off"
        spellcheck={false}
        placeholder={shown}
        value={store.settings.value.name}
        onChange={(event) => store.set({ name: event.currentTarget.value.trim() })}
      />
    </label>
  );
}

/** The turn of the tool, where there is something to decide: over the picture. */
export function TurnBar() {
  const wb = useWorkbench();
  const { people } = wb.store;
  const [first] = people.asking.value;
  if (first) {
    return (
      <div class="banner quiet turn-bar" role="status">
        <Icon name="grip" size={16} />
        <span>
          <bdi>{first.name}</bdi> asks for the tool.
        </span>
        <button type="button" class="button main" onClick={() => wishTurn(wb, "give", first.id)}>
          Give it
        </button>
        <button type="button" class="button" onClick={() => wishTurn(wb, "keep")}>
          Keep it
        </button>
      </div>
    );
  }
  if (people.has_asked.value && !people.is_barred.value && !people.is_mine.value) {
    return (
      <div class="banner quiet turn-bar" role="status">
        <Icon name="grip" size={16} />
        <span>The tool is free.</span>
        <button type="button" class="button main" onClick={() => wishTurn(wb, "take")}>
          Take it
        </button>
      </div>
    );
  }
  if (!people.is_barred.value || !(people.has_tried.value || people.has_asked.value)) return null;
  const isPage = people.turn.value.kind === "page";
  return (
    <div class="banner quiet turn-bar" role="status">
      <Icon name="grip" size={16} />
      <span>
        <bdi>{people.holder.value}</bdi> has the tool.
        {people.has_asked.value && " You asked for it."}
        {!isPage && " It is free soon after its last move."}
      </span>
      {isPage && !people.has_asked.value && (
        <button type="button" class="button main" onClick={() => wishTurn(wb, "ask")}>
          Ask for it
        </button>
      )}
      {!people.has_asked.value && (
        <IconButton
          icon="close"
          label="Close"
          run={() => {
            people.has_tried.value = false;
          }}
        />
      )}
    </div>
  );
}
