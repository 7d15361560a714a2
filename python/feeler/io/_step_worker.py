"""Run by `step.py` in a process of its own: python _step_worker.py IN OUT LINEAR ANGULAR MEMORY.

The converter is native code. It runs in this process so that a crash, a hang or a runaway allocation does not affect
the caller. Exit status 0 and a GLB file is success; 3 means that cascadio is not installed.
"""

import contextlib
import sys


def main() -> int:
    """Convert one STEP file to GLB (metres)."""
    source, target, linear, angular, memory = sys.argv[1:6]
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource  # not on Windows

        resource.setrlimit(resource.RLIMIT_AS, (int(memory), int(memory)))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # cascadio would import trimesh if it is installed, a quarter of a second for nothing we use.
    sys.modules["trimesh"] = None  # type: ignore[assignment]
    try:
        import cascadio
    except ImportError as error:
        print(error, file=sys.stderr)
        return 3
    try:
        return cascadio.step_to_glb(
            source,
            target,
            tol_linear=float(linear),
            tol_angular=float(angular),
            tol_relative=False,
            merge_primitives=True,
            include_brep=True,  # tells which face each triangle came from, so that a face without any can be reported
        )
    except Exception as error:  # what OpenCASCADE throws: the message is of use, the places in its binding are not
        print(str(error) or type(error).__name__, file=sys.stderr)
        return 1


if __name__ == "__main__":
    # Python puts this folder first on the path: its modules must not stand in for others of the same name.
    del sys.path[0]
    sys.exit(main())
