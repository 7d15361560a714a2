"""Project files: findings, answers and decisions about a mock-up, in one SQLite file.

    layout (tables, versions, limits) -> opening (connections that trust nothing), lock (one writer) -> store (rows)
    -> parts (what a revision changed), project (findings, history, answers)

It knows neither the workbench nor its threads: `feeler.workbench.session.saving` writes the document.
"""

from feeler.project.layout import SUFFIX
from feeler.project.parts import PartChanges
from feeler.project.project import Project, open_project

__all__ = ["SUFFIX", "PartChanges", "Project", "open_project"]
