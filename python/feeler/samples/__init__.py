"""Built-in mock-ups and tools: deterministic, CAD-like, at any size; and poses and motions among them."""

from .accessory import FAULTS, KEEPS, Body, Fastener, Fault, Fit, Joint, Keeper, Leg, Stay, Step, Truth
from .mockups import sample, sample_names, sample_truth
from .motion import sample_path
from .poses import sample_poses
from .tools import sample_tool, sample_tool_names

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
    "sample",
    "sample_names",
    "sample_path",
    "sample_poses",
    "sample_tool",
    "sample_tool_names",
    "sample_truth",
]
