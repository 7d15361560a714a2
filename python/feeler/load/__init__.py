"""Load mock-ups and tools from files: STL, OBJ, PLY, OFF, glTF/GLB, 3MF, STEP, COLLADA.

    find files -> tell the format -> read (plain arrays, names, notes) -> metres -> Mockup

Each format has a reader of its own that keeps the file's triangle order, its part names and whatever is wrong with it,
and checks every count against the size of the file before it believes it. General mesh libraries reorder, merge or
drop, which a tool that must find every contact cannot have. STEP is triangulated by OpenCASCADE.
"""

from feeler.load.api import load_mockup, load_tool
from feeler.load.step import DEFAULT_CHORD_TOLERANCE
from feeler.load.units import KNOWN_UNITS

__all__ = ["DEFAULT_CHORD_TOLERANCE", "KNOWN_UNITS", "load_mockup", "load_tool"]
