"""Answers the questions of cards, one after the other, in a thread of their own beside the hand."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace

from feeler.arguments import near
from feeler.errors import FeelerError, WorkbenchError
from feeler.progress import Progress
from feeler.tasks.replanning import Memory
from feeler.workbench.document.answers import CardAnswer
from feeler.workbench.document.document import Card, Document
from feeler.workbench.document.known import Way
from feeler.workbench.engine.hand import Hands
from feeler.workbench.engine.standing import Standing
from feeler.workbench.session.access_answers import reach
from feeler.workbench.session.answering import ANSWERS, Answered, Asked
from feeler.workbench.session.jobs import Job, JobCancelledError, Jobs
from feeler.workbench.session.line_ways import LINE_ANSWERS
from feeler.workbench.session.task_answers import parts_at, task_answer

TELL_S = 0.2
"""Progress is told at most this often."""
OPEN = ("waiting", "running")
"""States of cards without an answer."""

MOST_MEMORIES = 8
"""Cards whose plans are remembered, the last ones."""

Told = Callable[..., None]
"""Changes fields of a card: `told(number, **changes)`."""


Keep = Callable[[int, Answered], None]


class Cards:
    """Thread-safe. The thread begins with the first question."""

    def __init__(self, told: Told, keep: Keep | None = None) -> None:
        """keep: called with an answer before it is told."""
        self._told, self._keep = told, keep
        self._lock = threading.Lock()
        self._jobs: Jobs | None = None
        self._running: dict[int, Job] = {}
        self._answers: dict[int, Answered] = {}
        self._standing: Standing | None = None
        self._memories: dict[int, Memory] = {}
        """What the plans of tasks found, by card: an edit asks little of it again."""

    def open(self, hands: Hands, kept: Mapping[int, Answered] | None = None) -> None:
        """Another mock-up is open: earlier questions are given up. kept: answers of its cards, from a project."""
        with self._lock:
            for job in self._running.values():
                job.cancel()
            self._running, self._answers, self._memories = {}, dict(kept or {}), {}
            self._standing = Standing(hands.scene)

    def follow(self, before: Document, after: Document, hands: Hands) -> None:
        """Starts the questions that are new in a document, and gives up those that are gone or cancelled."""
        old = {card.id: card for card in before.cards}
        new = {card.id: card for card in after.cards}
        for number, card in new.items():
            known = old.get(number)
            is_new = known is None or known.state != "waiting" or known.edits != card.edits
            if card.state == "waiting" and is_new:
                self._give_up(number, is_gone=False)
                self._start(card, after, hands)
        for number, card in old.items():
            now = new.get(number)
            if now is None or (now.state == "cancelled" and card.state in OPEN):
                self._give_up(number, is_gone=now is None)

    @property
    def ways(self) -> dict[int, tuple[Way, ...]]:
        """The ways of answered cards."""
        with self._lock:
            return {number: found.ways for number, found in self._answers.items() if found.ways}

    def answer(self, number: int) -> CardAnswer:
        """The whole answer of a card. Raises `WorkbenchError` if there is none."""
        return self._answered(number).to_json(number)

    def room(self, number: int) -> bytes:
        """The swept volume of a card, packed. Raises `WorkbenchError` if there is none."""
        found = self._answered(number).room
        if found is None:
            raise WorkbenchError(f"card {number} has no swept volume", "cards", "ask what room the parts need")
        return found.data

    def close(self) -> None:
        """Gives up all questions."""
        with self._lock:
            jobs = self._jobs
        if jobs is not None:
            jobs.close()

    def _answered(self, number: int) -> Answered:
        with self._lock:
            found = self._answers.get(number)
            if found is None:
                there = [str(each) for each in self._answers]
                raise WorkbenchError(f"card {number} has no answer", "cards", near(str(number), there, "ask again"))
            return found

    def _start(self, card: Card, document: Document, hands: Hands) -> None:
        with self._lock:
            standing = self._standing
            assert standing is not None, "a mock-up is open"
            if self._jobs is None:
                self._jobs = Jobs()
            self._answers.pop(card.id, None)
            heard, own = [0.0], list[Job]()

            def hear(share: float, stage: str) -> None:
                now = time.monotonic()
                if now - heard[0] >= TELL_S:
                    heard[0] = now
                    self._told(card.id, share=min(1.0, max(0.0, share)), stage=stage)

            def work(progress: Progress) -> None:
                with self._lock:  # which is held until the job is known
                    job = own[0]
                self._work(card, document, hands, standing, progress, job)

            own.append(self._jobs.start(work, hear))
            self._running[card.id] = own[0]

    def _work(
        self, card: Card, document: Document, hands: Hands, standing: Standing, progress: Progress, job: Job
    ) -> None:
        try:
            self._told(card.id, state="running", share=0.0, stage="")
            found = self._found(card, document, hands, standing, progress)
        except JobCancelledError:
            return
        except (FeelerError, MemoryError) as error:
            self._told(card.id, state="failed", sentence=f"{str(error) or 'not enough memory'}", share=0.0, stage="")
        except Exception as error:
            # A page that waits for ever says nothing.
            self._told(card.id, state="failed", sentence=f"{type(error).__name__}: {error}", share=0.0, stage="")
        else:
            with self._lock:
                if job.is_given_up:
                    return
                self._answers[card.id] = found
            if self._keep is not None:
                self._keep(card.id, found)
            facts = () if card.line is None else found.way_facts
            self._told(
                card.id,
                state="done",
                sentence=found.sentence,
                is_good=found.is_good,
                clearances=tuple(way["clearance"] for way in facts),
                share=1.0,
                stage="",
            )
        finally:
            with self._lock:
                # The same question may have been asked again meanwhile.
                if self._running.get(card.id) is job:
                    del self._running[card.id]

    def _found(self, card: Card, document: Document, hands: Hands, standing: Standing, progress: Progress) -> Answered:
        if card.line is not None:
            return LINE_ANSWERS[card.question](document, card, hands, progress)
        off = parts_at(hands.scene.mockup, card.edits.off)
        scene = standing.scene(document, (*card.without, *off), lambda share, stage: progress(0.0, stage))
        there = tuple(part for part in card.parts if scene.part_mask[part])
        names = card.options.get("tools") or [each for each in [card.options.get("tool")] if each is not None]
        if card.options.get("catalogue") and "tools" not in card.options:
            # Those that the user opened come before the catalogue.
            built_in = hands.built_in()
            names = [name for name in hands.names if name not in built_in]
        tools = {str(name): hands.tool(str(name)) for name in names}
        # One core is left for the hand.
        threads = max(1, (os.cpu_count() or 2) - 1)
        asked = Asked(
            scene,
            there,
            card.options,
            tools,
            hands.built_in(),
            threads,
            card.edits,
            document.task_times.toml,
            document.task_catalogue.toml,
            unit=document.unit,
        )
        if card.question == "access":
            return reach(asked, progress)
        if card.question != "task":
            return ANSWERS[card.question](asked, progress)
        # Taken away meanwhile: a plan that is cancelled may leave half of something.
        with self._lock:
            memory = self._memories.pop(card.id, None) or Memory()
        found = task_answer(replace(asked, memory=memory), progress)
        with self._lock:
            if self._standing is standing:
                self._memories[card.id] = memory
                for number in list(self._memories)[:-MOST_MEMORIES]:
                    del self._memories[number]
        return found

    def _give_up(self, number: int, is_gone: bool) -> None:
        with self._lock:
            job = self._running.get(number)
            if job is not None:
                job.cancel()
            if is_gone:
                self._answers.pop(number, None)
                self._memories.pop(number, None)
