"""Fills the tables of docs/access.md from bench/records/reaching.json. They are not edited by hand.

python bench/reaching/figures.py             write them
python bench/reaching/figures.py --check     1 if the page does not match the record
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

from reaching.tables import SECTION

if __name__ == "__main__":
    sys.exit(SECTION.figures())
