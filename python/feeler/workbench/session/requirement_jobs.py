"""The job that checks clearances that must hold, and their file."""

from __future__ import annotations

from feeler.errors import OptionError, WorkbenchError
from feeler.io.toml import quoted
from feeler.progress import Progress
from feeler.requirements import Requirement, verify
from feeler.workbench.document.answers import Written
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Verdict, plain
from feeler.workbench.document.protocol_findings import RequirementResult
from feeler.workbench.document.requirement_commands import requirements_of
from feeler.workbench.session.finding_jobs import FindingPlace, placed, threads

_FILE = "requirements.toml"


def verified(place: FindingPlace, given: Arguments, progress: Progress) -> list[RequirementResult]:
    """Checks the requirements in the scene as it is now, as "clash" does; for the command "requirements_checked"."""
    document = place.document
    if not document.requirements:
        raise WorkbenchError("there are no requirements", given.command, "add one first")
    mockup, scene = placed(place, progress)
    part_of = {path: part for part, path in enumerate(mockup.part_paths)}
    results: list[RequirementResult] = []
    for number, each in enumerate(document.requirements):
        progress(number / len(document.requirements), each.name)
        where = {"moved": document.moved, "out": document.out, "gripped": tuple(document.gripped)}
        try:
            (found,) = verify(scene, requirements_of([each]), threads=threads())
        except OptionError as error:
            made = Verdict("unknown", trouble=_short(str(error)), **where)  # type: ignore[arg-type]
        else:
            paths = [path for path in (found.path_a, found.path_b) if path is not None]
            points = tuple(point for point in (found.point_a, found.point_b) if point is not None)
            parts = tuple(part_of[path] for path in paths)
            made = Verdict(
                found.status,
                found.pairs,
                found.gap,
                found.depth,
                parts,
                points,
                found.trouble,
                **where,  # type: ignore[arg-type]
            )
        results.append({"id": each.id, "verdict": plain(made)})
    progress(1.0, "done")
    return results


def export_requirements(place: FindingPlace, given: Arguments, progress: Progress) -> Written:
    """Writes the requirements as TOML, for `feeler verify`."""
    progress(0.0, "writing")
    if not place.document.requirements:
        raise WorkbenchError("there are no requirements", given.command, "add one first")
    data = _toml(requirements_of(place.document.requirements)).encode()
    place.exports[_FILE] = data
    return {"name": _FILE, "bytes": len(data)}


def _toml(requirements: tuple[Requirement, ...]) -> str:
    lines = ["version = 1"]
    for each in requirements:
        (a,), (b,) = each.a, each.b
        lines += ["", "[[requirement]]", f"name = {quoted(each.name)}", f"a = {quoted(a)}", f"b = {quoted(b)}"]
        lines.append(f"gap = {each.gap!r}  # metres")
    return "\n".join(lines) + "\n"


def _short(text: str) -> str:
    """What is wrong, without what the page shows beside it."""
    return text.partition(": ")[2].partition(" (optional")[0] or text
