"""An engine's accessory gearbox, modelled like real ones, with its known facts.

`solid.py` and `polygon.py` build closed solids; `fits.py` has the tables; `standard.py`, `train.py`, `bodies.py` and
`housing.py` draw parts; `layout.py`, `design.py`, `accessories.py`, `lines.py`, `stand.py` and `build.py` put them
together; `assembly.py` keeps the truth about them; `swings.py` finds how far wrenches swing; `sample.py` cuts it to a
size; `faults.py` plants faults.
"""

from .faults import FAULTS
from .sample import gearbox_parts, gearbox_truth
from .truth import KEEPS, Body, Fastener, Fault, Fit, Joint, Keeper, Leg, Stay, Step, Truth

__all__ = [
    "FAULTS",
    "KEEPS",
    "Body",
    "Fastener",
    "Fault",
    "Fit",
    "Joint",
    "Keeper",
    "Leg",
    "Stay",
    "Step",
    "Truth",
    "gearbox_parts",
    "gearbox_truth",
]
