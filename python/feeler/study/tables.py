"""The tables of the studies, as text and numbers: for the terminal, the page and the documentation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Section:
    """A title, an explanation, and a table; the first `words` columns are text."""

    title: str
    text: list[str]
    heading: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    words: int = 2
    caption: str = ""  # of the plot, for pages that have it


def sections_of(results: dict[str, Any]) -> list[Section]:
    """The sections of a study's results."""
    makers = {
        "voxel-size": _voxel_size,
        "hashing": _hashing,
        "scaling": _scaling,
        "filters": _filters,
        "piece-size": _piece_size,
    }
    return makers[results["study"]](results)


def _voxel_size(results: dict[str, Any]) -> list[Section]:
    rows, found = results["rows"], results["summary"]
    names = [*rows[0]["estimators"]]
    store = results["storage"] + (f" at hashing level {results['hashing']:.0%}" if results["hashing"] else "")
    about = [
        f"Time of a query by voxel size (store: {store}) for {found['pairs']} pairs of a mock-up and a tool, and the "
        "best sizes by four estimators that measure nothing on the pair. Poses are nominal: 1 to 5 % of the tool's "
        "triangles collide. Times are means over the poses of medians over the rounds; each round measures all sizes "
        "in random order.",
    ]
    caption = (
        "Black: measured, with quartiles over the rounds and a polynomial of the 5th degree. Red, dashed: predicted. "
        "Upright lines: the estimators' sizes."
    )
    overall = Section(
        "Over all pairs",
        [
            "Slower: time at an estimator's size over the best time of the sweep; also on the fit, which noise affects "
            "less. The sizes of area and calibrated were built and measured; the others are read from the fit, or from "
            "its end if they lie beyond the sweep. Quiet: from the lower quartile over the rounds instead of the "
            "median, which other programs disturb less.",
            "Rank correlation of predicted and measured time (quiet) over the sizes of a pair: median "
            f"{found['rank_correlation_median']:.3f}, worst {found['rank_correlation_worst']:.3f}; of the counted work "
            f"of the measured queries at the same costs: median {found['rank_of_counted_median']:.3f}, worst "
            f"{found['rank_of_counted_worst']:.3f}. Choosing the "
            f"calibrated size takes {found['choosing_share_median']:.1%} of the build in the median, "
            f"{found['choosing_share_worst']:.1%} at worst.",
        ],
        [
            "estimator",
            "slower, median",
            "worst",
            "quiet, median",
            "worst",
            "on the fit, median",
            "worst",
            "in the zone of +10 %",
            "of +1 ms",
        ],
        [
            [
                name,
                f"{each['over_best_median']:+.1%}",
                f"{each['over_best_worst']:+.1%}",
                f"{each['over_quiet_median']:+.1%}" if each["over_quiet_median"] is not None else "–",
                f"{each['over_quiet_worst']:+.1%}" if each["over_quiet_worst"] is not None else "–",
                f"{each['over_fit_median']:+.1%}",
                f"{each['over_fit_worst']:+.1%}",
                f"{each['in_relative_zone']} of {found['pairs']}",
                f"{each['in_absolute_zone']} of {found['pairs']}",
            ]
            for name, each in found["estimators"].items()
        ],
        words=1,
    )
    table = Section(
        "Table 2",
        [
            "Sizes in mm. Optimum: of the fit. Zone: the sizes at most 10 % slower than the optimum; those at most "
            "1 ms slower (the paper's rule for 10 Hz) in brackets. A + marks a zone that goes beyond the sizes "
            "measured. eps is equation 11 with the zone of 10 %: up to 1 is inside.",
        ],
        ["mock-up", "tool", "optimum", "µs", "zone", *(f"{name} (eps)" for name in names), "calibrated: slower"],
        [
            [
                row["mockup"],
                row["tool"],
                _mm(row["fit"]["optimum_m"]),
                f"{1e6 * row['fit']['seconds']:.0f}",
                f"{_zone(row['zones']['relative'])} ({_zone(row['zones']['absolute'])})",
                *(f"{_mm(e['size_m'])} ({_eps(e['epsilon']['relative'])})" for e in row["estimators"].values()),
                f"{row['estimators']['calibrated']['over_best']:+.1%}",
            ]
            for row in rows
        ],
    )
    return [Section("", about, caption=caption), overall, table]


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.1f}" if metres < 0.1 else f"{1e3 * metres:.0f}"


def _eps(value: float | None) -> str:
    """None: infinite, see `curves.epsilon`."""
    return "–" if value is None else f"{value:.2f}"


def _zone(zone: dict[str, Any]) -> str:
    return f"{_mm(zone['least_m'])}–{_mm(zone['most_m'])}{'+' if zone['is_cut'] else ''}"


def _hashing(results: dict[str, Any]) -> list[Section]:
    about = [
        "Memory of the index alone (without the triangles) and time of a query, for the paper's array (dense), its "
        "hashed array (equation 1: a level of 70 % saves 70 % of the voxel array, so voxels share lists), and blocks.",
        "Free: the highest level whose time is at most 10 % more than that of level 0.",
    ]
    rows = []
    for row in results["rows"]:
        for at in row["sizes"]:
            hashed = at["hashed"]
            rows.append(
                [
                    row["mockup"], row["tool"], _mm(at["size_m"]), f"{at['dense']['bytes'] / 1e6:.1f}",
                    *(f"{each['bytes'] / 1e6:.1f}" for each in hashed if each["level"] in (0.7, 0.95)),
                    f"{row['blocks']['bytes'] / 1e6:.1f}", f"{1e6 * at['dense']['seconds']:.0f}",
                    *(f"{1e6 * each['seconds']:.0f}" for each in hashed if each["level"] in (0.0, 0.5, 0.7, 0.9, 0.95)),
                    f"{1e6 * row['blocks']['seconds']:.0f}", f"{at['free_level']:.0%}",
                ]
            )  # fmt: skip
    heading = [
        "mock-up",
        "tool",
        "voxel, mm",
        "dense, MB",
        "70 %, MB",
        "95 %, MB",
        "blocks, MB",
        "dense, µs",
        "0 %, µs",
        "50 %, µs",
        "70 %, µs",
        "90 %, µs",
        "95 %, µs",
        "blocks, µs",
        "free",
    ]
    return [Section("", about), Section("Memory and time", [], heading, rows)]


def _scaling(results: dict[str, Any]) -> list[Section]:
    about = ["How the time of a query grows with the mock-up and with the tool. Dense: at its calibrated size."]
    rows = [
        [
            row["mockup"], row["tool"], f"{row['mockup_triangles']:,}", f"{row['tool_triangles']:,}",
            _mm(row["dense_size_m"]) if row["dense_size_m"] else "–",
            f"{1e6 * row['seconds']['dense']:.0f}" if row["seconds"]["dense"] else "–",
            f"{1e6 * row['seconds']['blocks']:.0f}",
        ]
        for row in results["rows"]
    ]  # fmt: skip
    trends = [
        [each["of"], each["with"], each["storage"], f"{each['exponent']:.2f}"] for each in results["summary"]["trends"]
    ]
    return [
        Section("", about),
        Section(
            "Trends",
            ["Time grows with the size to this power."],
            ["with the triangles of", "fixed", "store", "exponent"],
            trends,
            words=3,
        ),
        Section(
            "Times",
            [],
            ["mock-up", "tool", "mock-up triangles", "tool triangles", "voxel, mm", "dense, µs", "blocks, µs"],
            rows,
        ),
    ]


def _filters(results: dict[str, Any]) -> list[Section]:
    found = results["summary"]
    about = [
        "Effect of the two filters before the triangle test: repeated pairs are skipped (repeats), and boxes are "
        "compared first (boxes; with blocks, planes). They do not change results. The paper: 50 % less time with both.",
        *(
            f"{storage}: with both, a query takes {each['saved_median']:.0%} less time than with neither (median; "
            f"{each['saved_least']:.0%} to {each['saved_most']:.0%})."
            for storage, each in found.items()
        ),
    ]
    rows = [
        [
            row["mockup"], row["tool"], storage,
            *(f"{1e6 * each[key]:.0f}" for key in ("neither", "repeats", "boxes", "both")),
            f"{1 - each['both'] / each['neither']:.0%}",
        ]
        for row in results["rows"]
        for storage, each in row["seconds"].items()
    ]  # fmt: skip
    return [
        Section("", about),
        Section(
            "Times, µs", [], ["mock-up", "tool", "store", "neither", "repeats", "boxes", "both", "saved"], rows, words=3
        ),
    ]


def _piece_size(results: dict[str, Any]) -> list[Section]:
    found = results["summary"]
    chosen = found["chosen"]
    about = [
        "The piece size is the blocks' counterpart of the voxel size: triangles longer than it are cut for the index. "
        "The default adds a quarter more pieces, for any tool; the chosen size has the least predicted work for the "
        "tool, with at most two more pieces per triangle.",
    ]
    caption = "Lines: measured time; dashed: the predicted work, all over the default's; diamonds: the chosen size."
    by_choice = [
        [name, *(f"{found['over'][which][key][how]:+.1%}" for key in ("best", "quiet") for how in ("median", "worst"))]
        for which, name in (("default", "default"), ("chosen", "chosen for the tool"))
    ]
    over_pairs = [
        f"Over {found['pairs']} pairs. Slower: time over the best of the sweep; quiet: from the lower quartile over "
        "the rounds instead of the median.",
        f"The chosen size's time over the default's: {chosen['over_default']['median']:+.1%} in the median, "
        f"{chosen['over_default']['least']:+.1%} to {chosen['over_default']['most']:+.1%}; its memory (index and "
        f"triangles) {chosen['memory']['median']:.2f} times, at most {chosen['memory']['most']:.2f} times and "
        f"{chosen['bytes_a_triangle']['most']:.0f} bytes a triangle; its build {chosen['build']['median']:.1f} times, "
        f"at most {chosen['build']['most']:.1f} times. Choosing takes {chosen['choosing_share']['median']:.1%} of the "
        f"build in the median, {chosen['choosing_share']['most']:.1%} at worst.",
        "Rank correlation of predicted work and measured time (quiet) over the sizes of a pair: median "
        f"{found['rank_correlation_median']:.3f}, worst {found['rank_correlation_worst']:.3f}.",
    ]
    by_size = [
        [f"{factor:.2f}", f"{time:.2f}", f"{memory:.2f}"]
        for factor, time, memory in zip(
            found["over_default"], found["median_time"], found["median_memory"], strict=True
        )
    ]
    rows = [
        [
            row["mockup"], row["tool"], *_size_and_time(row["default"]), *_size_and_time(row["best"]),
            *_size_and_time(row["chosen"]), f"{row['over']['default']['best']:+.1%}",
            f"{row['over']['chosen']['best']:+.1%}", f"{row['chosen']['bytes'] / row['default']['bytes']:.2f}",
        ]
        for row in results["rows"]
    ]  # fmt: skip
    heading = ["mock-up", "tool", "default, mm", "µs", "best, mm", "µs", "chosen, mm", "µs", "default slower",
               "chosen slower", "chosen's memory"]  # fmt: skip
    return [
        Section("", about, caption=caption),
        Section(
            "Over all pairs",
            over_pairs,
            ["size", "slower, median", "worst", "quiet, median", "worst"],
            by_choice,
            words=1,
        ),
        Section(
            "By piece size",
            ["Relative to the default; medians over the pairs."],
            ["piece size", "time", "memory"],
            by_size,
            words=0,
        ),
        Section("Pairs", [], heading, rows),
    ]


def _size_and_time(point: dict[str, Any]) -> list[str]:
    return [_mm(point["size_m"]), f"{1e6 * point['seconds']:.1f}"]
