"""Puts the figures of the studies into docs/voxel-size-figures.md, and two plots into docs/voxel-size/.

python tools/study_docs.py [STUDY_FOLDER]     feeler-study, the folder of `make study`
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))

from feeler.study.page import markdown  # noqa: E402
from feeler.study.tables import sections_of  # noqa: E402

PAGE, PICTURES = ROOT / "docs" / "voxel-size-figures.md", ROOT / "docs" / "voxel-size"
# Marker in the page: folder of the study.
STUDIES = {
    "voxel-size": "voxel-size",
    "real-models": "real/voxel-size",  # feeler study voxel-size --mockups FILES --out feeler-study/real
    "hashing": "hashing",
    "scaling": "scaling",
    "filters": "filters",
    "piece-size": "piece-size",
}
# The rest is on the page that each study leaves in its folder: a table of all pairs, and the other plots.
LEFT_OUT = ("Table 2", "Times", "Times, µs", "Pairs")
PLOTS = ("voxel-size", "scaling")


def fragment(folder: Path, name: str) -> str:
    """The tables and the plot of one study."""
    results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    parts = []
    for number, section in enumerate(one for one in sections_of(results) if one.title not in LEFT_OUT):
        parts += [f"**{section.title}.**"] if section.title else []
        parts += section.text
        parts += [markdown(section)] if section.rows else []
        picture = folder / f"{folder.name}.png"
        if number == 0 and name in PLOTS and picture.is_file():
            PICTURES.mkdir(exist_ok=True)
            shutil.copyfile(picture, PICTURES / f"{name}.png")
            parts += [f"![{name}](voxel-size/{name}.png)", *filter(None, [section.caption])]
    machine = results["machine"]
    parts.append(
        f"{machine['cpu']}, {machine['cores']} cores, feeler {machine['feeler']}; `feeler study {folder.name}`."
    )
    return "\n\n".join(parts)


def main() -> int:
    source = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "feeler-study")
    page = PAGE.read_text(encoding="utf-8")
    for name, where in STUDIES.items():
        begin, end = f"<!-- {name}: tools/study_docs.py -->", f"<!-- end of {name} -->"
        if not (source / where / "results.json").is_file():
            print(f"{source / where} holds no results: left as it is")
            continue
        before, rest = page.split(begin)
        page = f"{before}{begin}\n\n{fragment(source / where, name)}\n\n{end}{rest.split(end)[1]}"
    PAGE.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
