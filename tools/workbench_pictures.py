"""Makes the pictures of docs/workbench.md: the workbench on the sample engine and gearbox, in a real Chromium.

    python tools/workbench_pictures.py [NAME ...] [--out FOLDER] [--type png]

Needs the built page (`make page`), playwright, and a Chromium: $FEELER_CHROMIUM, or one on the PATH. Takes two minutes
on two cores, without a graphics card.
"""

from __future__ import annotations

import argparse
import functools
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import feeler
from feeler.workbench.net.server import Server
from feeler.workbench.session.session import Session

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import chromium

SIZE = (1280, 800)
SHARP_MS = 6000  # in which a view that stands is drawn again and again, and averaged
TURN_MS = 2000  # after which this script, which set the scene, has let go of the tool
SETTINGS = '{"has_seen_tour": true, "has_first_run": false, "is_muted": true}'

PUMP, STARTER, COVER = "gearbox/oil_pump", "gearbox/starter", "gearbox/covers/main_front"
UNION_NUT = "gearbox/lines/return_hose/union_nut_1"
AT_NUT = ((0.115, -0.21, 0.29), (0.195, -0.045, 0.13))
AT_TOP = ((-0.15, -0.42, 0.46), (0.03, -0.03, 0.12))
AT_BOLT = np.array([-0.3096, -0.5688, 1.0505])  # by the head of bolt_002 of a pump's flange of the engine
OUTSIDE = np.array([0.25, -0.10, 0.20])  # of the gearbox
ACROSS = np.pi / 4  # the wrench's handle over the side of the bracket
FLAT = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])  # the wrench's handle outward


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
        self.page.wait_for_timeout(TURN_MS)
        return np.reshape(self.page.evaluate("pose => window.feeler.moveTo(pose)", pose.ravel().tolist()), (4, 4))

    def look(self, eye: tuple[float, float, float], target: tuple[float, float, float]) -> None:
        """From a point to another, by a viewpoint that is there no longer than that."""
        camera = {"position": eye, "target": target, "up": [0, 0, 1], "fov_rad": 0.7}
        number = self.command("viewpoint_add", name="here", camera=camera)["id"]
        self.press("Alt+4")
        self.page.get_by_role("button", name="here", exact=True).click()
        self.command("viewpoint_remove", id=number)

    def shift(self, *by: float) -> None:
        """The hand, from where it is."""
        pose = np.array(self.session.engine.pose)
        pose[:3, 3] += by
        self.command("place", pose=pose.ravel().tolist())

    def seen(self, origin: tuple[float, ...], direction: tuple[float, ...]) -> dict[str, Any]:
        """The first hit of a ray."""
        found = self.session.ask("ray", {"origin": origin, "direction": direction})
        assert found is not None, "the ray meets the mock-up"
        return found

    def above(self, path: str) -> dict[str, Any]:
        """The first hit of a ray from high above the middle of a part."""
        x, y, z = self.middle(path)
        return self.seen((x, y, z + 1.0), (0.0, 0.0, -1.0))

    def middle(self, path: str) -> np.ndarray:
        """Of a part's box, or of that of a group's parts, where they were loaded (3,)."""
        mockup = self.session.scene.mockup
        rows = [k for k, each in enumerate(mockup.part_paths) if each == path or each.startswith(f"{path}/")]
        boxes = mockup.part_bounds.reshape(-1, 2, 3)[rows]
        middle: np.ndarray = (boxes[:, 0].min(axis=0) + boxes[:, 1].max(axis=0)) / 2.0
        return middle

    def wrench_at_nut(self, back: float) -> np.ndarray:
        """world_from_tool (4, 4) of the wrench, flat at the union nut, its jaw so far before it."""
        pose = flat(self.middle(UNION_NUT), ACROSS)
        pose[:3, 3] += back * pose[:3, 2]
        return pose

    def ask(self, question: str, parts: list[str], **args: Any) -> None:
        """A question, and its answer opened."""
        number = self.command("ask", question=question, parts=parts, **args)["id"]
        self.press("Alt+2")
        self.page.wait_for_function(
            "id => window.feeler.document.cards.some(card => card.id === id && card.state === 'done')", arg=number
        )
        card = self.page.locator("#panel li.question").first
        if card.locator("button[aria-expanded=true]").count() == 0:
            card.locator("button[aria-expanded]").click()

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
    """A wrench led onto a union nut, gliding: contact planes, the force, clearances."""
    desk.look(*AT_NUT)
    desk.command("set_mode", mode="glide")
    desk.move(desk.wrench_at_nut(0.05))
    desk.move(desk.wrench_at_nut(0.006))
    desk.press("Alt+1")


def passing(desk: Desk) -> None:
    """The same wrench where it does not fit, in mode pass: the parts that it cuts."""
    desk.look(*AT_NUT)
    desk.command("set_mode", mode="pass")
    desk.move(desk.wrench_at_nut(0.004))
    desk.press("Alt+1")


def section(desk: Desk) -> None:
    """Cut open through the shafts."""
    desk.command("take_tool", name=None)
    desk.look((0.0, -0.5, 0.25), (0.05, 0.0, 0.05))
    desk.command("section_add", normal=[0.0, 1.0, 0.0], offset=float(desk.middle(f"{PUMP}/drive_shaft")[1]))
    desk.press("Alt+3")


def clear_starter(desk: Desk) -> None:
    """The starter's nuts and washers are taken out and laid aside."""
    for name, parts, aside in (("nuts", "nut_*", 0.2), ("washers", "washer_*", 0.0)):
        desk.command("grip", parts=f"{STARTER}/{parts}")
        desk.shift(0.0, 0.0, 0.12)
        desk.shift(-0.5, aside, 0.0)
        number = desk.command("release")["id"]
        desk.command("sequence_rename", id=number, name=name)


def removal(desk: Desk) -> None:
    """A gearbox that is taken apart: a starter whose nuts and washers are out, on its way."""
    desk.command("take_tool", name=None)
    desk.look(*AT_TOP)
    clear_starter(desk)
    desk.command("grip", parts=[f"{STARTER}/{name}" for name in ("body", "o_ring", "terminal_*")])
    desk.shift(0.0, 0.0, 0.06)
    desk.press("Alt+5")


def measures(desk: Desk) -> None:
    """Two parts, two nuts, two faces; in light colours."""
    desk.command("take_tool", name=None)
    desk.look(*AT_TOP)
    desk.command("measure_add", type="parts", parts=[f"{PUMP}/body", f"{STARTER}/body"], name="pump to starter")
    across = [desk.above(f"{PUMP}/stud_{number}") for number in (3, 5)]
    desk.command("measure_add", type="point", points=[each["point"] for each in across], name="stud to stud")
    faces = desk.seen((0.12, -0.15, 0.05), (0, 1, 0)), desk.seen((0.12, -0.08, 0.5), (0, 0, -1))
    desk.command("measure_add", type="angle", triangles=[each["triangle"] for each in faces], name="housing")
    desk.press("Alt+4")


def findings(desk: Desk) -> None:
    """A clash check of the page: a pipe that was drawn into its bracket, beside it the clips of hoses that touch."""
    desk.command("take_tool", name=None)
    desk.look((0.22, -0.42, 0.30), (0.06, -0.1, 0.13))
    desk.press("Alt+6")
    desk.page.get_by_role("button", name="Check clashes").click()
    desk.page.wait_for_function("() => (window.feeler.document.findings?.count ?? 0) > 0")
    desk.press("n")
    desk.page.wait_for_timeout(1000)  # until the others are ghosts


def way(desk: Desk) -> None:
    """Can it come out: the film of the starter's way, half way, with the curve of its gap."""
    desk.command("take_tool", name=None)
    desk.look(*AT_TOP)
    clear_starter(desk)
    desk.ask("removal", [f"{STARTER}/{name}" for name in ("body", "drive_shaft", "o_ring", "terminal_*")])
    desk.page.locator("#panel").get_by_role("slider").fill("450")


def reach(desk: Desk) -> None:
    """Which tool reaches its bolts: heads in the colours of the answer, tool and hand in the seat, the swing a fan."""
    x, y, z = desk.middle(COVER).tolist()
    desk.look((x - 0.25, y - 0.35, z - 0.35), (x, y, z))
    desk.command("hide", parts=["gearbox/door", "gearbox/bracket"])
    desk.ask("access", [f"{COVER}/bolt_*"], catalogue=True)
    desk.page.locator("#panel ul.reaches li.is-good button").first.click()


@dataclass(frozen=True)
class Picture:
    """A picture and its mock-up: a name of `feeler.sample`, its triangles, the faults planted."""

    show: Callable[[Desk], None]
    sample: tuple[str, int, tuple[str, ...]] = ("gearbox", 400_000, ())
    theme: str = "dark"

    @property
    def start(self) -> np.ndarray:
        """Where the tool is at first."""
        return flat(AT_BOLT, 0.0) if self.sample[0] == "engine" else flat(OUTSIDE, ACROSS)


PICTURES = {
    "engine": Picture(engine, ("engine", 1_600_000, ())),
    "contact": Picture(contact),
    "pass": Picture(passing),
    "section": Picture(section),
    "removal": Picture(removal),
    "way": Picture(way, ("gearbox", 100_000, ())),
    "reach": Picture(reach, ("gearbox", 100_000, ()), theme="light"),
    "measures": Picture(measures, theme="light"),
    "findings": Picture(findings, ("gearbox", 400_000, ("pipe_clash",))),
}


def flat(place: np.ndarray, turn: float) -> np.ndarray:
    """world_from_tool (4, 4) of the wrench, lying flat with its jaw at a place, turned about z by so much (radians)."""
    pose = np.eye(4)
    cos, sin = np.cos(turn), np.sin(turn)
    pose[:3, :3], pose[:3, 3] = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ FLAT, place
    return pose


@functools.cache
def indexed(name: str, triangles: int, faults: tuple[str, ...]) -> feeler.Scene:
    """A sample, for the wrench, with z up as the pictures have it (`feeler view --up z`)."""
    mockup = feeler.sample(name, triangles=triangles, faults=faults)
    mockup.source = replace(mockup.source, up="z")
    return feeler.Scene(mockup, tool=feeler.sample_tool("wrench"))


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
    tool = feeler.sample_tool("wrench")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(chromium.FLAGS))
        for name in options.names or PICTURES:
            picture = PICTURES[name]
            scene = indexed(*picture.sample)
            with Session() as session, Server(session) as server:
                session.open(scene.mockup, scene, tool, pose=picture.start, name=picture.sample[0])
                context = browser.new_context(
                    viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme=picture.theme, reduced_motion="reduce"
                )
                context.set_default_timeout(120_000)
                context.add_init_script(f"localStorage.setItem('feeler.settings', '{SETTINGS}')")
                page = context.new_page()
                page.goto(server.url)
                page.wait_for_function("() => window.feeler && window.feeler.ready")
                picture.show(Desk(session, page))
                page.wait_for_timeout(SHARP_MS)
                path = options.out / f"{name}.{'jpg' if options.type == 'jpeg' else 'png'}"
                quality = {"quality": 85} if options.type == "jpeg" else {}
                path.write_bytes(page.screenshot(type=options.type, **quality))
                print(f"{path}: {path.stat().st_size} bytes")
                context.close()
        browser.close()


if __name__ == "__main__":
    main()
