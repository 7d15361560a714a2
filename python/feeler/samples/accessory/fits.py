"""Fits after ISO 286 and sizes of standard parts, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass

# Upper end of the step of diameters, then in micrometres: IT7, IT6, fundamental deviation of g, k, p.
_STEPS = (
    (3.0, 10, 6, -2, 0, 6),
    (6.0, 12, 8, -4, 1, 12),
    (10.0, 15, 9, -5, 1, 15),
    (18.0, 18, 11, -6, 1, 18),
    (30.0, 21, 13, -7, 2, 22),
    (50.0, 25, 16, -9, 2, 26),
    (80.0, 30, 19, -10, 2, 32),
    (120.0, 35, 22, -12, 3, 37),
)


def deviation(zone: str, diameter: float) -> float:
    """The middle of a tolerance zone ("H7", "P7", "g6", ...) above the nominal diameter; "nominal" has none."""
    if zone == "nominal":
        return 0.0
    it7, it6, g, k, p = next(row[1:] for row in _STEPS if diameter <= row[0])
    width = it7 if zone.endswith("7") else it6
    low = {"H": 0, "G": -g, "P": -p - it6, "g": g - it6, "h": -it6, "k": k, "p": p}[zone[0]]
    return (low + width / 2.0) * 1e-3


def play(kind: str, diameter: float) -> float:
    """The gap all round of a centred shaft in its hole, as drawn: "H7/g6" and so on; negative for a press."""
    hole, shaft = kind.split("/")
    return (deviation(hole, diameter) - deviation(shaft, diameter)) / 2.0


@dataclass(frozen=True)
class Metric:
    """A metric thread with its bolt, cap screw, nut and washer (ISO 4017, 4762, 4032, 7089) and its holes."""

    size: float
    pitch: float
    flats: float
    head: float
    nut: float
    washer: float
    thick: float
    core: float
    """Diameter of the tapped hole before its thread is cut (ISO 2306), as most CAD draws it."""
    through: float
    """Diameter of the clearance hole."""
    socket: float
    """Across the flats of a cap screw's socket."""
    cap: float
    """Diameter of a cap screw's head."""

    @property
    def washer_bore(self) -> float:
        """Diameter of the washer's hole."""
        return self.size + 0.4


METRIC = {
    4: Metric(4.0, 0.7, 7.0, 2.8, 3.2, 9.0, 0.8, 3.3, 4.5, 3.0, 7.0),
    5: Metric(5.0, 0.8, 8.0, 3.5, 4.7, 10.0, 1.0, 4.2, 5.5, 4.0, 8.5),
    6: Metric(6.0, 1.0, 10.0, 4.0, 5.2, 12.0, 1.6, 5.0, 6.6, 5.0, 10.0),
    8: Metric(8.0, 1.25, 13.0, 5.3, 6.8, 16.0, 1.6, 6.8, 9.0, 6.0, 13.0),
}
LENGTHS = (8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100)


def stock_length(least: float) -> float:
    """The shortest length of bolts in stock that is not below `least`."""
    return float(next(length for length in LENGTHS if length >= least))


@dataclass(frozen=True)
class Bearing:
    """A deep groove ball bearing (ISO 15): bore, outside diameter, width, balls and their diameter."""

    name: str
    bore: float
    outside: float
    width: float
    balls: int
    ball: float

    @property
    def pitch(self) -> float:
        """Radius of the circle of the balls' centres."""
        return (self.bore + self.outside) / 4.0


BEARINGS = {
    b.name: b
    for b in (
        Bearing("6202", 15.0, 35.0, 11.0, 8, 5.953),
        Bearing("6203", 17.0, 40.0, 12.0, 8, 6.747),
        Bearing("6204", 20.0, 47.0, 14.0, 8, 7.938),
        Bearing("6205", 25.0, 52.0, 15.0, 9, 7.938),
    )
}
# External circlips (DIN 471) by shaft: thickness, groove diameter, groove width, radial width.
CIRCLIPS = {
    17: (1.0, 16.2, 1.1, 2.3),
    20: (1.2, 19.0, 1.3, 2.6),
    25: (1.2, 23.9, 1.3, 3.0),
    30: (1.5, 28.6, 1.6, 3.5),
}
# Parallel keys (DIN 6885) by shaft: width, height, depth in the shaft.
KEYS = {17: (5.0, 5.0, 3.0), 20: (6.0, 6.0, 3.5), 25: (8.0, 7.0, 4.0), 30: (8.0, 7.0, 4.0)}
