"""The judge of depths: random pairs whose penetration depth and verdict are known without feeler.

Nothing here calls feeler except `asking.py` and `stability.py`, which ask the questions. The truths are closed forms,
linear programs, whole numbers, and branch and bound over distances to triangles; manifold3d says what shares volume.
"""
