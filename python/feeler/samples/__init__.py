"""Built-in mock-ups and tools: deterministic, CAD-like, at any size; and poses and motions among them."""

from .mockups import sample, sample_names
from .motion import sample_path
from .poses import sample_poses
from .tools import sample_tool, sample_tool_names

__all__ = ["sample", "sample_names", "sample_path", "sample_poses", "sample_tool", "sample_tool_names"]
