"""Questions and jobs of a session: their subjects, their answers, and the files that jobs wrote."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from feeler.arguments import near
from feeler.errors import WorkbenchError
from feeler.progress import Progress
from feeler.project.book import Book
from feeler.project.runs import RunFacts
from feeler.workbench.document.answers import CardAnswer, JointPlace
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Document
from feeler.workbench.engine import measuring
from feeler.workbench.engine.geometry import Geometry
from feeler.workbench.engine.hand import Hands
from feeler.workbench.report.source import run_facts
from feeler.workbench.session.asking import ASKS, JOBS, Place, Recorded
from feeler.workbench.session.finding_jobs import TakenFindings
from feeler.workbench.session.jobs import Job, Jobs
from feeler.workbench.session.sent_files import SentFiles
from feeler.workbench.session.task_answers import tool_called

Places = Callable[[], Place]
"""The present subject. Raises `WorkbenchError` before a mock-up is open."""


class Requests:
    """Thread-safe. The jobs' thread begins with the first job."""

    def __init__(self, files: SentFiles) -> None:
        """files: those that pages send for jobs."""
        self._lock = threading.Lock()
        self._jobs: Jobs | None = None
        self._sight: tuple[object, measuring.Sight] | None = None
        self._exports: dict[str, bytes] = {}
        self._kept: Mapping[str, Any] | None = None
        self._files = files
        self.taken = TakenFindings()
        """Findings of jobs, for the command "findings_take"."""
        self.recorded: Recorded | None = None
        """The record to replay, if there is one."""
        self.project: Book | None = None
        """That of the session, if there is one."""
        self.joint_to: Callable[[Document, str, float | None], JointPlace] | None = None
        """Shows a joint at a value."""

    def forget(self, kept: Mapping[str, Any] | None) -> None:
        """Another mock-up is open: drops files and caches of the previous one. kept: how it was read."""
        with self._lock:
            self._exports, self._sight, self._kept = {}, None, kept
            self.taken = TakenFindings()

    def place(self, document: Document, hands: Hands, geometry: Geometry, cards: Callable[[int], CardAnswer]) -> Place:
        """The subject of questions and jobs: immutable, so that nothing waits for them."""
        world = hands.world(document)
        key = (world, document.hidden, document.sections, document.section_box)
        with self._lock:
            if self._sight is None or self._sight[0] != key:
                self._sight = (key, measuring.Sight(world, document))
            sight = self._sight[1]
            return Place(
                document,
                hands.scene,
                hands.meshes,
                sight,
                geometry,
                self._exports,
                self._files,
                self.taken,
                cards,
                self.recorded,
                tuple if self.project is None else self.project.history,
                self._run,
                self.joint_to,
                lambda card, name: tool_called(hands, document, card, name),
                dict if self.project is None else self.project.renamed,
                self._kept,
            )

    def _run(self) -> RunFacts | None:
        return None if self.project is None else run_facts(self.project)

    def ask(self, places: Places, name: str, args: dict[str, Any]) -> dict[str, Any] | None:
        """A question that changes nothing; see `asking.ASKS`. Raises `WorkbenchError`."""
        known = ASKS.get(name)
        if known is None:
            raise WorkbenchError(f"there is no question {name!r}", "ask", near(name, ASKS))
        answer: dict[str, Any] | None = known.work(places(), Arguments(name, args, known.arguments))
        return answer

    def job(self, places: Places, name: str, args: dict[str, Any], on_progress: Progress | None) -> Job:
        """Runs a long task in the jobs thread; see `asking.JOBS`. Raises `WorkbenchError`."""
        known = JOBS.get(name)
        if known is None:
            raise WorkbenchError(f"there is no job {name!r}", "job", near(name, JOBS))
        given = Arguments(name, args, known.arguments)
        place = places()

        def work(progress: Progress) -> Any:
            return known.work(place, given, progress)

        with self._lock:
            if self._jobs is None:
                self._jobs = Jobs()
            return self._jobs.start(work, on_progress or (lambda share, stage: None))

    def export(self, name: str) -> bytes:
        """A file written by a job. Raises `WorkbenchError`."""
        data = self._exports.get(name)
        if data is None:
            raise WorkbenchError(f"there is no {name!r}", "exports", near(name, self._exports, "start the job first"))
        return data

    def close(self) -> None:
        """Cancels all jobs."""
        if self._jobs is not None:
            self._jobs.close()
