// The page: a grid of bar, tree, picture, panels and status line.

import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { hint } from "../actions/commands";
import type { Workbench } from "../actions/workbench";
import { PANELS, type Panel } from "../model/page-state";
import { Bar } from "./bar";
import { AskPanel } from "./cards";
import { useWorkbench, WorkbenchContext } from "./context";
import { AllHidden, Banner, Covers, DropCover, Notices, RecordBar } from "./covers";
import { Side } from "./drawer";
import { CommandButton } from "./fields";
import { FindingPanel } from "./findings";
import { FirstRun } from "./first-run";
import { Help } from "./help";
import { Icon, type IconName } from "./icons";
import { MeasurePanel } from "./measures";
import { MechanismPanel } from "./mechanism";
import { ContextMenu } from "./menu";
import { DoubtsDialog, OpenDialog } from "./opening";
import { Palette } from "./palette";
import { PeopleDialog, TurnBar } from "./people";
import { PosePanel } from "./poses";
import { Preferences } from "./preferences";
import { SectionPanel } from "./sections";
import { SequencePanel } from "./sequence";
import { StatusLine } from "./status";
import { TaskPanel } from "./task";
import { Tour } from "./tour";
import { Tree } from "./tree";

/** The elements that the page draws on: made before the components, which only place them. */
export interface PictureElements {
  readonly canvas: HTMLCanvasElement;
  readonly labels: HTMLElement;
  readonly cuts: HTMLElement;
  readonly gizmo: HTMLCanvasElement;
  readonly tether: HTMLElement;
  readonly arrow: HTMLButtonElement;
  readonly cube: HTMLButtonElement;
  readonly triad: HTMLCanvasElement;
  readonly scale: HTMLElement;
  readonly legend: HTMLElement;
}

export function App({ workbench, picture }: { workbench: Workbench; picture: PictureElements }) {
  const { dialog, is_narrow, is_tree_shown, are_panels_shown } = workbench.store;
  const [hasTree, hasPanels] = [is_tree_shown.value, are_panels_shown.value];
  const sides = is_narrow.value
    ? `narrow ${hasPanels ? "with-panels" : ""}`
    : `${hasTree ? "" : "no-tree"} ${hasPanels ? "" : "no-panels"}`;
  return (
    <WorkbenchContext.Provider value={workbench}>
      <div class={`page ${sides}`}>
        <Bar />
        {hasTree && (
          <Side side="tree" title="Parts">
            <Tree />
          </Side>
        )}
        <Picture picture={picture} />
        {hasPanels && (
          <Side side="panels" title="Panels">
            <Panels />
          </Side>
        )}
        <StatusLine />
      </div>
      <Tour />
      {dialog.value === "palette" && <Palette />}
      {dialog.value === "help" && <Help />}
      {dialog.value === "open" && <OpenDialog />}
      {dialog.value === "doubts" && <DoubtsDialog />}
      {dialog.value === "settings" && <Preferences />}
      {dialog.value === "people" && <PeopleDialog />}
      <Notices />
      <DropCover />
    </WorkbenchContext.Provider>
  );
}

function Picture({ picture }: { picture: PictureElements }) {
  const wb = useWorkbench();
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    place.current?.append(picture.canvas, picture.labels, picture.cuts, picture.tether, picture.gizmo);
    place.current?.append(picture.triad, picture.scale, picture.legend, picture.cube, picture.arrow);
    wb.redraw();
  }, []);
  const { store } = wb;
  const sections = store.document.value?.sections ?? [];
  return (
    <main class="picture">
      <div ref={place} class="picture-place" />
      <div class="toolbar" role="toolbar" aria-label="View" aria-orientation="vertical">
        <CommandButton id="fit" icon="fit" />
        <CommandButton id="sections" icon="section" pressed={sections.some((section) => section.is_on)} />
        <CommandButton id="measure" icon="measure" pressed={store.measuring.value !== null} />
        <CommandButton id="explode" icon="explode" pressed={(store.document.value?.explode ?? 0) > 0} />
        <CommandButton id="snapshot" icon="camera" />
      </div>
      <div class="toolbar view-tools" role="toolbar" aria-label="Projection and home view">
        <CommandButton id="home" icon="home" />
        <CommandButton id="projection" icon="parallel" pressed={store.settings.value.is_parallel} />
      </div>
      <Banner />
      <RecordBar />
      <AllHidden />
      <TurnBar />
      <FirstRun />
      <Covers />
      <ContextMenu />
    </main>
  );
}

const TABS: Readonly<Record<Panel, { icon: IconName; text: string }>> = {
  pose: { icon: "move", text: "Pose" },
  ask: { icon: "help", text: "Ask" },
  sections: { icon: "section", text: "Sections" },
  measures: { icon: "measure", text: "Measures" },
  mechanism: { icon: "turn", text: "Joints" },
  task: { icon: "spanner", text: "Task" },
  sequence: { icon: "list", text: "Sequence" },
  findings: { icon: "alert", text: "Findings" },
};

const BODIES = {
  pose: PosePanel,
  ask: AskPanel,
  sections: SectionPanel,
  measures: MeasurePanel,
  mechanism: MechanismPanel,
  task: TaskPanel,
  sequence: SequencePanel,
  findings: FindingPanel,
} as const;

function Panels() {
  const { store } = useWorkbench();
  const current = store.panel.value;
  const Body = BODIES[current];
  const joints = current === "mechanism" || store.document.value?.mechanism != null;
  const shown = joints ? PANELS : PANELS.filter((panel) => panel !== "mechanism");
  const go = (event: KeyboardEvent): void => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const next = shown[(shown.indexOf(current) + step + shown.length) % shown.length] ?? current;
    store.panel.value = next;
  };
  // The focus stays on the selected tab, however it was selected. Asked before the focused tab may go.
  const isTabFocused = document.activeElement?.getAttribute("role") === "tab";
  useLayoutEffect(() => {
    if (isTabFocused) document.getElementById(`tab-${current}`)?.focus();
  }, [current]);
  return (
    <aside id="panels" class="panels" aria-label="Panels">
      <div class="tabs" role="tablist" aria-label="Panels" onKeyDown={go}>
        {shown.map((panel) => (
          <button
            type="button"
            key={panel}
            id={`tab-${panel}`}
            role="tab"
            aria-selected={panel === current}
            aria-controls="panel"
            tabIndex={panel === current ? 0 : -1}
            title={hint(`panel-${panel}`)}
            onClick={() => {
              store.panel.value = panel;
            }}
          >
            <Icon name={TABS[panel].icon} size={16} />
            <span>{TABS[panel].text}</span>
          </button>
        ))}
      </div>
      {/* biome-ignore lint/a11y/noNoninteractiveTabindex: a panel that scrolls has to be reached by keys */}
      <div id="panel" class="panel" role="tabpanel" aria-labelledby={`tab-${current}`} tabIndex={0}>
        <Body />
      </div>
    </aside>
  );
}
