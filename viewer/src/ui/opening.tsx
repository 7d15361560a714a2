// Opening another mock-up: files, samples, and what was doubtful about the files that are open.

import { useSignal } from "@preact/signals";
import { chooseFiles, hasWork, openFiles, openSample, reopenIn } from "../actions/opening";
import { UNIT_NAMES, UNITS, type Unit } from "../math/units";
import { useWorkbench } from "./context";
import { Dialog } from "./dialog";
import { Icon } from "./icons";
import { Name } from "./names";

/** What the samples are, in a line; others have their name alone. */
const SAMPLES: Readonly<Record<string, string>> = {
  gearbox: "An accessory gearbox whose parts fit and come out",
  engine: "A whole engine",
  externals: "Pipes, harnesses and brackets around an engine",
  turbine: "Turbine stages with blades",
  differential: "A differential gear",
  carcass: "An engine's casings",
  tay: "A turbofan",
};

/** Files and samples; with files waiting, whether the present mock-up may go. */
export function OpenDialog() {
  const wb = useWorkbench();
  const { store } = wb;
  const opens = store.opens.value;
  const files = store.pending_files.value;
  const name = store.document.value?.mockup?.name;
  if (!opens) return null;
  const close = (): void => {
    store.pending_files.value = [];
    store.dialog.value = null;
  };
  if (files.length > 0) {
    return (
      <Dialog title="Open in place of the present mock-up?" kind="opening">
        <p>
          What was done on <Name text={name ?? "it"} /> ends: removals, answers, measures, requirements, viewpoints and
          findings. Export first what is to stay.
        </p>
        <ul class="file-list">
          {files.slice(0, 8).map((file) => (
            <li key={file.name}>
              <Name text={file.name} />
            </li>
          ))}
          {files.length > 8 && <li class="note">{`and ${files.length - 8} more`}</li>}
        </ul>
        <div class="button-row">
          <button type="button" class="button" onClick={close}>
            Keep the present one
          </button>
          <button type="button" class="button main" onClick={() => void openFiles(wb, files)}>
            Open
          </button>
        </div>
      </Dialog>
    );
  }
  return (
    <Dialog title="Open a mock-up" kind="opening">
      {hasWork(wb) && (
        <p class="note">
          What was done on <Name text={name ?? "the present one"} /> ends with it: removals, measures, viewpoints and
          findings. Export first what is to stay.
        </p>
      )}
      <div class="setting">
        <h3>Files</h3>
        <button type="button" class="button main" onClick={() => chooseFiles(wb)}>
          <Icon name="folder" />
          <span>Choose files</span>
        </button>
        <p class="note">
          {`Or drop them anywhere on the page; several are one mock-up. ${opens.formats.join(" ")}. They stay on the machine of feeler, in a temporary folder until it ends.`}
        </p>
      </div>
      <div class="setting">
        <h3>Samples</h3>
        <ul class="part-list" aria-label="Samples">
          {opens.samples.map((sample) => (
            <li key={sample}>
              <button type="button" class="part-line" onClick={() => void openSample(wb, sample)}>
                <span class="sample-name">{sample}</span>
                <span class="row-name note">{SAMPLES[sample] ?? ""}</span>
              </button>
            </li>
          ))}
        </ul>
      </div>
    </Dialog>
  );
}

/** The doubts of the loaders, and the unit that they most often are about. */
export function DoubtsDialog() {
  const wb = useWorkbench();
  const { store } = wb;
  const doubts = store.document.value?.doubts ?? [];
  const read = store.manifest.value?.unit;
  const chosen = useSignal<Unit>(UNITS.find((unit) => unit === read) ?? "mm");
  return (
    <Dialog title="Doubts about the files" kind="opening">
      {doubts.length === 0 && <p class="note">The loaders found nothing to doubt.</p>}
      <ul class="file-list doubts">
        {doubts.map((doubt) => (
          <li key={doubt}>
            <Icon name="alert" size={16} />
            <bdi>{doubt}</bdi>
          </li>
        ))}
      </ul>
      {store.opens.value && read && (
        <div class="setting">
          <h3>Unit of the numbers</h3>
          <label class="field">
            {`Read in ${unitName(read)}; instead`}
            <select
              value={chosen.value}
              onChange={(event) => {
                chosen.value = event.currentTarget.value as Unit;
              }}
            >
              {UNITS.map((unit) => (
                <option key={unit} value={unit}>
                  {UNIT_NAMES[unit]}
                </option>
              ))}
            </select>
          </label>
          <button
            type="button"
            class="button main"
            disabled={chosen.value === read}
            onClick={() => void reopenIn(wb, chosen.value)}
          >
            Read again
          </button>
          <p class="note">Removals, measures and findings of this mock-up end with it.</p>
        </div>
      )}
    </Dialog>
  );
}

const unitName = (unit: string): string => (unit in UNIT_NAMES ? UNIT_NAMES[unit as Unit] : unit);
