// Measures and viewpoints.

import { lookFrom } from "../actions/exports";
import { MEASURE_TITLES, PICKS, startMeasuring, stopMeasuring } from "../actions/measures";
import type { Measure, MeasureType } from "../link/protocol";
import { UNITS } from "../math/units";
import { revisionText } from "../model/stale";
import { useWorkbench } from "./context";
import { Choice, CommandButton, IconButton, NameField } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";
import { measureText } from "./words";

const TYPES = Object.keys(MEASURE_TITLES) as MeasureType[];

export function MeasurePanel() {
  const wb = useWorkbench();
  const { store } = wb;
  const document = store.document.value;
  const measuring = store.measuring.value;
  const isLocked = store.is_read_only.value;
  const measures = document?.measures ?? [];
  const viewpoints = document?.viewpoints ?? [];
  return (
    <div class="panel-body">
      <section>
        <h2>Measure</h2>
        <div class="button-grid">
          {TYPES.map((type) => (
            <button
              type="button"
              class="button"
              key={type}
              aria-pressed={measuring?.type === type}
              disabled={type === "point" ? !store.can_look.value : isLocked}
              onClick={() => startMeasuring(wb, type)}
            >
              <Icon name="measure" size={14} />
              <span>{MEASURE_TITLES[type]}</span>
            </button>
          ))}
        </div>
        {measuring && (
          <div class="hint-bar" role="status">
            <span>{PICKS[measuring.type][measuring.picks.length]}</span>
            <IconButton icon="close" label="End measuring" run={() => stopMeasuring(wb)} />
          </div>
        )}
        <ul class="card-list" aria-label="Measures">
          {measures.map((measure) => (
            <MeasureCard key={measure.id} measure={measure} />
          ))}
        </ul>
        {measures.length === 0 && !measuring && (
          <p class="note">
            Clicks snap to corners and edges. Distances between parts are exact, with their nearest points.
          </p>
        )}
      </section>
      <section>
        <h2>Unit</h2>
        <Choice
          label="Unit of lengths"
          value={store.unit.value}
          options={UNITS.map((unit) => ({ value: unit, text: unit }))}
          disabled={!store.can_look.value}
          choose={(unit) => wb.run("set_unit", { unit })}
        />
      </section>
      <section>
        <h2>Viewpoints</h2>
        <div class="button-row">
          <CommandButton id="snapshot" icon="camera" text="Picture and viewpoint" />
        </div>
        <ul class="card-list" aria-label="Viewpoints">
          {viewpoints.map((viewpoint) => (
            <li class="line" key={viewpoint.id}>
              <button type="button" class="part-line" onClick={() => lookFrom(wb, viewpoint)}>
                <Icon name="eye" size={14} />
                <Name text={viewpoint.name} />
              </button>
              <IconButton
                icon="trash"
                label={`Remove ${viewpoint.name}`}
                disabled={isLocked}
                run={() => wb.run("viewpoint_remove", { id: viewpoint.id })}
              />
            </li>
          ))}
        </ul>
      </section>
    </div>
  );
}

function MeasureCard({ measure }: { measure: Measure }) {
  const wb = useWorkbench();
  const { store } = wb;
  const isLocked = !store.can_look.value;
  const earlier = revisionText(measure.stale, (part) => store.nameOf(part));
  return (
    <li class="line">
      <NameField
        label={`Name of ${measure.name}`}
        value={measure.name}
        disabled={isLocked}
        change={(name) => wb.run("measure_edit", { id: measure.id, name })}
      />
      <output
        class="value"
        title={measure.is_exact ? "Exact: computed by the engine on the triangles" : "Read from the picture"}
      >
        {earlier && (
          <strong class="stale" title={earlier}>
            earlier revision{" "}
          </strong>
        )}
        {measure.is_exact ? "" : "≈ "}
        {measureText(measure, store.unit.value)}
      </output>
      <IconButton
        icon="trash"
        label={`Remove ${measure.name}`}
        disabled={isLocked}
        run={() => wb.run("measure_remove", { id: measure.id })}
      />
    </li>
  );
}
