"""The answer of `task`, and the files that it writes."""

from __future__ import annotations

import os

from feeler.field_docs import documented
from feeler.mockup import Mockup
from feeler.tasks.as_glb import SPEED, write_task_glb
from feeler.tasks.gantt import write_html
from feeler.tasks.reached import TaskTools
from feeler.tasks.steps import TaskFacts
from feeler.tasks.workbook import write_xlsx


@documented
class Task(TaskFacts):
    """How parts are taken out: the best plan that was found, in steps; true if there is one. See `task`."""

    def to_html(self, path: str | os.PathLike[str]) -> None:
        """Writes a page with a Gantt chart and the arithmetic of each step. It loads nothing. Raises `WriteError`."""
        write_html(path, self)

    def to_xlsx(self, path: str | os.PathLike[str]) -> None:
        """Writes a workbook: steps, totals, elements. Needs `feeler[xlsx]`. Raises `WriteError`, `OptionError`."""
        write_xlsx(path, self)

    def to_glb(
        self, path: str | os.PathLike[str], mockup: Mockup, tools: TaskTools = None, speed: float = SPEED
    ) -> int:
        """Writes a film as GLB; returns its size in bytes. Parts that leave are blue, tools orange, parts nearby grey.

        - `mockup`: that of the scene. `tools`: as `task` took them.
        - `speed`: how many times as fast as the work the film runs.

        Raises `WriteError`, and `OptionError` for another mock-up, other tools, or a task without a plan.
        """
        return write_task_glb(path, mockup, self, tools, speed)


class TaskInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.task` has the best plan until then, if there was one, with `is_found` False: its ways were not checked.
    Its `bound` is right: no plan is below."""

    def __init__(self, task: Task) -> None:
        self.task = task
        super().__init__(f"interrupted: {task.said}")

    def __reduce__(self) -> tuple[type[TaskInterrupted], tuple[Task]]:
        return (type(self), (self.task,))
