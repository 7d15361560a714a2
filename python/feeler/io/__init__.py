"""Files: mock-ups and tools out of STL, OBJ, PLY, OFF, glTF/GLB, 3MF, STEP, COLLADA; GLB, STL and CSV into
files.

    find files -> tell the format -> read (plain arrays, names, notes) -> metres -> Mockup
    Mockup, Tool -> Body (triangles with parts and colours) -> GLB, STL

Each format has a reader of its own that keeps the file's triangle order, its part names and whatever is wrong with it,
and checks every count against the size of the file before it believes it. General mesh libraries reorder, merge or
drop, which a tool that must find every contact cannot have. STEP is triangulated by OpenCASCADE.
"""

from feeler.errors import WriteError
from feeler.io.atomic import check_target
from feeler.io.body import Body, Mark, body_of, with_marks
from feeler.io.csv_table import csv_table
from feeler.io.export import write_glb, write_stl
from feeler.io.load import load_mockup, load_tool
from feeler.io.step import DEFAULT_CHORD_TOLERANCE
from feeler.io.units import KNOWN_UNITS

__all__ = [
    "DEFAULT_CHORD_TOLERANCE",
    "KNOWN_UNITS",
    "Body",
    "Mark",
    "WriteError",
    "body_of",
    "check_target",
    "csv_table",
    "load_mockup",
    "load_tool",
    "with_marks",
    "write_glb",
    "write_stl",
]
