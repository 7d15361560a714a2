"""Interfaces of other libraries, answered by feeler: `feeler.compat.trimesh`, `feeler.compat.mujoco`."""
