"""Which rows of a report have pictures and films, and making them: bounded, with progress, and stopped by Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from feeler.errors import FeelerError
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.workbench.document import motion
from feeler.workbench.document.document import Check, Verdict
from feeler.workbench.engine.parts import with_places
from feeler.workbench.report.drawing import FRAMES, Drawing
from feeler.workbench.report.source import Source
from feeler.workbench.report.values import FindingRow, Media, Report, RequirementRow, WayRow

PICTURES = 60
"""Findings with a picture, unless another number is asked for; as many requirements, and as many ways."""
STEP_FRAMES = 2
"""Pictures of a work step."""
MOST_FILMS = 50
MOST_FILM_BYTES = 64 << 20
"""Of one film."""

Making = tuple[str, str, Callable[[], object]]


def media_of(
    source: Source,
    report: Report,
    pictures: int = PICTURES,
    progress: Progress | None = None,
    *,
    has_ways: bool = True,
) -> Media:
    """Draws the pictures and films of a report. Without a mock-up there are none.

    pictures: of at most so many findings, `pictured`, of violated requirements, and of ways. Ctrl-C ends it with those
    made so far, marked as partial. has_ways: whether ways are shown, in pictures and films.
    """
    media = Media()
    if source.mockup is None:
        return media
    maker = _Maker(source, media, source.mockup)
    work = maker.pairs(report, pictures)
    if has_ways:
        work += [*maker.ways(report, pictures), *maker.films(report)]
    try:
        for number, (kind, key, make) in enumerate(work):
            if progress is not None:
                progress(number / len(work), f"{kind} {number + 1} of {len(work)}")
            try:
                make()
            except (FeelerError, ValueError, ArithmeticError, LookupError):
                media.left_out.append(f"{kind} of {key}")  # of a part without triangles, or a place out of reach
    except KeyboardInterrupt:
        media.is_partial = True
    return media


def pictured(rows: Sequence[FindingRow], most: int) -> list[FindingRow]:
    """The findings with pictures, at most so many: in the order of the report, the worst of each group first."""
    first: dict[tuple[str, str], None] = {}
    heads: list[FindingRow] = []
    rest: list[FindingRow] = []
    for row in rows:
        if row.place is None:
            continue
        key = (row.status, row.group)
        (rest if key in first or row.is_touching else heads).append(row)
        first[key] = None
    chosen = {id(row) for row in [*heads, *rest][:most]}
    return [row for row in rows if id(row) in chosen]


class _Maker:
    def __init__(self, source: Source, media: Media, mockup: Mockup) -> None:
        self._source, self._media, self._mockup = source, media, mockup
        self._absent = source.document.absent
        self._drawing = Drawing(mockup, self._absent)
        self._placed: tuple[object, Drawing] | None = None

    def pairs(self, report: Report, most: int) -> list[Making]:
        """Pictures of requirements and findings."""
        wrong = [row for row in report.requirements if row.place is not None][:most]
        rows = pictured(report.findings, most)
        found = self._source.document.findings
        check = None if found is None else found.check
        verdicts = {each.id: each.verdict for each in self._source.document.requirements}

        def finding(row: FindingRow) -> Callable[[], object]:
            return lambda: self._pair(f"finding-{row.id}", row, check)

        def requirement(row: RequirementRow) -> Callable[[], object]:
            return lambda: self._pair(f"requirement-{row.id}", row, verdicts.get(row.id))

        return [
            *(("picture", f"requirement {row.name}", requirement(row)) for row in wrong),
            *(("picture", f"finding {row.id}", finding(row)) for row in rows),
        ]

    def _pair(self, key: str, row: FindingRow | RequirementRow, made: Check | Verdict | None) -> None:
        """Draws the parts where they lay when they were checked."""
        assert row.place is not None
        gone = () if made is None else (*made.out, *made.gripped)
        moved = {} if made is None else {part: place for part, place in made.moved.items() if part not in gone}
        drawing = self._drawing_at(moved)
        if drawing.can_show((row.place.a, row.place.b)):
            self._media.pictures[key] = [drawing.pair(row.place, gone)]

    def _drawing_at(self, moved: Mapping[int, motion.Row]) -> Drawing:
        """A drawing of the mock-up with parts elsewhere; the last one is kept."""
        places = tuple((part, place) for part, place in moved.items() if part < self._mockup.part_count)
        if not places:
            return self._drawing
        if self._placed is None or self._placed[0] != places:
            self._placed = (places, Drawing(with_places(self._mockup, dict(places)), self._absent))
        return self._placed[1]

    def ways(self, report: Report, most: int) -> list[Making]:
        """Pictures along ways and of steps."""
        rows = [(way, STEP_FRAMES if each.is_order else FRAMES) for each in report.questions for way in each.ways]
        rows += [(way, STEP_FRAMES) for way in report.steps]

        def way(row: WayRow, frames: int) -> Callable[[], object]:
            return lambda: self._way(row, frames)

        return [("picture", row.title, way(row, frames)) for row, frames in rows[:most]]

    def _way(self, row: WayRow, frames: int) -> None:
        if self._drawing.can_show(row.parts):
            self._media.pictures[row.key] = self._drawing.way(row, frames)

    def films(self, report: Report) -> list[Making]:
        """A film of each question with ways, and of the sequence."""
        given = [(f"question-{each.id}", each.ways) for each in report.questions if each.ways]
        given += [("sequence", report.steps)] if report.steps else []

        def film(key: str, rows: Sequence[WayRow]) -> Callable[[], object]:
            return lambda: self._film(key, rows)

        return [("film", key, film(key, rows)) for key, rows in given[:MOST_FILMS]]

    def _film(self, key: str, rows: Sequence[WayRow]) -> None:
        shown = [row for row in rows if self._drawing.can_show(row.parts) and len(row.poses) > 1]
        if not shown:
            return
        data = self._drawing.film(shown, self._absent)
        if len(data) <= MOST_FILM_BYTES:
            self._media.films[key] = data
        else:
            self._media.left_out.append(f"film of {key}")
