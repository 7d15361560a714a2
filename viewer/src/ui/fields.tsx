// Buttons that run commands, and fields that take lengths and angles as people type them.

import { useRef, useState } from "preact/hooks";
import { commandOf, runCommand } from "../actions/commands";
import { hasLabel, labelOf, tipOf } from "../actions/labels";
import { angleFigure, lengthFigure, parseAngle, parseLength, type Unit } from "../math/units";
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
  disabled?: boolean;
  change: (value: number) => void;
}

/** A length or an angle: typed with or without its unit, stepped by arrow keys. */
export function Figure({ label, value, kind, unit, step, disabled, change }: FigureProps) {
  const [draft, setDraft] = useState<string | null>(null);
  const input = useRef<HTMLInputElement>(null);
  const figure = kind === "length" ? lengthFigure(value, unit) : angleFigure(value);
  const read = (text: string): number | null => (kind === "length" ? parseLength(text, unit) : parseAngle(text));
  const isWrong = draft !== null && read(draft) === null;
  const settle = (): void => {
    const next = draft === null ? null : read(draft);
    setDraft(null);
    if (next !== null && draft !== figure) change(next);
  };
  const onKey = (event: KeyboardEvent): void => {
    const sign = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (sign !== 0) {
      event.preventDefault();
      setDraft(null);
      change(value + sign * step * (event.shiftKey ? 0.1 : 1));
    } else if (event.key === "Enter") {
      settle();
      input.current?.select();
    } else if (event.key === "Escape") {
      event.stopPropagation();
      setDraft(null);
      input.current?.blur();
    }
  };
  return (
    <label class="figure">
      <span class="figure-label">{label}</span>
      <input
        ref={input}
        type="text"
        inputMode="decimal"
        autocomplete="off"
        spellcheck={false}
        value={draft ?? figure}
        aria-invalid={isWrong}
        disabled={disabled}
        onInput={(event) => setDraft(event.currentTarget.value)}
        onFocus={(event) => event.currentTarget.select()}
        onBlur={settle}
        onKeyDown={onKey}
      />
      <span class="figure-unit">{kind === "length" ? unit : "°"}</span>
    </label>
  );
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
