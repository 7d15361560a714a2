"""Makes the pictures of docs/workbench.md: the workbench on the sample engine, in a real Chromium.

    python tools/workbench_pictures.py [NAME ...] [--out FOLDER] [--type png]

Needs the built page (`make page`), playwright, and a Chromium: $FEELER_CHROMIUM, or one on the PATH. Takes two minutes
on two cores, without a graphics card.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import feeler
from feeler.workbench.server import Server
from feeler.workbench.session import Session

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import chromium

TRIANGLES = 1_600_000
SIZE = (1280, 800)
SHARP_MS = 6000  # in which a view that stands is drawn again and again, and averaged
SETTINGS = '{"has_seen_tour": true, "is_muted": true}'

GEARBOX = "engine/externals/accessory_gearbox"
PUMP, STARTER = f"{GEARBOX}/fuel_pump_1", f"{GEARBOX}/starter_1"
BOLT = np.array([-0.3096, -0.5188, 1.0305])  # the head of bolt_002 of the pump's flange
AT_BOLT = ((-0.47, -0.79, 1.20), (-0.305, -0.545, 1.03))
AT_GEARBOX = ((-0.95, -1.3, 1.66), (-0.22, -0.42, 1.14))


class Desk:
    """A workbench with a page."""

    def __init__(self, session: Session, page: Any) -> None:
        self.session, self.page = session, page

    def command(self, name: str, /, **args: Any) -> dict[str, Any]:
        """A change of the document."""
        return self.session.command(name, args)

    def press(self, *keys: str) -> None:
        """Keys, with the picture in focus."""
        self.page.locator("#picture").focus()
        for key in keys:
            self.page.keyboard.press(key)

    def move(self, pose: np.ndarray) -> np.ndarray:
        """The hand wants to be at a pose (4, 4); where the tool comes."""
        return np.reshape(self.page.evaluate("pose => window.feeler.moveTo(pose)", pose.ravel().tolist()), (4, 4))

    def look(self, eye: tuple[float, float, float], target: tuple[float, float, float]) -> None:
        """From a point to another, by a viewpoint that is there no longer than that."""
        camera = {"position": eye, "target": target, "up": [0, 0, 1], "fov_rad": 0.7}
        number = self.command("viewpoint_add", name="here", camera=camera)["id"]
        self.press("Alt+3")
        self.page.get_by_role("button", name="here", exact=True).click()
        self.command("viewpoint_remove", id=number)

    def shift(self, *by: float) -> None:
        """The hand, from where it is."""
        pose = np.array(self.session.engine.pose)
        pose[:3, 3] += by
        self.command("place", pose=pose.ravel().tolist())

    def seen(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> dict[str, Any]:
        """What a ray meets first."""
        found = self.session.ask("ray", {"origin": origin, "direction": direction})
        assert found is not None, "the ray meets the engine"
        return found

    def search(self, words: str) -> None:
        """In the tree of parts."""
        self.page.locator("#search").fill(words)


def engine(desk: Desk) -> None:
    """All of it, with a tool at work on the gearbox and a part found in the tree."""
    desk.look((-2.9, -3.6, 2.6), (0.12, 0.0, 1.47))
    desk.search("accessory_gearbox housing")
    desk.page.get_by_role("treeitem", name="housing").click()
    desk.press("Alt+1")


def contact(desk: Desk) -> None:
    """A wrench led onto a bolt, gliding: contact planes, the force, clearances."""
    desk.look(*AT_BOLT)
    desk.command("set_mode", mode="glide")
    desk.move(wrench_at_bolt(0.0, -0.01, 0.004))
    desk.move(wrench_at_bolt(0.0, 0.006, -0.004))
    desk.press("Alt+1")


def passing(desk: Desk) -> None:
    """The same wrench where it does not fit, in mode pass: what it cuts."""
    desk.look(*AT_BOLT)
    desk.command("set_mode", mode="pass")
    desk.move(wrench_at_bolt(0.0, 0.004, -0.004))
    desk.press("Alt+1")


def section(desk: Desk) -> None:
    """Cut open along the axis."""
    desk.command("take_tool", name=None)
    desk.look((-2.55, -0.95, 2.1), (0.0, 0.0, 1.62))
    desk.command("section_add", normal=[1.0, 0.0, 0.0], offset=0.0)
    desk.press("Alt+2")


def removal(desk: Desk) -> None:
    """A gearbox that is taken apart, with the starter on its way out."""
    desk.command("take_tool", name=None)
    desk.look(*AT_GEARBOX)
    for name in ("breather", "hydraulic pump"):
        desk.command("grip", parts=f"{GEARBOX}/{name.replace(' ', '_')}_1")
        desk.shift(0.0, 0.0, 0.05)
        desk.shift(0.15, -0.3, 0.0)
        desk.shift(0.5, 0.0, 0.0)
        number = desk.command("release")["id"]
        desk.command("sequence_rename", id=number, name=name)
    desk.command("grip", parts=STARTER)
    desk.shift(0.0, 0.0, 0.05)
    desk.shift(0.0, -0.06, 0.02)
    desk.press("Alt+4")


def measures(desk: Desk) -> None:
    """Two parts, two bolts, two faces; in light colours."""
    desk.command("take_tool", name=None)
    desk.look(*AT_GEARBOX)
    desk.command("measure_add", type="parts", parts=[f"{PUMP}/body", f"{STARTER}/body"], name="pump to starter")
    across = desk.seen((-0.3435, -0.5125, 1.045), (0, 0, -1)), desk.seen((-0.281, -0.5, 1.045), (0, 0, -1))
    desk.command("measure_add", type="point", points=[each["point"] for each in across], name="bolt to bolt")
    faces = desk.seen((-0.24, -0.9, 0.96), (0, 1, 0)), desk.seen((-0.24, -0.52, 1.2), (0, 0, -1))
    desk.command("measure_add", type="angle", triangles=[each["triangle"] for each in faces], name="housing")
    desk.press("Alt+3")


def findings(desk: Desk) -> None:
    """What a clash check found: here the pumps of the gearbox, by their contacts."""
    scene = desk.session.scene
    clashes: list[dict[str, Any]] = []
    for name in ("fuel_pump_1", "starter_1", "hydraulic_pump_1"):
        path = f"{GEARBOX}/{name}/body"
        planes = scene.without(path).contacts(feeler.Tool.of_parts(scene.mockup, path), np.eye(4))
        for part in sorted({int(each) for each in planes.parts}):
            deepest = min((plane for plane in planes if plane.part == part), key=lambda plane: plane.gap)
            other = scene.mockup.part_paths[part]
            clash = {"id": f"{len(clashes) + 1}", "a": path, "b": other, "depth": max(0.0, -deepest.gap)}
            clashes.append({**clash, "point_a": list(map(float, deepest.point)), "group": name})
    desk.session.load_findings({"version": 1, "clashes": clashes})
    desk.command("take_tool", name=None)
    desk.look(*AT_GEARBOX)
    desk.press("Alt+5")
    for _ in range(2):
        desk.press("n")
        desk.page.wait_for_timeout(1000)  # until the others are ghosts


PICTURES: dict[str, Callable[[Desk], None]] = {
    "engine": engine,
    "contact": contact,
    "pass": passing,
    "section": section,
    "removal": removal,
    "measures": measures,
    "findings": findings,
}
LIGHT = {"measures"}


def wrench_at_bolt(*beside: float) -> np.ndarray:
    """world_from_tool (4, 4) of the wrench, flat on the flange, its handle outward, its jaw so far beside the bolt."""
    pose = np.eye(4)
    pose[:3, :3] = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
    pose[:3, 3] = BOLT + beside
    return pose


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    parser.add_argument("--out", type=Path, default=Path(__file__).parent.parent / "docs" / "workbench")
    parser.add_argument("--type", choices=("jpeg", "png"), default="jpeg", help="png: without loss, larger")
    options = parser.parse_args()
    if unknown := {*options.names} - PICTURES.keys():
        parser.error(f"there is no picture {', '.join(sorted(unknown))}")
    path = chromium.found()
    if path is None:
        sys.exit("no Chromium: install one, or name it by FEELER_CHROMIUM")
    options.out.mkdir(parents=True, exist_ok=True)
    mockup, tool = feeler.sample("engine", triangles=TRIANGLES), feeler.sample_tool("wrench")
    scene = feeler.Scene(mockup, tool=tool)
    start = wrench_at_bolt(0.0, -0.05, 0.02)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(chromium.FLAGS))
        for name in options.names or PICTURES:
            with Session() as session, Server(session) as server:
                session.open(mockup, scene, tool, pose=start, name="engine")
                theme = "light" if name in LIGHT else "dark"
                context = browser.new_context(
                    viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme=theme, reduced_motion="reduce"
                )
                context.set_default_timeout(120_000)
                context.add_init_script(f"localStorage.setItem('feeler.settings', '{SETTINGS}')")
                page = context.new_page()
                page.goto(server.url)
                page.wait_for_function("() => window.feeler && window.feeler.ready")
                PICTURES[name](Desk(session, page))
                page.wait_for_timeout(SHARP_MS)
                path = options.out / f"{name}.{'jpg' if options.type == 'jpeg' else 'png'}"
                quality = {"quality": 85} if options.type == "jpeg" else {}
                path.write_bytes(page.screenshot(type=options.type, **quality))
                print(f"{path}: {path.stat().st_size} bytes")
                context.close()
        browser.close()


if __name__ == "__main__":
    main()
