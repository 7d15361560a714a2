// Sections: cuts through the mock-up, moved by a slider or a figure.

import { addSection, draftSection, flipped, pickFace, setFace, settleSection } from "../actions/sections";
import type { Section, SectionBox } from "../link/protocol";
import { axisOf, type BoxFace, isUpper } from "../math/box-faces";
import { formatShare } from "../math/units";
import type { Vec3 } from "../math/vectors";
import { offsetRange, senseOf } from "../model/sections";
import { useWorkbench } from "./context";
import { CommandButton, Figure, IconButton } from "./fields";

const AXES: readonly (readonly [string, Vec3])[] = [
  ["X", [1, 0, 0]],
  ["Y", [0, 1, 0]],
  ["Z", [0, 0, 1]],
];

/** Both ends of an axis side by side. */
const FACE_ORDER: readonly BoxFace[] = [0, 3, 1, 4, 2, 5];

export function SectionPanel() {
  const wb = useWorkbench();
  const { store } = wb;
  const sections = store.document.value?.sections ?? [];
  const isLocked = !store.can_look.value;
  const explode = store.document.value?.explode ?? 0;
  const box = store.document.value?.section_box ?? null;
  return (
    <div class="panel-body">
      <section>
        <h2>Cut</h2>
        <div class="button-row">
          {AXES.map(([name, normal]) => (
            <button
              type="button"
              class="button"
              key={name}
              disabled={isLocked}
              onClick={() => addSection(wb, [...normal])}
            >
              Across {name}
            </button>
          ))}
        </div>
        <div class="button-row">
          <CommandButton id="section-face" icon="section" pressed={store.is_picking_face.value} text="Along a face" />
        </div>
        {store.is_picking_face.value && (
          <div class="hint-bar" role="status">
            <span>Click a face in the picture</span>
            <IconButton icon="close" label="End picking a face" run={() => pickFace(wb)} />
          </div>
        )}
        {sections.length === 0 && (
          <p class="note">
            A cut goes through what is selected, else through the middle. It is filled, and picking and measuring obey
            it.
          </p>
        )}
        {sections.map((section, k) => (
          <SectionCard key={section.id} section={section} name={`Cut ${k + 1}`} />
        ))}
        {sections.length > 0 && (
          <div class="button-row">
            <CommandButton
              id="sections"
              icon="section"
              text={sections.some((each) => each.is_on) ? "All off" : "All on"}
            />
          </div>
        )}
      </section>
      <section>
        <h2>Section box</h2>
        <div class="button-row">
          <CommandButton
            id="section-box-fit"
            icon="box"
            text={store.selection.value.size > 0 ? "Round the selection" : "Round everything"}
          />
        </div>
        {box ? (
          <BoxCard box={box} />
        ) : (
          <p class="note">A box shows what is inside it. Drag its arrows in the picture, or type its ends here.</p>
        )}
      </section>
      <section>
        <h2>Explode</h2>
        <label class="slider">
          <input
            type="range"
            min="0"
            max="1"
            step="0.01"
            value={explode}
            disabled={isLocked}
            aria-label="Explode"
            onChange={(event) => wb.run("explode", { share: Number(event.currentTarget.value) })}
          />
          <span class="figure-unit">{formatShare(explode)}</span>
        </label>
      </section>
    </div>
  );
}

function SectionCard({ section, name }: { section: Section; name: string }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isLocked = !store.can_look.value;
  const manifest = store.manifest.value;
  const draft = store.section_draft.value;
  const offset = draft?.id === section.id ? draft.offset : section.offset;
  const [least, most] = manifest ? offsetRange(manifest.lower, manifest.upper, section.normal) : [-1, 1];
  const sense = senseOf(section.normal);
  const across = directionName(section.normal);
  return (
    <article class={`card ${section.is_on ? "" : "off"}`} aria-label={`${name}, ${across}`}>
      <header>
        <label class="check">
          <input
            type="checkbox"
            checked={section.is_on}
            disabled={isLocked}
            onChange={(event) => wb.run("section_switch", { id: section.id, is_on: event.currentTarget.checked })}
          />
          {name}
        </label>
        <span class="note">{across}</span>
        <IconButton
          icon="flip"
          label={`${name}: keep the other side`}
          disabled={isLocked}
          run={() => wb.run(...flipped(section))}
        />
        <IconButton
          icon="trash"
          label={`Remove ${name.toLowerCase()}`}
          disabled={isLocked}
          run={() => wb.run("section_remove", { id: section.id })}
        />
      </header>
      <label class="slider">
        <input
          type="range"
          min={Math.min(sense * least, sense * most)}
          max={Math.max(sense * least, sense * most)}
          step={(most - least) / 1000}
          value={sense * offset}
          disabled={isLocked}
          aria-label={`${name}: where`}
          onInput={(event) => draftSection(wb, section, sense * Number(event.currentTarget.value))}
          onChange={() => settleSection(wb)}
        />
      </label>
      <Figure
        label="At"
        kind="length"
        unit={store.unit.value}
        value={sense * offset}
        step={store.settings.value.step_m}
        disabled={isLocked}
        change={(value) => wb.run("section_move", { id: section.id, normal: section.normal, offset: sense * value })}
      />
    </article>
  );
}

function BoxCard({ box }: { box: SectionBox }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isLocked = !store.can_look.value;
  const now = (box.is_on ? store.box_draft.value : null) ?? { lower: [...box.lower], upper: [...box.upper] };
  return (
    <article class={`card ${box.is_on ? "" : "off"}`} aria-label="Section box">
      <header>
        <label class="check">
          <input
            type="checkbox"
            checked={box.is_on}
            disabled={isLocked}
            onChange={(event) => wb.run("section_box_switch", { is_on: event.currentTarget.checked })}
          />
          Box
        </label>
        <IconButton
          icon="trash"
          label="Remove the section box"
          disabled={isLocked}
          run={() => wb.run("section_box_remove")}
        />
      </header>
      <div class="box-faces">
        {FACE_ORDER.map((face) => (
          <Figure
            key={face}
            label={`${(AXES[axisOf(face)] ?? ["?"])[0]} ${isUpper(face) ? "to" : "from"}`}
            kind="length"
            unit={store.unit.value}
            value={(isUpper(face) ? now.upper : now.lower)[axisOf(face)]}
            step={store.settings.value.step_m}
            disabled={isLocked}
            change={(value) => setFace(wb, face, value)}
          />
        ))}
      </div>
    </article>
  );
}

/** "keeps +X"; for a slanted cut its normal. */
function directionName(normal: Vec3): string {
  for (const [k, [name]] of AXES.entries()) {
    if (Math.abs(Math.abs(normal[k] ?? 0) - 1) < 1e-9) return `keeps ${(normal[k] ?? 0) > 0 ? "+" : "−"}${name}`;
  }
  return `keeps (${normal.map((value) => value.toFixed(2)).join(", ")})`;
}
