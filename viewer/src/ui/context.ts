// The workbench for components.

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { Workbench } from "../actions/workbench";

export const WorkbenchContext = createContext<Workbench | null>(null);

export function useWorkbench(): Workbench {
  const found = useContext(WorkbenchContext);
  if (!found) throw new Error("a component of the workbench stands outside of it");
  return found;
}
