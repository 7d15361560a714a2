"""The jobs thread: runs long tasks one after the other, with progress, and cancels them on request."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from feeler.errors import WorkbenchError
from feeler.progress import Progress


class JobCancelledError(WorkbenchError):
    """A job was cancelled."""

    def __init__(self) -> None:
        super().__init__("the job was cancelled", "job", "start it again")

    def __reduce__(self) -> Any:
        return (type(self), ())


class Job(Future[Any]):
    """The future of a job. `cancel()` also cancels a running one: it ends at its next report of progress."""

    def __init__(self, work: Callable[[Progress], Any], on_progress: Progress) -> None:
        super().__init__()
        self._work, self._on_progress = work, on_progress
        self._is_given_up = threading.Event()

    @property
    def is_given_up(self) -> bool:
        """Whether it was cancelled, even if it has not ended yet."""
        return self._is_given_up.is_set()

    def cancel(self) -> bool:
        """Cancels it. False if it is already done."""
        self._is_given_up.set()
        return super().cancel() or not self.done()

    def run(self) -> None:
        """Runs it, in the calling thread."""
        if not self.set_running_or_notify_cancel():
            return
        try:
            result = self._work(self._report)
        except Exception as error:
            # The thread goes on with the next job; callers waiting for this one get the error unchanged.
            self.set_exception(error)
        else:
            self.set_result(result)

    def _report(self, share: float, stage: str) -> None:
        if self._is_given_up.is_set():
            raise JobCancelledError
        self._on_progress(share, stage)


class Jobs:
    """A thread that runs jobs one by one."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._running: Job | None = None
        self._is_closed = False
        self._thread = threading.Thread(target=self._loop, name="feeler jobs", daemon=True)
        self._thread.start()

    def start(self, work: Callable[[Progress], Any], on_progress: Progress) -> Job:
        """Appends a job to the queue. Raises `WorkbenchError` after `close`."""
        if self._is_closed:
            raise WorkbenchError("the session is closed", "job", "open the workbench again")
        job = Job(work, on_progress)
        self._waiting.put(job)
        return job

    def close(self) -> None:
        """Cancels running and waiting jobs, and ends the thread."""
        self._is_closed = True
        running = self._running
        if running is not None:
            running.cancel()
        self._waiting.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10.0)

    def _loop(self) -> None:
        while (job := self._waiting.get()) is not None:
            if self._is_closed:
                job.cancel()
            self._running = job
            job.run()
            self._running = None
