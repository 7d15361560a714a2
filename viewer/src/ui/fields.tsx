// Buttons that run commands, and fields that take lengths and angles as people type them.

import { useId, useRef, useState } from "preact/hooks";
import { commandOf, runCommand } from "../actions/commands";
import { hasLabel, labelOf, tipOf } from "../actions/labels";
import { angleFigure, keptFigure, lengthFigure, parseAngle, parseLength, type Unit } from "../math/units";
import { useWorkbench } from "./context";
import { Icon, type IconName } from "./icons";

/** A button that runs a command of the table. Its name follows the state; one that stays has `pressed` instead. */
export function CommandButton(props: { id: string; icon: IconName; text?: string; pressed?: boolean }) {
  const wb = useWorkbench();
  const { id, icon, text, pressed } = props;
  const command = commandOf(id);
  return (
    <button
      type="button"
      class={`button ${text ? "" : "square"} ${pressed ? "on" : ""}`}
      title={tipOf(wb, command)}
      aria-label={text ? undefined : labelOf(wb, command)}
      aria-pressed={hasLabel(id) ? undefined : pressed}
      disabled={command.when ? !command.when(wb) : false}
      onClick={() => runCommand(wb, id)}
    >
      <Icon name={icon} />
      {text && <span>{text}</span>}
    </button>
  );
}

/** A button with an icon alone. */
export function IconButton(props: {
  icon: IconName;
  label: string;
  run: () => void;
  pressed?: boolean | undefined;
  disabled?: boolean | undefined;
  tabIndex?: number | undefined;
}) {
  return (
    <button
      type="button"
      class="button square quiet"
      title={props.label}
      aria-label={props.label}
      aria-pressed={props.pressed}
      disabled={props.disabled}
      tabIndex={props.tabIndex}
      onClick={(event) => {
        event.stopPropagation();
        props.run();
      }}
    >
      <Icon name={props.icon} size={14} />
    </button>
  );
}

/** Several choices of which one holds. */
export function Choice<T extends string>(props: {
  label: string;
  value: T;
  options: readonly { value: T; text: string; title?: string }[];
  choose: (value: T) => void;
  disabled?: boolean;
}) {
  return (
    <div class="choice" role="radiogroup" aria-label={props.label}>
      {props.options.map(({ value, text, title }) => (
        <label key={value} class={value === props.value ? "chosen" : ""} title={title}>
          <input
            type="radio"
            name={props.label}
            value={value}
            checked={value === props.value}
            disabled={props.disabled}
            onChange={() => props.choose(value)}
          />
          {text}
        </label>
      ))}
    </div>
  );
}

interface FigureProps {
  label: string;
  /** Metres or radians. */
  value: number;
  kind: "length" | "angle";
  unit: Unit;
  /** Step of an arrow key or a button; Shift: a tenth. */
  step: number;
  /** The least and the greatest length of a setting, metres; a setting is shown with all the digits that are kept. */
  range?: readonly [least: number, greatest: number];
  disabled?: boolean;
  /** Ends once `value` has the change, or it was refused. */
  change: (value: number) => Promise<unknown>;
}

/**
 * A length or an angle: typed with or without its unit, stepped by arrow keys. What is wrong stays, to be mended. A
 * change is shown at once, and the next step counts from it, however late `value` follows.
 */
export function Figure(props: FigureProps) {
  const { label, kind, unit, step, range, disabled } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const [value, change] = useAhead(props.value, props.change);
  const [isTold, setTold] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  const id = useId();
  const [least, greatest] = range ?? [-Infinity, Infinity];
  const figure = kind === "angle" ? angleFigure(value()) : (range ? keptFigure : lengthFigure)(value(), unit);
  const read = (text: string): number | null => (kind === "length" ? parseLength(text, unit) : parseAngle(text));
  const wrongIn = (text: string): string | null => {
    const typed = read(text);
    if (typed === null)
      return kind === "length" ? "Type a length such as 5, 2.5 mm or 3/8 in" : "Type an angle such as 45 or 0.5 rad";
    if (typed >= least && typed <= greatest) return null;
    return `Type a length from ${keptFigure(least, unit)} to ${keptFigure(greatest, unit)} ${unit}`;
  };
  const wrong = draft === null ? null : wrongIn(draft);
  /** What was typed and is not settled yet; null: nothing that can be. */
  const typed = wrong === null && draft !== null && draft !== figure ? read(draft) : null;
  const trouble = isTold ? wrong : null;
  const reset = (): void => {
    setDraft(null);
    setTold(false);
  };
  const settle = (): void => {
    if (wrong !== null && draft?.trim() !== "") {
      setTold(true);
      return;
    }
    reset();
    if (typed !== null) change(typed);
  };
  const onKey = (event: KeyboardEvent): void => {
    const sign = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (sign !== 0) {
      event.preventDefault();
      reset();
      const from = typed ?? value();
      change(Math.min(greatest, Math.max(least, from + sign * step * (event.shiftKey ? 0.1 : 1))));
    } else if (event.key === "Enter") {
      settle();
      input.current?.select();
    } else if (event.key === "Escape") {
      event.stopPropagation();
      reset();
      input.current?.blur();
    }
  };
  return (
    <>
      <label class="figure">
        <span class="figure-label">{label}</span>
        <input
          ref={input}
          type="text"
          inputMode="decimal"
          autocomplete="off"
          spellcheck={false}
          value={draft ?? figure}
          aria-invalid={wrong !== null}
          aria-describedby={trouble ? id : undefined}
          disabled={disabled}
          onInput={(event) => setDraft(event.currentTarget.value)}
          onFocus={(event) => event.currentTarget.select()}
          onBlur={settle}
          onKeyDown={onKey}
        />
        <span class="figure-unit">{kind === "length" ? unit : "°"}</span>
      </label>
      {trouble && (
        <p id={id} class="field-error" role="alert">
          {trouble}
        </p>
      )}
    </>
  );
}

/** A value that is changed elsewhere: what it was changed to last, until that change has ended; and the change of it. */
function useAhead(
  value: number,
  change: (value: number) => Promise<unknown>,
): readonly [() => number, (value: number) => void] {
  // Of the newest change alone. Keys can come before the page is drawn with it.
  const ahead = useRef<{ readonly to: number } | null>(null);
  const [, draw] = useState<object | null>(null);
  const follow = (next: { readonly to: number } | null): void => {
    ahead.current = next;
    draw(next);
  };
  const changed = (to: number): void => {
    const own = { to };
    follow(own);
    const end = (): void => {
      if (ahead.current === own) follow(null);
    };
    change(to).then(end, end);
  };
  return [() => ahead.current?.to ?? value, changed];
}

/** A name that can be changed in place. */
export function NameField(props: {
  label: string;
  value: string;
  disabled?: boolean;
  change: (value: string) => void;
}) {
  const [draft, setDraft] = useState<string | null>(null);
  const settle = (): void => {
    const next = draft?.trim();
    setDraft(null);
    if (next && next !== props.value) props.change(next);
  };
  return (
    <input
      class="name-field"
      type="text"
      title={draft ?? props.value}
      aria-label={props.label}
      value={draft ?? props.value}
      disabled={props.disabled}
      spellcheck={false}
      autocomplete="off"
      onInput={(event) => setDraft(event.currentTarget.value)}
      onBlur={settle}
      onKeyDown={(event) => {
        if (event.key === "Enter") event.currentTarget.blur();
        else if (event.key === "Escape") {
          event.stopPropagation();
          setDraft(null);
        }
      }}
    />
  );
}
