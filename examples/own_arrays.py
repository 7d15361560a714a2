"""Meshes from your own arrays, and the three ways in which two triangles collide."""

import numpy as np

import feeler


def box(lower: tuple[float, ...], upper: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The 8 corners and 12 triangles of a box, facing outward."""
    low, high = np.array(lower), np.array(upper)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
    return low + corners * (high - low), np.array(triangles)


# A base plate with two posts: three parts, metres. Multiples of 1/64 are exact in binary, so that "touching" is true to
# the last bit; 0.1 + 0.2 would reach a little beyond 0.3, and feeler would say so.
shapes = {
    "stand/plate": box((0, 0, 0), (0.5, 0.25, 0.015625)),
    "stand/post_left": box((0.0625, 0.0625, 0.015625), (0.125, 0.1875, 0.25)),
    "stand/post_right": box((0.375, 0.0625, 0.015625), (0.4375, 0.1875, 0.25)),
}
vertices = np.concatenate([points for points, _ in shapes.values()])
faces = np.concatenate([triangles + 8 * i for i, (_, triangles) in enumerate(shapes.values())])
part_of_face = np.repeat(np.arange(len(shapes)), 12)
names = [path.split("/")[-1] for path in shapes]
mockup = feeler.Mockup(vertices, faces, part_of_face, names, part_paths=list(shapes))
tool = feeler.Tool(*box((0, 0, 0), (0.25, 0.0625, 0.0625)), name="slider")
scene = feeler.Scene(mockup, tool=tool)

# The slider is exactly as long as the gap between the posts is wide.
for words, place in {
    "between the posts": (0.125, 0.09375, 0.125),
    "lying on the plate, between the posts": (0.125, 0.09375, 0.015625),
    "pushed into the right post": (0.15, 0.09375, 0.125),
    "beside the stand": (0.125, 0.4, 0.125),
}.items():
    world_from_tool = np.eye(4)
    world_from_tool[:3, 3] = place
    hit = scene.collide(tool, world_from_tool)
    counts = {str(kind): int((hit.kinds == kind).sum()) for kind in feeler.PairKind}
    print(f"{words}: {len(hit.pairs)} pairs {counts}")
    for part in hit.parts:
        print(f"    {mockup.parts[int(part)].path}")
