"""The bracket that carries the gearbox: mounts, hangers, beam, and a door under the filter on hinges. Millimetres."""

from __future__ import annotations

import numpy as np

from ..mesh import Floats, at, times
from . import standard
from .assembly import pull, turn
from .bodies import Drill, extruded, flanged, plate
from .design import AWAY, OUT, Workshop, X, Y, frame
from .fits import METRIC, deviation, play
from .housing import SideHole, tapped
from .layout import GASKET, REAR, TAPPED
from .lines import loop_outline
from .polygon import rounded
from .solid import Cut, Solid

MOUNT_BOLTS = ((22.0, 9.0), (-22.0, 9.0), (-22.0, -9.0), (22.0, -9.0))
MOUNT_Z = 58.0
HANGER, GAP = 14.0, 22.0
BEAM_Z = (95.0, 137.0)
RAILS = {"front": (-5.0, 15.0), "rear": (120.5, 140.5)}
PANEL = (17.0, 117.5)
PANEL_THICK, RAIL_THICK, LEAF = 4.0, 10.0, 3.0
DOOR_OPEN = np.deg2rad(178.0)
"""The panel is folded under the rear rail: it would collide there with the screws of the fixed leaves."""
HINGE_Z, HINGE_LOW, KNUCKLE, PIN = 119.0, 3.4, 3.45, 1.6
LATCH_Z, LATCH_ROD = 34.0, 2.0
LATCH_BAR = (-14.0, 22.0, 7.0)
"""The latch's bar: its ends along its length, and half its width."""
LATCH_STOP = 9.25
"""From the latch's axis to its stop, along and across the bar, which turns from one side of the stop to another."""
REBATE, REBATE_GAP = 6.0, 0.3
"""The front rail's edge over the panel, which stops the door, and the gap between the two."""


def side_holes(shop: Workshop) -> list[SideHole]:
    """The holes of the mounts in both ends of the rear case."""
    out = []
    for side, sign in (("left", -1.0), ("right", 1.0)):
        middle, flat = float(shop.plan.side(side)[1][1]), float(shop.plan.flat(side)[1])
        for z, y in MOUNT_BOLTS:
            out.append(SideHole(side, sign * (flat + y - middle), MOUNT_Z + z - GASKET, tapped(shop.cut, 6, TAPPED)))
    return out


class Stand:
    """The bracket's measures."""

    def __init__(self, shop: Workshop) -> None:
        plan = shop.plan
        self.top = float(plan.side("top")[1][1]) + 45.0
        self.door = float(plan.side("bottom")[1][1]) - 146.0
        self.ends = {s: float(plan.side(s)[1][0]) for s in ("left", "right")}
        self.middle = {s: float(plan.flat(s)[1]) for s in ("left", "right")}
        self.inner = {"left": self.ends["left"] - GAP, "right": self.ends["right"] + GAP}
        self.beam = "bracket/beam"

    def beam_face(self, x: float) -> Floats:
        """The frame on the front of the beam."""
        return frame((x, self.top + 20.0, BEAM_Z[0]), (0.0, 0.0, -1.0), X)


def across(x: float) -> Floats:
    """The frame of shapes extruded along x: its own x is -z, its own y is y."""
    return frame((x, 0.0, 0.0), X, (0.0, 0.0, -1.0))


def bracket(shop: Workshop, box_x: float, box_screws: tuple[tuple[float, float], ...]) -> Stand:
    """Beam, hangers, mounts and rails."""
    asm, cut, s = shop.asm, shop.cut, Stand(shop)
    rear = OUT + REAR.name
    length = s.inner["right"] - s.inner["left"]
    y0, y1 = s.top, s.top + 40.0
    z0, z1 = BEAM_Z
    corners = ((-z1, y0), (-z0, y0), (-z0, y1), (-z1, y1))
    beam_bolts = ((-(z0 + z1) / 2.0, y0 + 10.0), (-(z0 + z1) / 2.0, y0 + 30.0))
    pits = tuple((x, y, tapped(cut, 8, 18.0)) for x, y in beam_bolts)
    drills = tuple(
        Drill(1, s.top + 20.0 + y - y0, box_x + x - s.inner["left"], tapped(cut, 4, 10.0)) for x, y in box_screws
    )
    asm.stays[s.beam] = "it carries all others"
    asm.add(
        s.beam, "painted steel", extruded, corners, 0.0, length, drills, (), (pits, pits), pose=across(s.inner["left"])
    )
    rails = {}
    for name, (low, high) in RAILS.items():
        line = [(-high, s.door), (-low, s.door), (-low, s.door + RAIL_THICK), (-high, s.door + RAIL_THICK)]
        if name == "front":
            edge = s.door + PANEL_THICK + REBATE_GAP
            line = [*line[:3], (-high - REBATE, line[3][1]), (-high - REBATE, edge), (-high, edge)]
        pit = ((-(low + high) / 2.0, s.door + RAIL_THICK / 2.0, tapped(cut, 6, 14.0)),)
        below = tuple(
            Drill(0, high - HINGE_Z - place, x - s.inner["left"], tapped(cut, 4, 6.0))
            for x, place in hinge_screws(s)
            if name == "rear"
        )
        rails[name] = asm.add(
            f"bracket/{name}_rail",
            "painted steel",
            extruded,
            tuple(line),
            0.0,
            length,
            below,
            (),
            (pit, pit),
            pose=across(s.inner["left"]),
        )
    for side, sign in (("left", -1.0), ("right", 1.0)):
        middle = s.middle[side]
        mount(shop, s, side, sign)
        low = s.door - 7.0
        shape = [
            (-15.0, low),
            (150.0, low),
            (150.0, low + 26.0),
            (92.0, low + 80.0),
            (92.0, middle + 4.0),
            (147.0, y0 - 14.0),
            (147.0, y1 + 5.0),
        ]
        shape += [(85.0, y1 + 5.0), (85.0, y0 - 6.0), (24.0, middle + 32.0), (24.0, low + 80.0), (-15.0, low + 26.0)]
        outline = np.array([(-z, y) for z, y in shape[::-1]])
        if not cut.plain:
            outline = rounded(outline, 6.0, cut.arc(6.0, 1.3, 2))
        bore = 16.0 + deviation("H7", 32.0) / 2.0 + cut.ease
        holes = [(-MOUNT_Z, middle, bore), *((x, y, METRIC[8].through / 2.0 + cut.ease) for x, y in beam_bolts)]
        holes += [
            (-(a + b) / 2.0, s.door + RAIL_THICK / 2.0, METRIC[6].through / 2.0 + cut.ease) for a, b in RAILS.values()
        ]
        start = s.inner[side] - (HANGER if sign < 0.0 else 0.0)
        hanger = asm.add(
            f"bracket/{side}_hanger",
            "painted steel",
            plate,
            tuple(map(tuple, outline.tolist())),
            0.0,
            HANGER,
            tuple(holes),
            pose=across(start),
        )
        asm.flush(s.beam, hanger)
        bush = asm.add(
            f"bracket/{side}_bush",
            "copper",
            bushing,
            pose=times(at(start, middle, MOUNT_Z), frame((0.0, 0.0, 0.0), X)),
            spin=True,
        )
        asm.fit(bush, hanger, "H7/p6", play("H7/p6", 32.0), 16.0)
        asm.keep(hanger, "press", bush)
        asm.fit(bush, f"bracket/{side}_mount/mount", "H7/g6", play("H7/g6", 24.0), 12.0)
        out = (sign, 0.0, 0.0)
        outside = s.inner[side] + sign * HANGER
        bolts = []
        for k, (x, y) in enumerate(beam_bolts):
            seat = frame((outside, y, -x), out)
            bolts += shop.bolt("bracket", f"{side}_beam_bolt_{k + 1}", 8, seat, [hanger], s.beam, HANGER, 18.0)
        for name, (a, b) in RAILS.items():
            seat = frame((outside, s.door + RAIL_THICK / 2.0, (a + b) / 2.0), out)
            bolts += shop.bolt("bracket", f"{side}_{name}_rail_bolt", 6, seat, [hanger], rails[name], HANGER, 14.0)
            asm.flush(rails[name], hanger)
            asm.keep(bolts[-2], "thread", rails[name])
        asm.step([hanger, bush], pull(out, AWAY), after=[*bolts, f"bracket/{side}_mount/retainer"])
        for step in asm.steps:
            if step.parts[0] == f"bracket/{side}_mount/mount":
                step.after.append(hanger)
    for name, rail in rails.items():
        way = (0.0, -1.0, 0.0) if name == "rear" else (0.0, 0.0, -1.0)
        after = [f"bracket/{side}_{name}_rail_bolt" for side in ("left", "right")]
        asm.step(rail, pull(way, AWAY), after=[*after, *(["door/*_leaf_*"] if name == "rear" else [])])
    asm.step(
        rear,
        pull((0.0, 0.0, -1.0), 3.0 * AWAY),
        after=[
            "housing/split_gasket",
            "gear_train/*",
            "bracket/*_mount/mount",
            "input_drive/*",
            "covers/*_rear/cover",
            "oil_filter/*",
            "housing/drain_plug",
            "starter/gasket",
            "starter/stud_*",
            "oil_pump/gasket",
            "oil_pump/stud_*",
            "lines/*",
        ],
    )
    return s


def bushing(cut: Cut) -> Solid:
    """A bush on z = 0, 14 mm long: 24 H7 inside, 32 p6 outside."""
    bore, out = (
        12.0 + deviation("H7", 24.0) / 2.0 + cut.ease,
        16.0 + deviation("p6", 32.0) / 2.0 - (0.05 if cut.ease else 0.0),
    )
    outside = cut.sharp([(out - 0.8, 0.0), (out, 0.8), (out, HANGER - 0.8), (out - 0.8, HANGER)])
    return standard.ring_of(cut, ((bore, 0.0), *outside, (bore, HANGER)))


def mount(shop: Workshop, s: Stand, side: str, sign: float) -> None:
    """A trunnion on one end of the rear case, with its retaining disc."""
    asm, cut = shop.asm, shop.cut
    rear = OUT + REAR.name
    group = f"bracket/{side}_mount"
    base = frame((s.ends[side], s.middle[side], MOUNT_Z), (sign, 0.0, 0.0), (0.0, 0.0, 1.0))
    m = METRIC[6]
    journal = 12.0 + deviation("g6", 24.0) / 2.0
    up = ((16.0, 10.0), (14.5, 11.5), (14.5, 20.0), (journal, 20.0), (journal, 36.5))
    holes = tuple((x, y, m.through / 2.0 + cut.ease) for x, y in MOUNT_BOLTS)
    path = asm.add(
        f"{group}/mount",
        "steel",
        flanged,
        (62.0, 36.0, 6.0),
        10.0,
        up,
        (),
        (),
        holes,
        ((0.0, 0.0, tapped(cut, 8, 18.0)),),
        pose=base,
    )
    asm.flush(path, rear)
    bolts = []
    for k, (x, y) in enumerate(MOUNT_BOLTS):
        bolts += shop.bolt(
            group,
            f"bolt_{k + 1}",
            6,
            times(base, at(x, y, 10.0)),
            [path],
            rear,
            10.0,
            TAPPED,
            after=[f"bracket/{side}_hanger"],
        )
    for each in bolts[::2]:
        asm.keep(each, "thread", rear)
    asm.step(path, pull(base[:3, 2], AWAY), after=bolts)
    face = times(base, at(z=36.5))
    disc = asm.add(f"{group}/retainer", "zinc-plated steel", standard.seal_washer, 9.0, 40.0, 3.0, pose=face, spin=True)
    asm.flush(disc, path)
    asm.keep(disc, "stop", f"bracket/{side}_bush")
    bolt = shop.bolt(group, "retainer_bolt", 8, times(face, at(z=3.0)), [disc], path, 3.0, 18.0)
    asm.step(disc, pull(base[:3, 2], AWAY), after=bolt)


# --- the door ---------------------------------------------------------------------------------------------------------


def hinge_screws(s: Stand) -> list[tuple[float, float]]:
    """Of the fixed leaves: x of each screw, and its distance from the hinge's axis."""
    return [(x + dx, 14.0) for x in hinges(s) for dx in (-15.0, -5.0)]


def hinges(s: Stand) -> list[float]:
    """The x of the middle of each hinge."""
    return [s.inner["left"] + 100.0, s.inner["right"] - 100.0]


def latch(cut: Cut) -> Solid:
    """A quarter-turn latch: a knob on z < 0, a shank, and a bar along x at z = 11."""
    solid = Solid()
    knob, neck = solid.turned(
        cut.sharp([(9.0, -11.0), (10.0, -10.0), (10.0, -1.0), (8.5, 0.0), (5.0, 0.0), (5.0, 11.0)]), cut.circle(10.0)
    )
    solid.face(knob)
    near, far, half = LATCH_BAR
    corners = np.array([[far, -half], [far, half], [near, half], [near, -half]])
    low, high = solid.outline(corners if cut.plain else rounded(corners, 3.0, cut.arc(3.0, 1.6, 2)), (11.0, 15.0))
    solid.face(low, neck)
    solid.face(high)
    return solid


def door(shop: Workshop, s: Stand) -> None:
    """The door: a panel on two hinges with lift-off pins, and its latch."""
    asm, cut = shop.asm, shop.cut
    rail = "bracket/rear_rail"
    low, high = PANEL
    left, right = s.inner["left"] + 2.0, s.inner["right"] - 2.0
    centre = (left + right) / 2.0 + 60.0  # of the latch: clear of the filter
    screws = [(x + dx, HINGE_Z - 14.0) for x in hinges(s) for dx in (5.4, 15.4)]
    core = METRIC[4].core / 2.0 + (cut.ease + 0.35 if cut.ease else 0.0)
    pressed = LATCH_ROD + deviation("P7", 2.0 * LATCH_ROD) / 2.0
    rod_x, rod_z = centre + LATCH_STOP, LATCH_Z - LATCH_STOP
    holes = [(x, -z, core) for x, z in screws]
    holes += [(centre, -LATCH_Z, 5.3 + cut.ease), (rod_x, -rod_z, pressed + cut.ease)]
    corners = ((left, -high), (right, -high), (right, -low), (left, -low))
    panel = asm.add(
        "door/panel", "aluminium", plate, corners, 6.0, PANEL_THICK, tuple(holes), pose=frame((0.0, s.door, 0.0), Y, X)
    )
    pose = frame((centre, s.door, LATCH_Z), Y, (0.0, 0.0, -1.0))
    bar = asm.add("door/latch", "glass-filled polyamide", latch, pose=pose)
    asm.fit(bar, panel, "clearance", 0.3, 5.3)
    asm.flush(bar, panel)
    rod = asm.add(
        "door/latch_stop",
        "hardened steel",
        standard.dowel,
        2.0 * LATCH_ROD + deviation("h6", 2.0 * LATCH_ROD),
        16.0,
        16,  # sides, so that the latch stops where it should
        pose=frame((rod_x, s.door + 8.0, rod_z), Y),
        spin=True,
    )
    asm.fit(rod, panel, "P7/h6", play("P7/h6", 2.0 * LATCH_ROD), pressed)
    asm.keep(panel, "press", rod)
    asm.keep(panel, "captive", bar)
    asm.keep(rod, "stop", bar)
    asm.keep(bar, "latch", panel)
    down = (0.0, -1.0, 0.0)
    asm.step(bar, turn(Y, pose[:3, 3], np.pi / 2.0), removes=False)
    moving = [panel, bar, rod]
    reach = 20.0
    outline = loop_outline(cut, KNUCKLE, reach, HINGE_LOW - LEAF, HINGE_LOW)
    leaves, pins = [], []
    for k, x in enumerate(hinges(s)):
        axis_y = s.door - HINGE_LOW
        for name, start, flip, holder, ups in (
            ("rear", x - 20.0, 1.0, rail, (5.0, 15.0)),
            ("door", x + 0.4, -1.0, panel, (5.0, 15.0)),
        ):
            # drawn along x; the rear leaf's tab points to +z, the door's to -z
            place = frame(
                (start if flip < 0.0 else start + 20.0, axis_y, HINGE_Z),
                (1.0 if flip < 0.0 else -1.0, 0.0, 0.0),
                (0.0, 0.0, flip),
            )
            last = len(outline) - 1
            drills = tuple(
                Drill(last, 14.0 - outline[-1][0], u, ((2.25 + cut.ease, 0.0), (2.25 + cut.ease, LEAF)), 1) for u in ups
            )
            leaf = asm.add(
                f"door/{name}_leaf_{k + 1}",
                "stainless steel",
                extruded,
                outline,
                0.0,
                20.0,
                drills,
                ((0.0, 0.0, PIN + 0.05 + cut.ease),),
                pose=place,
            )
            asm.flush(leaf, holder)
            bolts = []
            for n, u in enumerate(ups):
                seat = frame((start + u, s.door - LEAF, HINGE_Z + flip * 14.0), down)
                bolts += shop.bolt(
                    "door",
                    f"{name}_screw_{2 * k + n + 1}",
                    4,
                    seat,
                    [leaf],
                    holder,
                    LEAF,
                    6.0,
                    head="screw",
                    washer=False,
                )
            leaves.append((name, leaf, bolts))
            if name == "door":
                moving += [leaf, *bolts]
                for each in bolts:
                    asm.keep(each, "thread", panel)
        pin = asm.add(
            f"door/pin_{k + 1}", "stainless steel", standard.turned_part,
            tuple(cut.sharp([(3.0, -2.0), (3.0, -0.4), (PIN, -0.4), (PIN, 43.0), (PIN - 0.5, 43.5)])),
            pose=frame((x - 21.0, axis_y, HINGE_Z), X), spin=True,
        )  # fmt: skip
        pins.append(pin)
        for _, leaf, _ in leaves[-2:]:
            asm.fit(pin, leaf, "clearance", 0.05, PIN + 0.05)
        asm.keep(pin, "hinge", *(leaf for _, leaf, _ in leaves[-2:]))
        asm.keep(leaves[-2][1], "hinge", pin)
        asm.step(pin, pull((-1.0, 0.0, 0.0), 60.0))
    for k, (_, leaf, bolts) in enumerate(leaves):
        asm.step(leaf, pull(down, AWAY), after=[*bolts, pins[k // 2]])
    asm.step([panel, bar, rod], pull(down, AWAY), after=[leaf for _, leaf, _ in leaves])
    hinge = (0.0, s.door - HINGE_LOW, HINGE_Z)
    asm.joint("door", moving, (-1.0, 0.0, 0.0), hinge, (0.0, DOOR_OPEN), needs=["latch"])
    asm.joint("latch", [bar], Y, (centre, s.door, LATCH_Z), (0.0, np.pi / 2.0))
