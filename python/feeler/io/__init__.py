"""Files: mock-ups and tools from STL, OBJ, PLY, OFF, glTF/GLB, 3MF, STEP and COLLADA; GLB, STL and CSV output.

    find files -> detect the format -> read (plain arrays, names, notes) -> metres -> Mockup
    Mockup, Tool -> Body (triangles with parts and colours) -> GLB, STL

Each format has its own reader. It keeps the file's triangle order and part names, reports its defects, and checks every
count against the size of the file before using it. General mesh libraries reorder, merge or drop triangles, which is
not acceptable where every contact counts. OpenCASCADE triangulates STEP.
"""

from feeler.atomic import check_target
from feeler.errors import WriteError
from feeler.io.body import Body, Mark, MeshLike, body_of, with_marks
from feeler.io.csv_table import csv_table
from feeler.io.export import Motion, animated_glb, write_glb, write_stl
from feeler.io.load import load_mockup, load_tool
from feeler.io.step import DEFAULT_CHORD_TOLERANCE
from feeler.io.units import KNOWN_UNITS

__all__ = [
    "DEFAULT_CHORD_TOLERANCE",
    "KNOWN_UNITS",
    "Body",
    "Mark",
    "MeshLike",
    "Motion",
    "WriteError",
    "animated_glb",
    "body_of",
    "check_target",
    "csv_table",
    "load_mockup",
    "load_tool",
    "with_marks",
    "write_glb",
    "write_stl",
]
