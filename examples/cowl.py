"""Open a door by its joints, take out what is behind it, and close the door again, with and without it.

    python examples/cowl.py

The built-in gearbox has a latched door under its oil filter. Everything is asked by the same joints.
"""

import math

import feeler

mockup = feeler.sample("gearbox", triangles=75_000)
truth = {joint.name: joint for joint in feeler.sample_truth("gearbox", 75_000).joints}
latch, door = truth["latch"].parts, truth["door"].parts
panel = [part for part in door if part not in latch]

# The joints; `feeler.find_joint` finds them from the surfaces, too.
quarter = (0.0, math.pi / 2)
joints = [
    feeler.Joint("door", "revolute", None, panel, truth["door"].axis, truth["door"].point_m),
    feeler.Joint("latch", "revolute", panel, latch, truth["latch"].axis, truth["latch"].point_m, limits=quarter),
]
filter_bowl = truth["filter_bowl"]
bowl = list(filter_bowl.parts)
joints.append(feeler.Joint("bowl", "revolute", None, bowl, filter_bowl.axis, filter_bowl.point_m))
mechanism = feeler.Mechanism(mockup, joints)


def degrees(angle: float) -> str:
    """An angle in words."""
    return f"{math.degrees(angle):.1f} degrees"


latched = mechanism.range("door")
assert latched.above is not None
print(f"latched, the door opens by {degrees(latched.upper)}: {latched.above.path} meets {latched.above.other_path}")
turned = {"latch": math.pi / 2}
free = mechanism.range("door", turned)
print(f"with the latch turned, it opens by {degrees(free.upper)}")

# The filter: a turn in its bayonet, and out.
bayonet = mechanism.range("bowl", turned)
loose = {**turned, "bowl": 0.95 * bayonet.upper}
print(f"the filter turns in its bayonet by {degrees(loose['bowl'])}")
closed = feeler.removal(mechanism.scene(loose), bowl, seconds=60.0, rounds=2)
blockers = ", ".join(blocker.path for blocker in closed.blocked_by if blocker.part in mockup.parts.select(panel))
print(f"with the door closed it comes out: {closed.is_found}; of the door, these are in the way: {blockers}")
open_by = {**turned, "door": 0.95 * free.upper}
way = feeler.removal(mechanism.scene({**loose, **open_by}), bowl, seconds=20.0)
print(f"with the door open it comes out: {way.is_found}, by {way.path_length:.2f} m")

# Closing: the door turns back to where it was, with the filter in its place or without it.
without = feeler.Mechanism(mockup, joints[:2], scene=feeler.Scene(mockup).without(bowl))
for name, each in (("the filter in place", mechanism), ("the filter taken out", without)):
    back = each.range("door", open_by)
    print(f"with {name} the door closes to {degrees(back.lower)}")
