"""Mock-ups and tools from objects of other libraries: trimesh, PyVista and Open3D, lists and dicts of them, URDF.

Nothing here imports those libraries: their objects are recognised by attributes.
"""

from feeler.interchange.convert import from_open3d, from_pyvista, from_trimesh
from feeler.interchange.urdf import from_urdf

__all__ = ["from_open3d", "from_pyvista", "from_trimesh", "from_urdf"]
