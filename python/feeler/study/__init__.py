"""The paper's experiments, repeated on mock-ups and tools of your choice: voxel size, hashing, scaling, filters; and,
not in the paper, the piece size of blocks.

Each study is a function that measures its cells (a mock-up and a tool, as a rule), keeps each finished one in a folder,
and writes there: `results.json`, `samples.csv` (every measured time), plots (PNG and SVG) and `index.html`, which
explains itself.
"""

from .filters import study_filters
from .hashing import study_hashing
from .piece_size import study_piece_size
from .scaling import study_scaling
from .subjects import Plan, Subject
from .voxel_size import study_voxel_size

__all__ = ["Plan", "Subject", "study_filters", "study_hashing", "study_piece_size", "study_scaling", "study_voxel_size"]
