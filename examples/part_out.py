"""Disassembly: which part can be pulled out along an axis, and which one after that?

    python examples/part_out.py

A part goes straight out if it enters no remaining part on its way: it may touch, and slide along its seat.
"""

import numpy as np

import feeler


def box(lower: tuple[float, ...], upper: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The 8 corners and 12 triangles of a box, facing outward."""
    low, high = np.array(lower), np.array(upper)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
    return low + corners * (high - low), np.array(triangles)


# A case that is open above, with a pump and a filter in it without play, a lid on top, and a latch across the lid.
# Binary fractions of a metre: flush faces are flush to the last bit.
shapes = {
    "case/bottom": box((-0.25, -0.125, -0.0625), (0.25, 0.125, 0)),
    "case/left": box((-0.25, -0.125, 0), (-0.1875, 0.125, 0.25)),
    "case/right": box((0.1875, -0.125, 0), (0.25, 0.125, 0.25)),
    "inside/filter": box((-0.1875, -0.125, 0), (0.1875, 0.125, 0.0625)),
    "inside/pump": box((-0.1875, -0.0625, 0.0625), (0.1875, 0.0625, 0.25)),
    "inside/pump/shaft": box((-0.03125, -0.03125, 0.09375), (0.03125, 0.03125, 0.21875)),
    "lid": box((-0.25, -0.125, 0.25), (0.25, 0.125, 0.265625)),
    "latch": box((-0.28125, -0.015625, 0.265625), (0.28125, 0.015625, 0.28125)),
}
vertices = np.concatenate([points for points, _ in shapes.values()])
faces = np.concatenate([triangles + 8 * i for i, (_, triangles) in enumerate(shapes.values())])
names = [path.split("/")[-1] for path in shapes]
mockup = feeler.Mockup(vertices, faces, np.repeat(np.arange(len(shapes)), 12), names, part_paths=list(shapes))
whole = feeler.Scene(mockup)

# A shaft in its pump meets nothing, and is not free all the same: it comes out with the pump.
for part in mockup.parts:
    around = whole.without(part).containment(feeler.Tool.of_parts(mockup, part), np.eye(4))
    for index in around.containing:
        print(f"{part.path} is inside {mockup.parts[int(index)].path}")

# Straight up by half a metre, then aside.
way = np.tile(np.eye(4), (3, 1, 1))
way[1:, 2, 3] = 0.5
way[2, 0, 3] = 1.0

scene, left = whole, ["inside/filter", "inside/pump", "lid", "latch"]
while left:
    for path in left:
        tool = feeler.Tool.of_parts(mockup, path, name=path)  # with all that lies below the path
        check = scene.without(path).check_path(tool, way, touching="free")
        if check.is_free:
            print(f"{path} goes out")
            scene = scene.without(path)
            left.remove(path)
            break
        print(f"{path} is held by {mockup.parts[int(check.parts[0])].path}")
    else:
        print("nothing else goes out this way")
        break
