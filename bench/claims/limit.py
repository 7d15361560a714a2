"""How far feeler is from the limits of this machine: memory lines read, lane operations done, one core.

python bench/claims/limit.py                    at 1.6M triangles, into bench/records
python bench/claims/limit.py --size 100k --tools hand --poses 20 --out /tmp/records

First it measures the machine: limit_kernels.cpp reads lines of buffers of many sizes and does lane operations, and
nothing else. Then, for each tool and kind of poses, it counts the least work of a query and multiplies it by these
costs. Every count is a lower bound, and memory and lanes are assumed to overlap fully, so no program of this design can
be faster on this machine than the limit; it is not known how near one could come.
"""

from __future__ import annotations

import argparse
import ctypes
import functools
import itertools
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this folder is a package of the bench's

import engines
import extras
import figures
import host
import measure
import native
from command_line import triangles
from options import TOOLS
from record import Origin, Row, elsewhere, keep

import feeler
from feeler.choices import Simd
from feeler.samples.poses import KINDS
from feeler.samples.tools import sample_tool

LINE = 64  # bytes of a cache line
MIB = 1 << 20

# Bytes of the structures, as in crates/feeler-core.
CLUSTER = 836  # a cluster of 16 tool pieces
PIECE = 28  # a mock-up piece in its block: sides in bytes, packed corners, triangle
TOOL_TRIANGLE = 64
FACE = 12
VERTEX = 24

# Vector instructions of 512 bits that the code of each stage cannot do without; loads, broadcasts, list handling and
# addresses are not among them. float32 in 16 lanes, float64 in 8.
NODE = 6  # a node test: 3 x (shuffle, comparison of 64 bytes), or 6 comparisons of 16 boxes with a node's own
PLACE = 60  # placing a cluster: 36 multiply-adds, 18 least and greatest, 6 margins
SCAN = 6  # a piece against 16 boxes: 6 comparisons
PLANES = 40  # both planes against 4 corners each, in 16 lanes: 24 multiply-adds, 12 least and greatest, 4 comparisons
TEST = 174  # sixteen triangle pairs: turning the mock-up's 84, to float32 24, the sizes of all 21, two planes 45
MEET = 67  # and where both planes are crossed: nine triple products 35, choosing four 15, comparing them 17

POINTER, SIZE, COUNT = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64
FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "limit_buffer": (POINTER, (SIZE, ctypes.c_int)),
    "limit_free": (None, (POINTER,)),
    "limit_random": (COUNT, (POINTER, COUNT, COUNT, COUNT)),
    "limit_chained": (COUNT, (POINTER, COUNT, COUNT, COUNT)),
    "limit_sequential": (COUNT, (POINTER, COUNT, COUNT, COUNT)),
    "limit_multiply_adds": (ctypes.c_double, (COUNT,)),
    "limit_mixed": (ctypes.c_double, (COUNT,)),
}
STANDARD = (1_600_000, 100, 5)  # size, poses, rounds
LEVELS: tuple[Simd, ...] = ("avx512", "avx2", "neon", "portable")
SIZES = (MIB // 2, 2 * MIB, 8 * MIB, 16 * MIB, 32 * MIB, 64 * MIB)
RANDOM, CHAINED, STEPS = 1_000_000, 100_000, 1_000_000
REPEATS = 8
BUSY = 1.5  # more than this many on the machine, this one included


@dataclass
class Machine:
    """Nanoseconds a line by size of the buffer, the cheaper of ordinary and huge pages; lane instructions a ns."""

    bytes: list[int]
    random: list[float]
    chained: list[float]
    sequential: list[float]
    multiply_adds: float
    mixed: float

    def price(self, of: str, size: float) -> float:
        """Nanoseconds a line in a buffer of any size; between those measured, along a line in the logarithm."""
        return float(np.interp(np.log(max(size, 1.0)), np.log(self.bytes), getattr(self, of)))


@dataclass
class Needed:
    """The least work of one query."""

    scattered: int  # lines here and there: corners of the mock-up's triangles that were found
    in_row: int  # lines in one go: clusters placed, and data packed side by side
    instructions: float
    answer: float  # of these, what every pair found needs in any design


def measured(index_bytes: int) -> Machine:
    """The speed of this core. Each figure is the best of a few; a busy machine can only take away."""
    library = native.compile_cpp(Path(__file__).with_name("limit_kernels.cpp"), [])
    native.declare(library, FUNCTIONS)
    sizes = sorted({*SIZES, index_bytes})
    rows = []
    for size in sizes:
        both = [_lines(library, size, huge) for huge in (0, 1)]
        rows.append([min(values) for values in zip(*both, strict=True)])
    random, chained, sequential = (list(column) for column in zip(*rows, strict=True))
    # A larger buffer is no cheaper than a smaller one: what says so is noise.
    for column in (random, chained, sequential):
        column[:] = np.minimum.accumulate(column[::-1])[::-1].tolist()
    rates = [
        each * STEPS / _best(functools.partial(function, STEPS))
        for each, function in ((8, library.limit_multiply_adds), (16, library.limit_mixed))
    ]
    return Machine(sizes, random, chained, sequential, rates[0], max(rates))


def _lines(library: ctypes.CDLL, size: int, huge: int) -> tuple[float, float, float]:
    """Nanoseconds a line: at random, at random one after the other, in order."""
    buffer = library.limit_buffer(size, huge)
    if not buffer:
        raise MemoryError(f"no {size:,} bytes for a buffer")
    lines = size // LINE
    counts = (RANDOM, CHAINED, max(lines, RANDOM))
    functions = (library.limit_random, library.limit_chained, library.limit_sequential)
    try:
        # The same places again and again: the caches may hold them.
        random, chained, sequential = (
            _best(functools.partial(function, buffer, lines, count, 0)) / count
            for function, count in zip(functions, counts, strict=True)
        )
    finally:
        library.limit_free(buffer)
    return random, chained, sequential


def _best(call: Callable[[], Any]) -> int:
    """Nanoseconds."""
    best = sys.maxsize
    for _ in range(REPEATS):
        start = time.perf_counter_ns()
        call()
        best = min(best, time.perf_counter_ns() - start)
    return best


def needed(faces: Any, pairs: Any, stats: dict[str, int]) -> Needed:
    """The least work for these pairs, by a query with this funnel. `faces` are the mock-up's."""
    tool_triangles, found = np.unique(pairs[:, 0]), np.unique(pairs[:, 1])
    scattered = _distinct_lines(found, FACE) + _distinct_lines(np.unique(faces[found]), VERTEX)
    in_row = CLUSTER * stats["clusters_placed"] + TOOL_TRIANGLE * len(tool_triangles) + PIECE * len(found)
    answer = (TEST + MEET) * len(pairs) / 16
    rest = stats["triangle_tests"] - len(pairs)  # a few pairs are offered twice: then it is too little, not too much
    instructions = (
        NODE * stats["voxels_visited"]
        + PLACE * stats["clusters_placed"]
        + SCAN * stats["pieces_scanned"]
        + PLANES * stats["entries_scanned"] / 16
        + TEST * max(rest, 0) / 16
        + answer
    )
    return Needed(scattered, in_row // LINE, instructions, answer)


def _distinct_lines(rows: Any, size: int) -> int:
    """Lines of an array that hold the first byte of these rows."""
    return len(np.unique(rows.astype(np.int64) * size // LINE))


def cells(
    scene: feeler.Scene, tools: dict[str, feeler.Tool], core: Machine, index_bytes: int, options: argparse.Namespace
) -> Iterator[Row]:
    """A row a tool and kind: medians over poses, microseconds."""
    engine = engines.FeelerEngine()
    engine.scene = scene
    faces = np.asarray(scene.mockup.faces)
    for name, tool in tools.items():
        engine.prepare(tool)
        cost = extras.python_call(scene.mockup, tool)
        tool_lines = tool.triangle_count * (CLUSTER // 16 + TOOL_TRIANGLE) // LINE
        call = cost["over_core_us"] + cost["clock_us"]
        for kind in KINDS:
            poses = measure.find_poses(scene, engine.tool, kind, options.poses)
            found = measure.look([engine], poses)["feeler"]
            least = [needed(faces, pairs, stats) for pairs, stats in zip(found.pairs, found.stats, strict=True)]
            # What a loop over these poses finds in the caches in its next round; all poses share the tool.
            loop = LINE * (sum(one.scattered for one in least) + min(sum(one.in_row for one in least), tool_lines))
            loop = min(max(loop, core.bytes[0]), index_bytes)
            own = measure.clock([engine], poses, options.rounds)["feeler"].wall.min(axis=0) - call
            again = np.min([[_again(engine, pose) for pose in poses] for _ in range(options.rounds)], axis=0) - call
            memory = [_memory(core, one, loop) for one in least]
            lanes = [one.instructions / core.mixed / 1e3 for one in least]
            yield _about(scene, tool, name, kind, options) | {
                **{"what": "limit", "engine": "feeler"},
                "lines": float(np.median([one.scattered + one.in_row for one in least])),
                "memory_us": float(np.median(memory)),
                "lanes_us": float(np.median(lanes)),
                "limit_us": float(np.median(np.maximum(memory, lanes))),
                "median_us": float(np.median(own)),
                "again_us": float(np.median(again)),
            }


def by_level(scene: feeler.Scene, tools: dict[str, feeler.Tool], options: argparse.Namespace) -> Iterator[Row]:
    """A row for each instruction set that this CPU has, at nominal and deep poses."""
    scenes = {}
    for simd in LEVELS:
        try:
            scenes[simd] = feeler.Scene(scene.mockup, threads=1, simd=simd)
        except feeler.OptionError:
            continue
    for name, tool in tools.items():
        for kind in ("nominal", "deep"):
            poses = measure.find_poses(scene, tool, kind, options.poses)
            least = {simd: np.full(len(poses), np.inf) for simd in scenes}
            for _, (simd, one) in itertools.product(range(options.rounds), scenes.items()):
                times = [measure.clock_once(functools.partial(one.collide, tool, pose))[0] for pose in poses]
                least[simd] = np.minimum(least[simd], times)
            for simd, best in least.items():
                row: Row = {"what": "level", "engine": f"feeler-{simd}", "median_us": float(np.median(best))}
                yield _about(scene, tool, name, kind, options) | row


def _about(scene: feeler.Scene, tool: feeler.Tool, name: str, kind: str, options: argparse.Namespace) -> Row:
    row: Row = {"size": options.size, "tool": name, "kind": kind, "query": "collide", "version": feeler.__version__}
    row |= {"triangles": scene.mockup.triangle_count, "parts": scene.mockup.part_count}
    return row | {"tool_triangles": tool.triangle_count, "poses": options.poses, "rounds": options.rounds}


def _memory(core: Machine, one: Needed, size: int) -> float:
    """Microseconds for the lines, in a buffer of this size."""
    return (one.scattered * core.price("random", size) + one.in_row * core.price("sequential", size)) / 1e3


def _again(engine: engines.FeelerEngine, pose: engines.Floats) -> float:
    """Microseconds of a query repeated at once: the caches hold its data."""
    call = engine.aim("collide", pose)
    call()
    return measure.clock_once(call)[0]


def prices(core: Machine) -> figures.Table:
    """The speed of the machine."""
    heads = ["buffer, MiB", *(f"{size / MIB:,.3g}" for size in core.bytes)]
    lines = []
    for of, said in (
        ("random", "lines at random, many in flight, ns"),
        ("chained", "lines at random, each after the other, ns"),
        ("sequential", "lines in order, ns"),
    ):
        lines.append([said, *(f"{value:.2f}" for value in getattr(core, of))])
    note = (
        "Vector instructions of 16 float32 lanes (or 8 of float64), a nanosecond: multiply-adds alone "
        f"{core.multiply_adds:.1f}, half of them sums {core.mixed:.1f}."
    )
    return figures.Table("What this core can do", heads, 1, lines, note)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=triangles, default=STANDARD[0], help="triangles of the mock-up (1.6M)")
    parser.add_argument("--tools", default=TOOLS, help=f"sample tools; -fine: about 50k ({TOOLS})")
    parser.add_argument("--poses", type=int, default=STANDARD[1], help="in each cell (100)")
    parser.add_argument(
        "--rounds", type=int, default=STANDARD[2], help="of all poses; the least time of each counts (5)"
    )
    parser.add_argument("--out", type=Path, help="folder of the record, whatever this run is worth")
    options = parser.parse_args(arguments)
    if min(options.poses, options.rounds) < 1:
        parser.error("--poses and --rounds are at least 1")
    try:
        tools = {
            name: sample_tool(name.removesuffix("-fine"), name.endswith("-fine")) for name in options.tools.split(",")
        }
    except feeler.OptionError as error:
        parser.error(str(error))
    scene = feeler.Scene(feeler.sample("engine", options.size), threads=1)
    index_bytes = scene.memory()["total"]
    try:
        core = measured(index_bytes)
    except native.AbsentError as error:
        sys.exit(f"the machine cannot be measured: {error}")
    print(prices(core).markdown())
    load, origin = host.load_average(), Origin.here(feeler.__version__)
    standard = (options.size, options.poses, options.rounds) == STANDARD
    reasons = [*([] if standard else ["size, poses or rounds are not the usual ones"]), *origin.reasons_against()]
    rows = origin.marked([*cells(scene, tools, core, index_bytes, options), *by_level(scene, tools, options)])
    for table in (figures.limit(rows), figures.levels(rows)):
        if table:
            print(f"\n{table.markdown()}")
    if load and load[0] > BUSY:
        print(f"The machine was busy (load {load[0]:.1f}): the measured times are too long rather than too short.")
    if reasons and not options.out:
        print(elsewhere(reasons))
    print(f"Written: {keep(rows, origin, options.out, reasons)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
