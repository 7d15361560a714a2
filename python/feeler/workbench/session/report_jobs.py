"""The job that writes one report of the document, to download."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from feeler.errors import WorkbenchError
from feeler.progress import Progress
from feeler.project.runs import RunFacts
from feeler.scene import Scene
from feeler.workbench.document.answers import CardAnswer, Written
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Document
from feeler.workbench.report.as_html import html_page
from feeler.workbench.report.content import report_of
from feeler.workbench.report.media import PICTURES, media_of
from feeler.workbench.report.source import of_document

_NAME = "report.html"
_MOST_PICTURES = 1000
_DRAWN = 0.95  # share of the progress


class ReportPlace(Protocol):
    """What this job needs of `asking.Place`."""

    @property
    def document(self) -> Document:
        """As it is at the start."""

    @property
    def scene(self) -> Scene:
        """The mock-up as it was loaded."""

    @property
    def exports(self) -> dict[str, bytes]:
        """Files written by jobs, by name."""

    @property
    def cards(self) -> Callable[[int], CardAnswer]:
        """The answer of a card."""

    @property
    def history(self) -> Callable[[], Sequence[Mapping[str, Any]]]:
        """The history of statuses, of a project."""

    @property
    def run(self) -> Callable[[], RunFacts | None]:
        """The last run of `feeler maintain`, of a project."""

    @property
    def renamed(self) -> Callable[[], Mapping[str, str]]:
        """The key of each renamed part by the one before, of a project."""


def report_file(place: ReportPlace, given: Arguments, progress: Progress) -> Written:
    """One page of what was found and done, with its films inside. `pictures`: as of `feeler report`."""
    pictures = given.whole("pictures", 0, _MOST_PICTURES) if given.has("pictures") else PICTURES
    progress(0.0, "report")
    document = place.document
    told = place.history(), place.run(), place.renamed()
    source = of_document(document, place.scene.mockup, _answers(place), *told)
    report = report_of(source)
    media = media_of(source, report, pictures, lambda share, stage: progress(_DRAWN * share, stage))
    progress(_DRAWN, "writing")
    data = html_page(report, media)
    place.exports[_NAME] = data
    return {"name": _NAME, "bytes": len(data)}


def _answers(place: ReportPlace) -> dict[int, CardAnswer]:
    found = {}
    for card in place.document.cards:
        if card.state == "done":
            try:
                found[card.id] = place.cards(card.id)
            except WorkbenchError:  # of another revision: not kept
                continue
    return found
