"""The plots of a run. Without matplotlib there are none."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

Result = dict[str, Any]
COLOURS = {"feeler": "#1b6ca8", "penalty": "#c8553d", "point-shell": "#5b8c5a"}
SIZE = (7.5, 3.6)


def plots(result: Result, folder: Path) -> list[Path]:
    """Draws as PNG every plot for which a run has data; returns the files written."""
    if find_spec("matplotlib") is None:
        return []
    import matplotlib

    matplotlib.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, draw in DRAWN.items():
        whole = {
            face: found[name]
            for face, found in result["faces"].items()
            if name in found and "failed" not in found[name]
        }
        if whole:
            figure = draw(whole)
            path = folder / f"{name}.png"
            figure.savefig(path, dpi=110, metadata={"Software": None})
            written.append(path)
    return written


def _axes(columns: int = 1, **options: Any) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots(1, columns, **options)
    for one in axes if columns > 1 else [axes]:
        one.grid(True, color="#dddddd", linewidth=0.6)
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _colour(face: str) -> str:
    return COLOURS.get(face, "#555555")


def _forces(faces: dict[str, Result]) -> Any:
    contacts = list(next(iter(faces.values()))["spread"])
    figure, axes = _axes(len(contacts), sharey=True)
    for contact, own in zip(contacts, axes, strict=True):
        for face, found in faces.items():
            for frame, mark in (("flush", "o-"), ("turned", "s--")):
                rows = [r for r in found["rows"] if (r["contact"], r["frame"]) == (contact, frame)]
                own.semilogx(
                    [r["triangles"] for r in rows],
                    [r["magnitude_n"] for r in rows],
                    mark,
                    color=_colour(face),
                    markersize=3,
                    linewidth=1.0,
                    label=f"{face}, {frame}",
                )
        own.set_title(contact, fontsize=9)
        own.set_xlabel("triangles")
    axes[0].set_ylabel("force 1 mm deep, N")
    axes[0].legend(fontsize=6)
    return figure


def _sliding(faces: dict[str, Result]) -> Any:
    # one ball on each cylinder, and the flat face
    drawn = {
        face: [row for row in found["rows"] if row["surface"] in ("cylinder", "flat face")]
        for face, found in faces.items()
    }
    rows = next(iter(drawn.values()))
    figure, axes = _axes(len(rows), sharey=True)
    for at, own in enumerate(axes if len(rows) > 1 else [axes]):
        for face, found in drawn.items():
            trace = found[at]["trace_n"]
            own.plot(
                [k / max(1, len(trace) - 1) for k in range(len(trace))], trace, color=_colour(face), lw=1, label=face
            )
        own.set_title(f"{rows[at]['surface']}, {rows[at]['triangles']:,}", fontsize=8)
        own.set_xlabel("share of the way")
    first = axes[0] if len(rows) > 1 else axes
    first.set_ylabel("force, N")
    first.set_ylim(bottom=0)
    first.legend(fontsize=7)
    return figure


def _step_response(faces: dict[str, Result]) -> Any:
    delays = sorted({r["delay_ticks"] for r in next(iter(faces.values()))["rows"]})
    figure, axes = _axes(len(delays), sharey=True)
    for delay, own in zip(delays, axes if len(delays) > 1 else [axes], strict=True):
        for face, found in faces.items():
            for row in (r for r in found["rows"] if r["delay_ticks"] == delay):
                trace = row["trace_m"]
                time = [found["seconds"] * k / len(trace) for k in range(len(trace))]
                line = "-" if row["coupling"] == "its own" else ":"
                label = f"{face}, {row['coupling']}"
                own.plot(time, [1e3 * z for z in trace], line, color=_colour(face), lw=1, label=label)
        own.set_title(f"{delay} ms late", fontsize=9)
        own.set_xlabel("s")
        own.legend(fontsize=6)
    first = axes[0] if len(delays) > 1 else axes
    first.set_ylabel("device above the wall, mm")
    return figure


def _engine(faces: dict[str, Result]) -> Any:
    figure, axes = _axes()
    for found in faces.values():
        for row in found["rows"]:
            trace = row["trace_us"]
            way = [k / max(1, len(trace) - 1) for k in range(len(trace))]
            axes.semilogy(way, trace, lw=0.8, label=f"{row['tool']}, {row['triangles']:,} triangles")
    axes.axhline(1000.0, color="#888888", linewidth=0.8, linestyle=":")
    axes.set_xlabel("share of the way in and out")
    axes.set_ylabel("a step with collision, us")
    axes.legend(fontsize=7)
    return figure


DRAWN: dict[str, Callable[[dict[str, Result]], Any]] = {
    "forces": _forces,
    "sliding": _sliding,
    "step_response": _step_response,
    "engine": _engine,
}
