// How the next clash check is made: clearance, contact, rules.

import { useId, useState } from "preact/hooks";
import { openRules, setCheck } from "../actions/findings";
import { saidOf } from "../actions/workbench";
import type { LeftPattern } from "../link/protocol";
import { DISTANCES_M } from "../math/units";
import { useWorkbench } from "./context";
import { Figure } from "./fields";
import { Left } from "./requirements";

export function CheckSettings() {
  const wb = useWorkbench();
  const { store } = wb;
  const { are_settings_open } = store.findings;
  const clash = store.document.value?.clash;
  if (!clash) return null;
  const is_locked = store.is_read_only.value;
  return (
    <details
      class="check-settings"
      open={are_settings_open.value}
      onToggle={(event) => {
        are_settings_open.value = event.currentTarget.open;
      }}
    >
      <summary>Clearance, contact, rules</summary>
      <Figure
        label="Clearance"
        kind="length"
        unit={store.unit.value}
        value={clash.clearance}
        step={1e-3}
        disabled={is_locked}
        range={DISTANCES_M}
        change={(clearance) => setCheck(wb, { clearance })}
      />
      <Figure
        label="Contact"
        kind="length"
        unit={store.unit.value}
        value={clash.contact ?? 0}
        step={1e-4}
        disabled={is_locked || clash.contact === null}
        range={DISTANCES_M}
        change={(contact) => setCheck(wb, { contact })}
      />
      <label class="check">
        <input
          type="checkbox"
          checked={clash.contact === null}
          disabled={is_locked}
          onChange={(event) => setCheck(wb, { contact: event.currentTarget.checked ? "chord" : 0 })}
        />
        Contact within the chordal errors (STEP)
      </label>
      <Left of="rule" patterns={leftOf(clash.rules, store.document.value?.project?.left ?? [])} />
      <RulesField key={clash.rules} value={clash.rules} />
      <button type="button" class="button" disabled={is_locked} onClick={() => openRules(wb)}>
        Open rules
      </button>
    </details>
  );
}

/** The patterns that are still in the text of the rules. */
const leftOf = (rules: string, left: readonly LeftPattern[]): string[] =>
  left.map(({ pattern }) => pattern).filter((pattern) => rules.includes(pattern));

/** Rules as TOML; a mistake is told there, and the text stays to be mended. */
function RulesField({ value }: { value: string }) {
  const wb = useWorkbench();
  const [draft, setDraft] = useState(value);
  const [trouble, setTrouble] = useState<string | null>(null);
  const id = useId();
  const settle = async (): Promise<void> => {
    try {
      if (draft !== value) await wb.send("clash_settings", { rules: draft });
      setTrouble(null);
    } catch (error) {
      setTrouble(saidOf(error));
    }
  };
  return (
    <>
      <textarea
        class="text-field rules"
        rows={6}
        spellcheck={false}
        placeholder={'[[exclude]]\nname = "seals in their grooves"\na = "*o-ring*"\nb = "*housing*"'}
        aria-label="Rules"
        aria-invalid={trouble !== null}
        aria-describedby={trouble ? id : undefined}
        value={draft}
        disabled={wb.store.is_read_only.value}
        onInput={(event) => setDraft(event.currentTarget.value)}
        onKeyDown={(event) => event.stopPropagation()}
        onBlur={() => void settle()}
      />
      {trouble && (
        <p id={id} class="field-error" role="alert">
          {trouble}
        </p>
      )}
    </>
  );
}
