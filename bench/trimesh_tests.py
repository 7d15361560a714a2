"""trimesh's own tests of its collision manager, with feeler's in its place.

The tests and their models are in trimesh's repository, not in its packages:

    python bench/trimesh_tests.py path/to/trimesh

Prints each test and the assertions that fail. Two are expected: what the contact point and the normal of two cubes in
one place are is FCL's own choice, and any point of a face and any of six directions is as right. With `--all` these two
are asked as well.
"""

from __future__ import annotations

import argparse
import re
import sys
import unittest
from pathlib import Path
from typing import Any

import trimesh.collision

from feeler.compat.trimesh import CollisionManager, scene_to_collision

OWN_CHOICE = re.compile(r"^ *assert .*allclose\(c\.(point|normal), .*$", re.MULTILINE)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path, help="a checkout of trimesh")
    parser.add_argument("--all", action="store_true", help="ask also for FCL's own choice of a point and a normal")
    given = parser.parse_args()
    path = given.checkout / "tests" / "test_collision.py"
    text = path.read_text(encoding="utf-8")
    if not given.all:
        text, count = OWN_CHOICE.subn(lambda found: found[0].replace("assert", "assert True or", 1), text)
        if count != 2:
            raise SystemExit(f"{path}: {count} assertions of a point or a normal, not 2")
    setattr(trimesh.collision, "CollisionManager", CollisionManager)  # noqa: B010  # a type is not assigned to
    setattr(trimesh.collision, "scene_to_collision", scene_to_collision)  # noqa: B010
    sys.path.insert(0, str(path.parent))
    module: dict[str, Any] = {"__name__": "test_collision"}
    exec(compile(text, str(path), "exec"), module)
    tests = unittest.defaultTestLoader.loadTestsFromTestCase(module["CollisionTest"])
    return 0 if unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful() else 1


if __name__ == "__main__":
    raise SystemExit(main())
