"""Fills the tables of docs/task.md from bench/records/maintain.json. They are not edited by hand.

python bench/maintain/figures.py             write them
python bench/maintain/figures.py --check     1 if the page does not match the record
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from maintain.tables import SECTION

if __name__ == "__main__":
    sys.exit(SECTION.figures())
