"""Clash check: classifies all pairs of parts of a mock-up, measures, tracks and reports them.

    Mockup, rules -> finding (the core's rows) -> Clashes (table) -> groups; diff, save; CSV, XLSX, JSON, HTML, BCF, GLB

The package is called `clashes` because `feeler.clash` is the function.
"""

from feeler.clashes.as_bcf import write_bcf
from feeler.clashes.as_csv import write_csv
from feeler.clashes.as_glb import write_clash_glb
from feeler.clashes.as_html import write_html
from feeler.clashes.as_json import report
from feeler.clashes.as_xlsx import write_xlsx
from feeler.clashes.bcf_in import BcfChanges, Comment, Topic, apply_bcf, read_bcf
from feeler.clashes.finding import ClashInterrupted, clash
from feeler.clashes.matching import PartMatch
from feeler.clashes.result import Changes, Clashes, Group, load_clashes
from feeler.clashes.rules import Exclusion, Rule, Rules
from feeler.clashes.rules_file import write_rules
from feeler.clashes.table import Clash, Facts
from feeler.clashes.variants import VariantsError, VariantsInterrupted, clash_variants
from feeler.clashes.verdict import Verdict

__all__ = [
    "BcfChanges",
    "Changes",
    "Clash",
    "ClashInterrupted",
    "Clashes",
    "Comment",
    "Exclusion",
    "Facts",
    "Group",
    "PartMatch",
    "Rule",
    "Rules",
    "Topic",
    "VariantsError",
    "VariantsInterrupted",
    "Verdict",
    "apply_bcf",
    "clash",
    "clash_variants",
    "load_clashes",
    "read_bcf",
    "report",
    "write_bcf",
    "write_clash_glb",
    "write_csv",
    "write_html",
    "write_rules",
    "write_xlsx",
]
