"""The judge: compares feeler with random pairs of known penetration depth and verdict.

Only `asking.py` and `stability.py` call feeler. The expected values come from closed forms, linear programs, integer
arithmetic, and branch and bound over distances to triangles; shared volumes from manifold3d.
"""
