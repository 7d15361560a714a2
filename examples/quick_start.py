"""Quick start: a mock-up, a tool, a path, and the parts hit on the way."""

import feeler

mockup = feeler.sample("gearbox", triangles=100_000)  # or feeler.load_mockup("engine.step")
tool = feeler.sample_tool("wrench")  # or feeler.load_tool("wrench.stl", unit="mm")
print(mockup.report)

scene = feeler.Scene(mockup, tool=tool)
print(f"indexed in {scene.build_seconds:.2f} s, {scene.memory()['total'] / 1e6:.1f} MB")

path = feeler.sample_path(scene, tool, 200)  # (200, 4, 4), world_from_tool, metres
for number, world_from_tool in enumerate(path):
    hit = scene.collide(tool, world_from_tool)
    if len(hit.pairs):
        parts = ", ".join(mockup.part_paths[part] for part in hit.parts)
        print(f"pose {number} is the first that collides: {len(hit.pairs)} pairs of triangles, with {parts}")
        break
else:
    print("the way is free")
