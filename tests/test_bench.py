"""The bench and the real-data run at toy size: they run, and what they write is what they say. No times are judged."""

from __future__ import annotations

import importlib.util
import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import feeler

PEERS = [name for name in ("coal", "fcl") if importlib.util.find_spec(name) is not None]
HAS_EMBREE = shutil.which("g++") is not None and Path("/usr/include/embree3/rtcore.h").exists()
TINY = ["--sizes", "10000", "--tools", "torque,wrench", "--poses", "3", "--rounds", "1", "--builds", "1"]
ALONE = ["--worst", "20", "--batch", "10"]
SKIP = ["--worst", "0", "--batch", "0"]


def run(root: Path, script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, str(root / "bench" / script), *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONUTF8": "1", **environment},
        timeout=240,
        check=False,
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


@pytest.fixture
def bench(root: Path, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Modules of the bench."""
    monkeypatch.syspath_prepend(str(root / "bench"))
    names = ("record", "rows", "figures", "goals", "measure", "agreement", "host")
    return SimpleNamespace(**{name: importlib.import_module(name) for name in names})


@pytest.fixture(scope="module")
def small_run(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the record of one small run, and all that it found as JSON."""
    folder = tmp_path_factory.mktemp("records")
    done = run(
        root, "run.py", *TINY, *ALONE, "--peers", "coal,fcl", "--out", str(folder), "--json", str(folder / "all.json")
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Written:" in done.stdout and "Goals" in done.stdout
    return folder


@pytest.fixture
def rows(bench: SimpleNamespace, small_run: Path) -> list[dict[str, Any]]:
    (path,) = small_run.glob("*.csv")
    found: list[dict[str, Any]] = bench.record.read(path)
    return found


def of(rows: list[dict[str, Any]], what: str, engine: str | None = "feeler") -> list[dict[str, Any]]:
    return [row for row in rows if row["what"] == what and engine in (None, row["engine"])]


# --- what a run records ---------------------------------------------------------------------------------------------


def test_every_cell_has_its_rows(rows: list[dict[str, Any]]) -> None:
    asked = {
        *(("nominal", "collide"), ("nominal", "is_colliding"), ("nominal", "contacts"), ("deep", "collide")),
        *(("near", "collide"), ("near", "is_colliding"), ("near", "distance"), ("near", "cast")),
    }
    cells = of(rows, "cell")
    assert {(row["tool"], row["kind"], row["query"]) for row in cells} == {
        (tool, *cell) for tool in ("torque", "wrench") for cell in asked
    }
    assert len(cells) == 2 * len(asked)
    for row in of(rows, "cell", None):
        assert row["size"] == 10_000 and 9_000 <= row["triangles"] <= 10_000
        assert row["poses"] == 3 and row["rounds"] == 1 and row["version"]
        assert (row["pairs"] > 0) == (row["kind"] != "near")
        assert 0 < row["median_us"] <= row["p95_us"] <= row["p99_us"] <= row["worst_us"]
        assert (row["triangle_tests"] is not None) == (row["engine"] == "feeler" and row["query"] == "collide")
    (build,) = of(rows, "build")
    assert build["one_core_s"] > 0 and build["bytes"] > 40 * build["triangles"]


def test_feeler_alone(rows: list[dict[str, Any]]) -> None:
    worst = of(rows, "worst")
    assert [row["tool"] for row in worst] == ["torque", "wrench"]
    assert all(row["poses"] == 20 and row["median_us"] <= row["worst_us"] for row in worst)
    (batch,) = of(rows, "batch")
    assert batch["tool"] == "torque" and batch["calls_per_s"] > 0 and batch["batch_1_per_s"] > 0
    two = (os.cpu_count() or 1) > 1
    assert (batch["batch_2_per_s"] is not None) == (batch["apart_2_per_s"] is not None) == two
    (call,) = of(rows, "call")
    assert call["median_us"] > 0 and call["over_core_us"] is not None


@pytest.mark.skipif(not PEERS, reason="neither Coal nor python-fcl is installed")
def test_engines_agree_but_for_differences_that_are_judged(rows: list[dict[str, Any]], small_run: Path) -> None:
    found = json.loads((small_run / "all.json").read_text(encoding="utf-8"))
    for peer in PEERS:
        own = of(rows, "cell", peer)
        assert {row["query"] for row in own} == {"collide", "is_colliding", "distance"}
        for row in own:
            assert row["feeler_wrong"] == row["unjudged"] == 0
            assert row["times_faster"] > 0 and row["times_faster_p95"] > 0
            if row["query"] != "collide":
                assert row["agreed"] + row["peer_wrong"] == 3
                continue
            # What feeler found is what both found, and what the peer missed.
            at = ("tool", "kind", "query")
            (cell,) = [cell for cell in found["cells"] if all(cell[name] == row[name] for name in at)]
            counts = cell["agreement"][peer]
            assert counts["agreed"] + counts["feeler_only_true"] == round(3 * cell["pairs"]["mean"])
            assert row["agreed"] == counts["agreed"]
            assert row["peer_wrong"] == counts["feeler_only_true"] + counts["peer_only_false"]


def test_who_is_wrong_is_counted_on_either_side(bench: SimpleNamespace) -> None:
    judged = bench.agreement.Agreement(5, 15, 1, 2, 3, 4, 5, 0).row()
    counted = {"agreed": 5, "peer_wrong": 2 + 3, "feeler_wrong": 4 + 5, "unjudged": 1}
    assert bench.rows.agreement_counts(judged) == counted
    casts = bench.rows.agreement_counts({"agreed": 7, "peer_earlier": 2, "peer_later": 1})
    assert casts == {"agreed": 7, "peer_wrong": 3, "feeler_wrong": 0, "unjudged": 0}


def test_the_best_peer_may_be_another_for_the_p95(bench: SimpleNamespace) -> None:
    about = {"query": "collide", "kind": "nominal"}
    peers = [
        {**about, "engine": "coal", "times_faster": 5.5, "times_faster_p95": 4.5},
        {**about, "engine": "fcl", "times_faster": 6.0, "times_faster_p95": 4.0},
    ]
    best = bench.goals.against_best(peers)
    assert (best.peer, best.median, best.p95, best.wanted, best.met) == ("coal", 5.5, 4.0, 5.0, False)
    assert bench.goals.against_best(peers[:1]).p95 == 4.5 and bench.goals.against_best([]) is None


# --- the record -----------------------------------------------------------------------------------------------------


def origin(bench: SimpleNamespace, **other: Any) -> Any:
    about = {"machine": "A CPU, AVX2", "cores": 2, "date": "2026-01-01", "commit": "aaaa", "release": "0.1.0"}
    return bench.record.Origin(**{**about, "changed": False, "profile": "release", **other})


def cell(tool: str = "hand", engine: str = "feeler", **other: Any) -> dict[str, Any]:
    about = {"what": "cell", "size": 100_000, "tool": tool, "kind": "nominal", "query": "collide", "engine": engine}
    return {**about, "version": "1", "poses": 100, "triangles": 99_996, "median_us": 12.3456789, **other}


def test_what_is_written_is_read(bench: SimpleNamespace, tmp_path: Path) -> None:
    path = bench.record.keep(
        [cell(bytes=6350964, p95_us=1e6 / 3, p99_us=4e-7), cell("torque")], origin(bench), tmp_path
    )
    assert path == tmp_path / "a-cpu-avx2-0.1.0.csv"
    first, second = bench.record.read(path)
    assert (first["tool"], second["tool"]) == ("torque", "hand")  # in the order of the bench
    assert second["machine"] == "A CPU, AVX2" and second["commit"] == "aaaa" and second["cores"] == 2
    assert second["bytes"] == 6350964 and second["poses"] == 100 and second["worst_us"] is None
    # Five digits, without an exponent.
    assert (second["median_us"], second["p95_us"], second["p99_us"]) == (12.346, 333330.0, 4e-7)
    assert "e" not in path.read_text().splitlines()[2].replace("feeler", "").replace("cell", "").replace("collide", "")
    before = path.read_bytes()
    assert bench.record.keep([], origin(bench), tmp_path).read_bytes() == before


def test_a_run_replaces_its_cells_only(bench: SimpleNamespace, tmp_path: Path) -> None:
    both = [cell(tool, engine) for tool in ("torque", "hand") for engine in ("feeler", "coal", "fcl")]
    bench.record.keep([*both, {"what": "build", "size": 100_000, "engine": "feeler"}], origin(bench), tmp_path)
    later = origin(bench, commit="bbbb", date="2026-01-02")
    path = bench.record.keep([cell(engine="feeler", median_us=1.0), cell(engine="coal")], later, tmp_path)
    found = bench.record.read(path)
    assert [(row["tool"], row["engine"], row["commit"]) for row in of(found, "cell", None)] == [
        *(("torque", engine, "aaaa") for engine in ("feeler", "coal", "fcl")),
        # The whole cell is new: no ratio of another run stays beside it.
        *(("hand", engine, "bbbb") for engine in ("feeler", "coal")),
    ]
    assert [row["commit"] for row in of(found, "build")] == ["aaaa"]
    assert len(list(tmp_path.iterdir())) == 1
    other = bench.record.keep([cell()], origin(bench, release="0.2.0"), tmp_path)
    assert other != path and bench.record.read(path) == found


def test_what_may_not_go_into_the_record(
    bench: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench.record, "RECORDS", tmp_path / "kept")
    monkeypatch.setattr(bench.record, "SCRATCH", tmp_path / "scratch")
    assert origin(bench).reasons_against(["feeler"]) == []
    for other, said in (
        ({"changed": True}, "not committed"),
        ({"commit": ""}, "which commit"),
        ({"profile": "dev"}, "profile dev"),
    ):
        (reason,) = origin(bench, **other).reasons_against(["feeler"])
        assert said in reason
    path = bench.record.keep([cell(), cell(engine="coal")], origin(bench))
    assert path.parent == tmp_path / "kept"
    before = path.read_bytes()
    (reason,) = origin(bench).reasons_against(["feeler"])
    assert "coal" in reason and origin(bench).reasons_against(["feeler", "coal", "fcl"]) == []
    # A reason against: the record stays as it is. A folder that is named is written to in any case.
    assert bench.record.keep([cell(median_us=1.0)], origin(bench), reasons=[reason]).parent == tmp_path / "scratch"
    assert bench.record.keep([cell()], origin(bench), tmp_path / "named", [reason]).parent == tmp_path / "named"
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--quick"], "--poses is 40, not 100"),
        (["--poses", "300"], "--poses is 300, not 100"),
        (["--rounds", "5"], "the best engines get no further rounds"),
        (["--seed", "1"], "--seed is 1, not 0"),
        (["--sizes", "10k", "--tools", "torque", "--worst", "0", "--batch", "0"], None),
    ],
)
def test_a_run_unlike_the_others_is_told(
    root: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str | None
) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    options = importlib.import_module("options")
    short = options.parse(arguments, "Head.\n\nexamples\n\nTail.").short
    assert (said is None and short == []) or said in short


def test_a_quick_run_leaves_the_record_alone(root: Path, tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in (root / "bench" / "records").iterdir()}
    done = run(root, "run.py", *TINY, *SKIP, "--no-peers", "--queries", "collide", CARGO_TARGET_DIR=str(tmp_path))
    assert done.returncode == 0 and "does not go into bench/records: --poses is 3, not 100" in done.stderr
    (written,) = (tmp_path / "bench" / "records").iterdir()
    assert f"Written: {written}" in done.stdout
    assert before == {path: path.read_bytes() for path in (root / "bench" / "records").iterdir()}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "No such file"),
        ("", "other columns"),
        ("what,size\n", "other columns"),
        ("{}\ncell,1\n", "too few fields"),
        ("{}\n{},\n", "too many fields"),
        ("{}\ncell,x{}\n", "invalid literal"),
    ],
)
def test_what_is_no_record_is_refused(bench: SimpleNamespace, tmp_path: Path, text: str | None, said: str) -> None:
    path, heads = tmp_path / "a.csv", ",".join(bench.record.COLUMNS)
    nothing = "," * (len(bench.record.COLUMNS) - 1)
    if text is not None:
        path.write_text(text.format(heads, nothing), encoding="utf-8")
    with pytest.raises(bench.record.RecordError, match=said):
        bench.record.read(path)


def test_the_readme_explains_every_column(root: Path, bench: SimpleNamespace) -> None:
    page = (root / "bench" / "README.md").read_text(encoding="utf-8")
    table = page.partition("| column | meaning |")[2].partition("\n\n")[0]
    ranged = bench.record.STAGES[1:-2]  # `voxels_visited` ... `exact_tests`
    assert [name for name in bench.record.COLUMNS if name not in ranged and f"`{name}`" not in table] == []


def test_the_newest_release_of_each_machine(bench: SimpleNamespace, tmp_path: Path) -> None:
    for machine, release, date in (
        ("One", "0.9.0", "2026-02-01"),
        ("One", "0.10.0", "2026-01-01"),
        ("Two", "0.9.0", "2026-01-15"),
    ):
        bench.record.keep([cell()], origin(bench, machine=machine, release=release, date=date), tmp_path)
    # A few cells measured again do not make a machine the first.
    bench.record.keep([cell("torque")], origin(bench, machine="One", release="0.10.0", date="2026-03-01"), tmp_path)
    found = bench.record.newest(tmp_path)
    assert [rows[0]["machine"] for rows in found] == ["Two", "One"]
    assert {row["date"] for row in found[1]} == {"2026-01-01", "2026-03-01"}


def test_the_record_is_small_and_clean(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    kept = list((root / "bench" / "records").iterdir())
    paths = [path for path in kept if path.suffix == ".csv"]
    sections = {"feel.json", "workbench.json", "clash.json", "mechanism.json", "removal.json", "reaching.json"}
    sections |= {"maintain.json"}
    assert paths and {path.name for path in kept if path not in paths} <= sections
    assert sum(path.stat().st_size for path in kept) < 1_000_000
    for path in paths:
        rows = bench.record.read(path)
        assert all(row["commit"] and row["date"] and row["feeler_wrong"] in (None, 0) for row in rows)
        # As `keep` writes it, byte for byte, and where.
        ours = origin(bench, machine=rows[0]["machine"], release=path.stem.rpartition("-")[2])
        copy = Path(shutil.copy(path, tmp_path))
        assert bench.record.keep([], ours, tmp_path) == copy and copy.read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("cpu", "flags", "name"),
    [
        ("Intel(R) Xeon(R) Processor", ["avx2", "avx512f"], "Intel Xeon, AVX-512"),
        ("AMD EPYC", ["avx2"], "AMD EPYC, AVX2"),
        ("Neoverse-N1", ["asimd"], "Neoverse-N1, NEON"),
        ("A(TM) CPU @ 2.00GHz", [], "A, no AVX2, AVX-512 or NEON"),
    ],
)
def test_kinds_of_machines(bench: SimpleNamespace, cpu: str, flags: list[str], name: str) -> None:
    assert bench.host.name(cpu, flags) == name


# --- figures --------------------------------------------------------------------------------------------------------


def test_figures_are_what_the_record_says(root: Path, bench: SimpleNamespace) -> None:
    """`make figures` has nothing to do: README.md and docs/figures.md are what it makes from bench/records."""
    pages = bench.figures.written()
    assert set(pages) == {root / "README.md", root / "docs" / "figures.md"}
    for path, text in pages.items():
        assert path.read_text(encoding="utf-8") == text, f"{path.name}: run `make figures`"


def test_another_record_makes_other_figures(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    """What is shown comes from the rows, down to the last digit: one cell a hundredth slower shows on both pages."""
    records = shutil.copytree(root / "bench" / "records", tmp_path / "records")
    first = bench.record.newest(records)[0]
    of_readme = (1_600_000, "collide", "nominal")
    shown = [row for row in of(first, "cell") if (row["size"], row["query"], row["kind"]) == of_readme]
    slowest = max(shown, key=lambda row: float(row["median_us"]))
    (path,) = [path for path in records.glob("*.csv") if bench.record.read(path) == first]
    group = [row for row in first if all(row[name] == slowest[name] for name in bench.record.GROUP)]
    ours = origin(
        bench, machine=slowest["machine"], release=path.stem.rpartition("-")[2], commit="cccc", date="2030-01-01"
    )
    changed = [{**row, "median_us": row["median_us"] * (1.01 if row is slowest else 1.0)} for row in group]
    for row in changed:
        for name in bench.record.ORIGIN:
            del row[name]
    assert bench.record.keep(changed, ours, records) == path
    before, after = bench.figures.written(), bench.figures.written(records)
    for page in before:
        assert before[page] != after[page]
    assert "cccc" in after[root / "docs" / "figures.md"]


def test_tables_of_a_run(bench: SimpleNamespace, rows: list[dict[str, Any]]) -> None:
    text = bench.figures.page([rows])
    assert text.count("| torque | collide, ") == 3 and text.count("| wrench | is_colliding, ") == 2
    for above, line in itertools.pairwise(text.splitlines()):
        if above.startswith("|") and line.startswith("|"):
            assert above.count("|") == line.count("|")
    # Every stage has its column.
    assert tuple(bench.figures.STAGE_NAMES) == bench.record.STAGES
    block = bench.figures.readme(rows)
    lines = [line for line in block.splitlines() if line.startswith("|")]
    assert len(lines) == 2 + 2 and len({line.count("|") for line in lines}) == 1
    assert "Index built in" in block
    # A cell without poses says so, and no table breaks.
    nothing = {**dict.fromkeys(bench.record.COLUMNS), **cell("square"), "size": 10_000, "poses": 0}
    nothing |= {**{name: rows[0][name] for name in bench.record.ORIGIN}, "triangles": 1, "parts": 1}
    assert "| square | collide, nominal | no such pose found |" in bench.figures.page([[*rows, nothing]])


def test_goals_by_machine(bench: SimpleNamespace) -> None:
    def peers(median: float, p95: float) -> list[dict[str, Any]]:
        rows = [cell(), cell(engine="coal", times_faster=median, times_faster_p95=p95)]
        return [dict.fromkeys(bench.record.COLUMNS) | row for row in rows]

    one, other = peers(4.0, 9.0), peers(6.0, 6.0)
    one[0]["machine"], other[0]["machine"] = "A CPU, AVX2", "A CPU, AVX-512"
    lines = bench.figures.scorecard([one, other]).markdown().splitlines()
    assert lines[2] == "| goal | wanted | A CPU, AVX2 | A CPU, AVX-512 |"
    assert lines[4].endswith("| 5 in every cell | **0 of 1 cells, least 4.00** | 1 of 1 cells, least 6.00 |")
    assert lines[5].endswith("| 8 | **4.00** | **6.00** |")


def test_goals_of_growth_and_batches(bench: SimpleNamespace) -> None:
    def batch(two: float, cores: float) -> dict[str, Any]:
        rates = {"batch_1_per_s": 100.0, "batch_2_per_s": two, "apart_2_per_s": 190.0, "cores_had": cores}
        return dict.fromkeys(bench.record.COLUMNS) | {"what": "batch", "tool": "hand", "engine": "feeler", **rates}

    met = [bench.goals.scorecard([batch(*of)])[0].met for of in ((195.0, 2.0), (150.0, 1.5), (150.0, 2.0))]
    assert met == [True, None, False]
    sizes = ((100_000, 10.0, 5.0), (1_600_000, 20.0, 12.0))
    grown = [cell(size=size, triangles=size, pairs=pairs, median_us=us) for size, pairs, us in sizes]
    (goal,) = bench.goals.scorecard([dict.fromkeys(bench.record.COLUMNS) | row for row in grown])
    assert (goal.wanted, goal.found, goal.met) == ("less than the pairs', 2.00", "2.40", False)


# --- the clock ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("more_s", "most", "expected"), [(60.0, 0, 2), (60.0, 5, 5), (0.0, 5, 2)])
def test_those_in_play_have_more_rounds(
    root: Path, monkeypatch: pytest.MonkeyPatch, more_s: float, most: int, expected: int
) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    measure = importlib.import_module("measure")
    monkeypatch.setattr(measure, "MORE_S", more_s)
    asked: list[str] = []
    took = {"a": 5.0, "b": 2.0, "c": 3.0, "d": 3.1}

    def clock_once(call: Any) -> tuple[float, float]:
        asked.append(call())
        return took[asked[-1]], took[asked[-1]]

    monkeypatch.setattr(measure, "clock_once", clock_once)
    engines = [SimpleNamespace(name=name, aim=lambda *_, own=name: lambda: own) for name in "abcd"]
    times = measure.clock(engines, np.zeros((3, 4, 4)), 2, "collide", most)
    # The first, the best of the others, and who is close to that.
    rounds = {"a": expected, "b": expected, "c": expected, "d": 2}
    assert {name: (own.wall.shape, own.cpu.shape) for name, own in times.items()} == {
        name: ((count, 3), (count, 3)) for name, count in rounds.items()
    }
    assert all(
        (own.wall == took[name]).all() and own.figures()["rounds"] == rounds[name] for name, own in times.items()
    )
    # Of the rounds that both have: what one was spared in a later round does not count against the other.
    times["a"].wall[2:] = times["a"].cpu[2:] = 0.1
    assert measure.ratios(times["a"], times["d"])["wall"]["of_medians"] == pytest.approx(3.1 / 5.0)
    # One engine after the other, and who is first changes.
    turns = ["abcd", "bcda", "cab", "abc", "bca"][:expected]
    assert "".join(asked) == "".join(own * 3 for turn in turns for own in turn)


def test_what_a_query_needs_at_least(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    limit = importlib.import_module("claims.limit")
    faces = np.array([[0, 1, 2], [2, 1, 3], [100, 101, 102]] * 100)
    stats = dict.fromkeys(("voxels_visited", "clusters_placed", "pieces_scanned", "entries_scanned"), 16)
    nothing = limit.needed(faces, np.zeros((0, 2), dtype=np.uint32), {**stats, "triangle_tests": 0})
    assert (nothing.scattered, nothing.in_row, nothing.answer) == (0, 16 * 836 // 64, 0)
    pairs = np.array([[0, 0], [0, 1], [1, 1], [1, 2]])
    some = limit.needed(faces, pairs, {**stats, "triangle_tests": 20})
    # Faces 0 to 2 lie in one line, corners 0 to 3 in two, 100 to 102 in two more.
    assert some.scattered == 1 + 2 + 2
    assert some.answer == 4 * (limit.TEST + limit.MEET) / 16
    assert some.instructions == nothing.instructions + some.answer + limit.TEST
    core = limit.Machine([64, 6400], [1.0, 3.0], [1.0, 1.0], [1.0, 1.0], 1.0, 1.0)
    assert [core.price("random", size) for size in (1, 640, 10**9)] == pytest.approx([1.0, 2.0, 3.0])


@pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")
def test_the_limit_at_toy_size(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    arguments = ["--size", "10000", "--tools", "torque", "--poses", "2", "--rounds", "1"]
    done = run(root, "claims/limit.py", *arguments, CARGO_TARGET_DIR=str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "does not go into bench/records" in done.stdout
    (path,) = (tmp_path / "bench" / "records").iterdir()
    rows = bench.record.read(path)
    limits, levels = of(rows, "limit"), of(rows, "level", None)
    assert [row["kind"] for row in limits] == ["nominal", "near", "deep"]
    for row in limits:
        assert row["limit_us"] > 0 and row["limit_us"] >= 0.99 * max(row["memory_us"], row["lanes_us"])
    assert {row["engine"] for row in levels} >= {"feeler-portable"}
    assert all(row["median_us"] > 0 for row in levels)
    assert "## The machine's limit" in done.stdout and "## Instruction sets" in done.stdout


def test_growth_of_toy_engines(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    arguments = ("--sizes", "10k,20k", "--tools", "torque", "--poses", "4", "--rounds", "1", "--out", str(tmp_path))
    done = run(root, "claims/growth.py", *arguments)
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.iterdir()
    small, large = bench.record.read(path)
    assert small["size"] < large["size"] and small["triangles"] < large["triangles"]
    for row in (small, large):
        assert all(row[name] > 0 for name in ("pairs", "median_us", "again_us", "pair_ns", "again_pair_ns"))
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("| torque")]
    # The record keeps fewer digits than the table was made from.
    growth = float(line.split("|")[5])
    assert growth == pytest.approx(large["median_us"] / small["median_us"], abs=0.011)
    assert run(root, "claims/growth.py", "--sizes", "10k").returncode == 2


def test_selections_of_a_toy_engine(root: Path) -> None:
    done = run(root, "claims/selection.py", "--triangles", "10000", "--poses", "2", "--rounds", "1")
    assert done.returncode == 0, done.stderr
    first, head, *rows = done.stdout.splitlines()
    assert "triangles" in first and "collide" in head and len(rows) == 4
    for row in rows:
        assert all(float(figure) > 0 for figure in row[28:].split())


def test_scale_of_a_toy_engine(root: Path) -> None:
    few = (
        "--triangles",
        "10000",
        "--gearbox",
        "40000",
        "--entries",
        "1",
        "--workers",
        "1",
        "--rounds",
        "1",
        "--seconds",
        "1",
    )
    done = run(root, "scale.py", *few)
    assert done.returncode == 0, done.stderr
    rows = [line.split(" | ") for line in done.stdout.splitlines() if line.startswith("|")]
    assert len(rows) == 3 + 4 and rows[2][0].startswith("| ") and rows[-1][0] == "| 1 process"


def test_peers_may_be_absent(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    (tmp_path / "absent").mkdir()
    for name in ("coal", "fcl"):
        (tmp_path / "absent" / f"{name}.py").write_text("raise ImportError('not here')\n")
    arguments = [*TINY, *SKIP, "--kinds", "nominal", "--out", str(tmp_path / "records")]
    # No compiler and no cargo on the path, and nothing built before.
    nothing = {"PATH": str(tmp_path), "CARGO_TARGET_DIR": str(tmp_path / "target"), "CXX": ""}
    path = os.pathsep.join([str(tmp_path / "absent"), *filter(None, [os.environ.get("PYTHONPATH")])])
    without = run(root, "run.py", *arguments, PYTHONPATH=path, **nothing)
    assert without.returncode == 0 and "coal is absent: not here" in without.stderr
    for said in ("fcl is absent: not here", "embree is absent: no C++ compiler", "parry is absent: cargo not found"):
        assert said in without.stdout
    (written,) = (tmp_path / "records").iterdir()
    assert {row["engine"] for row in bench.record.read(written)} == {"feeler"}


@pytest.mark.skipif(not HAS_EMBREE, reason="no g++, or no Embree 3 to build against")
def test_embree_agrees(root: Path, bench: SimpleNamespace, tmp_path: Path) -> None:
    asked = ("--peers", "embree", "--kinds", "nominal", "--queries", "collide,is_colliding")
    done = run(root, "run.py", *TINY, *SKIP, *asked, "--out", str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = tmp_path.iterdir()
    rows = bench.record.read(path)
    assert {row["engine"] for row in rows} == {"feeler", "embree"}
    for row in of(rows, "cell", "embree"):
        assert row["agreed"] > 0 and row["feeler_wrong"] == 0 and row["version"].startswith("3.")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sizes", "5"], "at least 10,000"),
        (["--sizes", "many"], "no size"),
        (["--tools", "spoon"], "spoon"),
        (["--kinds", "far"], "no kind"),
        (["--queries", "weigh"], "no query"),
        (["--peers", "spoon"], "no peer"),
        (["--worst", "-1"], "from 1"),
        (["--poses", "0"], "from 1"),
    ],
)
def test_options_out_of_range_are_refused(root: Path, arguments: list[str], said: str) -> None:
    done = run(root, "run.py", *arguments)
    assert done.returncode == 2 and said in done.stderr


@pytest.mark.parametrize("script", ["run.py", "real_data.py"])
def test_help_has_examples(root: Path, script: str) -> None:
    done = run(root, script, "--help")
    assert done.returncode == 0 and "examples:" in done.stdout and f"python bench/{script}" in done.stdout


# --- the judge -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def judge(root: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("bench_judge", root / "bench" / "judge.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_judge_tells_one_unit_in_the_last_place(judge: ModuleType) -> None:
    floor = np.array([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]])
    tip = np.array([[0.25, 0.25, 0.1], [0, 0, 1], [1, 0, 1]])
    assert judge.meets(tip, floor)
    tip[0, 2] = np.nextafter(0.1, 1)
    assert not judge.meets(tip, floor)


def test_judging_is_bounded_and_says_what_was_left(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    agreement, measure = importlib.import_module("agreement"), importlib.import_module("measure")
    tool = feeler.sample_tool("torque")
    mockup = feeler.sample("engine", 10_000)
    scene, pose = feeler.Scene(mockup), np.eye(4)
    pose = feeler.sample_poses(scene, tool, "nominal", 1)[0]
    true = np.asarray(scene.collide(tool, pose).pairs)
    made_up = np.array([[i, j] for i in range(10) for j in range(10)], dtype=np.uint32)
    ours, theirs = measure.Findings(pairs=[true[1:]]), measure.Findings(pairs=[np.unique([*true, *made_up], axis=0)])
    whole = agreement.compare(mockup, tool, pose[None], ours, theirs)
    assert whole.differing >= 1 + 90 and whole.unjudged == 0
    assert whole.agreed == len(true) - 1 and whole.feeler_wrong == 1
    some = agreement.compare(mockup, tool, pose[None], ours, theirs, most=10)
    judged = some.peer_only_true + some.peer_only_false + some.not_queried
    assert judged == 10 and some.unjudged == some.differing - 10


# --- real data -----------------------------------------------------------------------------------------------------


def test_real_data_on_a_small_folder(root: Path, tmp_path: Path) -> None:
    models = tmp_path / "models"
    (models / "machine").mkdir(parents=True)
    (models / "tools-mine").mkdir()
    (models / "machine" / "SOURCE.txt").write_text("Waves, made by a test.\nLicence: MIT.\nNot for the table.\n")
    write_waves(models / "machine" / "waves.stl", 40)
    write_waves(models / "tools-mine" / "probe.stl", 4, size_mm=200.0)
    (models / "machine" / "empty.ply").write_text("")
    (models / "machine" / "notes.md").write_text("no mesh")
    out, figures = tmp_path / "docs" / "table.md", tmp_path / "figures.json"
    arguments = ["--tools", "probe.stl,missing.stl", "--least", "1000", "--poses", "3", "--rounds", "1"]
    if "coal" in PEERS:
        arguments.append("--peers")
    done = run(root, "real_data.py", str(models), *arguments, "--out", str(out), "--json", str(figures))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 files: 2 loaded, 1 refused with a message, 0 failed otherwise" in done.stdout
    assert "no tool called missing.stl" in done.stderr

    found = json.loads(figures.read_text(encoding="utf-8"))
    assert [row["name"] for row in found["files"]] == ["machine/empty.ply", "machine/waves.stl", "tools-mine/probe.stl"]
    assert found["files"][0]["message"].startswith("LoadError: machine/empty.ply")
    (mockup,) = found["mockups"]
    assert mockup["mockup"] == "machine/waves.stl" and mockup["triangles"] == 3200
    assert [cell["kind"] for cell in found["cells"]] == ["nominal", "near"]
    for cell in found["cells"]:
        assert cell.get("agreement", {}).get("feeler_wrong", 0) == 0

    table = out.read_text(encoding="utf-8")
    assert str(tmp_path) not in table and "FOLDER" in table
    assert "| machine/waves.stl |" in table and "Licence: MIT." in table and "Not for the table" not in table
    # Every row of a table has as many fields as its heading.
    lines = table.splitlines()
    for above, line in itertools.pairwise(lines):
        if above.startswith("|") and line.startswith("|"):
            assert above.count(" | ") == line.count(" | ")


def test_real_data_says_when_there_is_no_folder(root: Path, tmp_path: Path) -> None:
    done = run(root, "real_data.py", FEELER_MODELS=str(tmp_path / "none"))
    assert done.returncode == 2 and "FEELER_MODELS" in done.stderr


def write_waves(path: Path, cells: int, size_mm: float = 1000.0) -> None:
    """A binary STL of a wavy sheet: 2 * cells^2 triangles."""
    steps = np.linspace(0, size_mm, cells + 1)
    x, y = np.meshgrid(steps, steps, indexing="ij")
    z = 0.05 * size_mm * np.sin(9 * x / size_mm) * np.cos(7 * y / size_mm)
    points = np.stack([x, y, z], axis=-1).astype(np.float32)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]).reshape(-1, 3, 3)
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = triangles
    path.write_bytes(b"made by a test".ljust(80) + len(triangles).to_bytes(4, "little") + rows.tobytes())
