"""Coverage-guided fuzzing of the file loaders: any bytes must give a mock-up or a `FeelerError`, never anything else.

    python fuzz/loaders.py stl -max_total_time=1200  one format; further arguments go to libFuzzer
    python fuzz/loaders.py stl --smoke 200           that many random changes of each seed, without libFuzzer
    python fuzz/loaders.py --list

Files are loaded alone, so referenced files of a format are not covered. STEP is converted in a child process, by a
native library without coverage: coverage guides only the steps before and after, some five files a second. The corpora
grow in build/fuzz/FORMAT, from fuzz/seeds/FORMAT; input that breaks the rule is written to build/fuzz/crash-FORMAT-*.
"""

from __future__ import annotations

import io
import random
import sys
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SEEDS = ROOT / "fuzz" / "seeds"
FORMATS = ("stl", "obj", "ply", "off", "gltf", "glb", "3mf", "dae", "step")


def checker(kind: str, load_mockup: Callable[[Path], Any]) -> Callable[[bytes], None]:
    """A function that loads bytes as a file of the format, and raises on anything but a mock-up or a `FeelerError`."""
    from feeler import FeelerError

    scratch = Path(tempfile.mkdtemp(prefix="feeler-fuzz-")) / f"input.{kind}"

    def check(data: bytes) -> None:
        scratch.write_bytes(_archived(data) if kind == "3mf" else data)
        try:
            mockup = load_mockup(scratch)
        except FeelerError as error:
            assert str(error), "an error without a message"
            return
        report = mockup.report
        assert report.triangles == len(mockup.faces) > 0
        assert len(mockup.part_names) == len(mockup.part_paths) == len(set(mockup.part_paths))

    return check


def _archived(data: bytes) -> bytes:
    """The bytes as the model in an archive, unless they are an archive: checksums would stop nearly every change."""
    if data[:2] == b"PK":
        return data
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("3D/3dmodel.model", data)
    return file.getvalue()


def smoke(kind: str, count: int) -> None:
    """Loads random changes of the seeds."""
    from feeler.io import load_mockup

    check = checker(kind, load_mockup)
    pick = random.Random(0)
    for seed in sorted((SEEDS / kind).iterdir()):
        original = seed.read_bytes()
        check(original)
        for _ in range(count):
            data = bytearray(original)
            for _ in range(pick.randint(1, 8)):
                _change(data, pick)
            check(bytes(data))


def _change(data: bytearray, pick: random.Random) -> None:
    at = pick.randrange(len(data) + 1)
    change = pick.randrange(4)
    if change == 0:
        data[at : at + 1] = bytes([pick.randrange(256)])
    elif change == 1:
        del data[at : at + pick.randint(1, 16)]
    elif change == 2:
        data[at:at] = data[: pick.randint(1, 32)]
    else:
        data[at : at + 4] = pick.choice([b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\xc0\x7f", b"-1 9"])


def fuzz(kind: str, options: list[str]) -> None:
    """Runs libFuzzer on the readers, instrumented; does not return."""
    import atheris

    with atheris.instrument_imports(include=["feeler.io"]):
        from feeler.io import load_mockup

    corpus = ROOT / "build" / "fuzz" / kind
    corpus.mkdir(parents=True, exist_ok=True)
    prefix = f"-artifact_prefix={corpus.parent}/crash-{kind}-"
    limits = ["-rss_limit_mb=3000", "-timeout=20"]
    arguments = [sys.argv[0], str(corpus), str(SEEDS / kind), prefix, *limits, *options]
    atheris.Setup(arguments, checker(kind, load_mockup))
    atheris.Fuzz()


def main() -> None:
    """The command line."""
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__)
        return
    kind, *options = sys.argv[1:]
    if kind == "--list":
        print(*FORMATS)
    elif kind not in FORMATS:
        sys.exit(f"unknown format {kind!r}: choose one of {', '.join(FORMATS)}")
    elif options[:1] == ["--smoke"]:
        smoke(kind, int(options[1]))
    else:
        fuzz(kind, options)


if __name__ == "__main__":
    main()
