"""Mock-ups and tools from what people hold: meshes of trimesh, PyVista and Open3D, lists and dicts of them, URDF.

Nothing here imports those libraries: objects are told by the attributes that they have.
"""

from feeler.interchange.convert import from_open3d, from_pyvista, from_trimesh
from feeler.interchange.urdf import from_urdf

__all__ = ["from_open3d", "from_pyvista", "from_trimesh", "from_urdf"]
