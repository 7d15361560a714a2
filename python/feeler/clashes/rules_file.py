"""Writes a first file of rules from the findings of a check."""

from __future__ import annotations

import json
import os
import re
from collections import Counter

from feeler.arguments import check_kind
from feeler.atomic import atomic_file
from feeler.clashes.fastener_rule import is_fastener
from feeler.clashes.result import Clashes
from feeler.io.toml import LONE, VERSION, quoted

_WRITTEN = 30
"""Most rules, and most pairs in contact, that `write_rules` lists. Nobody reads more."""


def write_rules(path: str | os.PathLike[str], clashes: Clashes) -> None:
    """Writes a first file of rules from the findings of a check.

    It has a rule for each pair of sub-assemblies with findings. The limits are those of the check, so the same findings
    come back. Comments suggest exclusions: parts in contact, and fasteners. Raises `WriteError`.
    """
    check_kind("clashes", clashes, Clashes)
    with atomic_file(path, ".toml") as file:
        file.write(_text(clashes).encode("utf-8"))


def _text(clashes: Clashes) -> str:
    facts = clashes.facts
    contact = json.dumps(facts.contact)
    lines = [
        "# Rules of a clash check: the first rule that names a pair applies. See docs/clash.md",
        f"# Started from {len(clashes):,} findings, at a clearance of {facts.clearance:g} m.",
        f"version = {VERSION}",
        "others = true  # false: skip pairs that no rule names",
    ]
    level = _telling_level(clashes.part_paths)
    count = Counter(_assemblies(clashes, level))
    names: set[str] = set()
    for (one, other), number in count.most_common(_WRITTEN):
        name = _unused(f"within {_last(one)}" if one == other else f"{_last(one)} against {_last(other)}", names)
        lines += [
            *("", "[[rule]]", f"name = {quoted(name)}  # {number:,} findings"),
            *(f"a = {quoted(pattern_of(one))}", f"b = {quoted(pattern_of(other))}"),
            *(f"clearance = {facts.clearance!r}", f"contact = {contact}", 'severity = "major"'),
        ]
    touching = clashes.where(verdict="contact")
    mates = Counter(
        (clashes.part_paths[a], clashes.part_paths[b])
        for a, b in zip(touching.parts_a.tolist(), touching.parts_b.tolist(), strict=True)
    )
    if mates:
        lines += ["", f"# {len(touching):,} pairs touch. Exclude those that are meant to, such as:"]
    for one, other in list(mates)[:_WRITTEN]:
        lines += ["#", "# [[exclude]]", f"# name = {quoted(f'{_last(one)} on {_last(other)}')}"]
        lines += [f"# a = {quoted(pattern_of(one))}", f"# b = {quoted(pattern_of(other))}"]
    fastened = sum(
        is_fastener(clashes.part_paths[a]) is True or is_fastener(clashes.part_paths[b]) is True
        for a, b in zip(clashes.parts_a.tolist(), clashes.parts_b.tolist(), strict=True)
    )
    lines += [
        *(
            "",
            f"# {fastened:,} findings have a part named like a fastener. This hides fasteners, by name and shape:",
        ),
        *("#", "# [[exclude]]", '# name = "standard parts"', "# fasteners = true"),
    ]
    return "\n".join(lines) + "\n"


def _assemblies(clashes: Clashes, level: int) -> list[tuple[str, str]]:
    """For each finding the sub-assemblies of both parts, sorted by name."""
    found = []
    for a, b in zip(clashes.parts_a.tolist(), clashes.parts_b.tolist(), strict=True):
        one, other = sorted("/".join(clashes.part_paths[part].split("/")[:level]) for part in (a, b))
        found.append((one, other))
    return found


def _telling_level(paths: tuple[str, ...]) -> int:
    """The first level at which the paths differ: a common root would be one sub-assembly for all."""
    steps = [path.split("/") for path in paths]
    deepest = max((len(each) for each in steps), default=1)
    return next((level for level in range(1, deepest) if len({tuple(each[:level]) for each in steps}) > 1), deepest)


def _last(path: str) -> str:
    return path.rpartition("/")[2] or path


def _unused(name: str, names: set[str]) -> str:
    found, number = name, 2
    while found in names:
        found, number = f"{name} {number}", number + 1
    names.add(found)
    return found


def pattern_of(path: str) -> str:
    """What names a path and all below it: the path, or a regular expression where rules misread the path."""
    is_plain = path not in ("", "*") and not path.startswith("re:") and not path.endswith("/") and not LONE.search(path)
    return path if is_plain else f"re:(?s:{LONE.sub('.', re.escape(path))}(/.*)?)"
