"""Makes the picture of docs/report.md: the report of a project of the sample gearbox, in a real Chromium.

    python tools/report_picture.py [--out FILE]

Needs the built page (`make page`), playwright, and a Chromium: $FEELER_CHROMIUM, or one on the PATH.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

import feeler
from feeler.cli import app
from feeler.io import write_glb
from feeler.project.book import open_or_make
from feeler.workbench.session.session import Session

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import chromium

SIZE = (1120, 1180)
WAIT_S = 300.0
RETAINER = "gearbox/bracket/left_mount/retainer"
REQUIREMENTS = (
    ("Pressure pipe to bracket", "*pressure_pipe/pipe*", "*bracket/*", 0.005),
    ("Oil filter to covers", "*oil_filter*", "*covers*", 0.001),
    ("Starter to lines", "*starter*", "*lines*", 0.002),
)


def project(folder: Path) -> Path:
    """A project with requirements, findings, a question and work steps."""
    faults = ["pipe_clash", "missing_hole", "duplicate", "inside"]
    write_glb(folder / "gearbox.glb", feeler.sample("gearbox", 100_000, faults=faults))
    mockup = feeler.load_mockup(folder / "gearbox.glb")
    path = folder / "gearbox.feelproj"
    session = Session(project=open_or_make(path), has_threads=False)
    session.open(mockup, feeler.Scene(mockup), None, name="gearbox.glb")
    session.command("clash_settings", {"clearance": 0.0, "contact": 0.0009})
    taken = session.job("clash", {}).result(WAIT_S)
    session.command("findings_take", {"key": taken["key"]})
    for name, a, b, gap in REQUIREMENTS:
        session.command("requirement_add", {"name": name, "a": a, "b": b, "gap": gap})
    session.command("requirements_checked", {"results": session.job("verify", {}).result(WAIT_S)})
    session.command("ask", {"question": "order", "parts": [RETAINER], "seconds": 20})
    until = time.monotonic() + WAIT_S
    while any(card.state in ("waiting", "running") for card in session.current.cards) and time.monotonic() < until:
        time.sleep(0.1)
    session.command("way_take", {"id": 1})
    session.close()
    return path


def main() -> None:
    """Makes the project, its report, and the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("docs/report/report.jpg"))
    out = parser.parse_args().out
    found = chromium.found()
    if found is None:
        sys.exit("no Chromium: install one, or name it by FEELER_CHROMIUM")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        path = project(Path(folder))
        html = Path(folder) / "report.html"
        words = ["report", str(path), str(path.with_name("gearbox.glb")), "--html", str(html), "--pictures", "12"]
        app(words, standalone_mode=False)
        browser = play.chromium.launch(executable_path=found, args=[*chromium.FLAGS])
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light")
        page.goto(html.as_uri())
        out.parent.mkdir(exist_ok=True)
        page.screenshot(path=out, type="jpeg", quality=78)
        browser.close()


if __name__ == "__main__":
    main()
