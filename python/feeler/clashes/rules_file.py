"""Reads rules from TOML, and writes a first file from the findings of a check.

version = 1
others = true                     # also check pairs that no rule names

[[rule]]
name = "rotor against casing"
a = "*rotor*"                     # a pattern of paths, a path with all below it, or several
b = ["*casing*", "re:.*/vane_[0-9]+"]
clearance = 0.005                 # metres
contact = 0.0001                  # metres, or "chord"
severity = "critical"             # critical, major (default), minor
level = 2                         # hide pairs with the same first two path steps

[[exclude]]
name = "seals in their grooves"
a = "*o-ring*"
b = "*housing*"                   # default: everything

[[exclude]]
name = "welded"
same_assembly = 3

[[exclude]]
name = "standard parts"
fasteners = true
"""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from feeler.clashes.fastener_rule import is_fastener
from feeler.clashes.rules import Exclusion, Rule, Rules, near
from feeler.clashes.table import Clashes
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io.atomic import atomic_file

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

VERSION = 1
_TABLES = {"rule": Rule, "exclude": Exclusion}
_WRITTEN = 30
"""Most rules, and most pairs in contact, that `write_rules` lists. Nobody reads more."""


def read_rules(path: str | os.PathLike[str]) -> Rules:
    """See `Rules.read`."""
    file = Path(path)
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: feeler clash --write-rules {file} starts one") from None
    except (OSError, UnicodeDecodeError) as error:
        raise LoadError(f"{file} cannot be read: {error}") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise LoadError(f"{file} is no TOML: {error}") from None
    try:
        return rules_of(data, str(file))
    except OptionError as error:
        raise LoadError(str(error)) from None


def rules_from(rules: object) -> Rules:
    """Rules from None, a dict, `Rules`, or a file. Raises `OptionError`, and errors as in `Rules.read`."""
    if rules is None:
        return Rules()
    if isinstance(rules, Mapping):
        return rules_of(rules)
    return rules if isinstance(rules, Rules) else Rules.read(rules)  # type: ignore[arg-type]


def rules_of(data: Mapping[str, Any], where: str = "rules") -> Rules:
    """The rules of a TOML document as a dict. Raises `OptionError` for mistakes in it."""
    _check_keys(data, ["version", "others", *_TABLES], where)
    if data.get("version", VERSION) != VERSION:
        raise OptionError(f"{where} is of version {data['version']!r}, and this feeler reads {VERSION}")
    others = data.get("others", True)
    if not isinstance(others, bool):
        raise OptionError(f"{where}: others is {others!r}: give true or false")
    made: dict[str, list[Any]] = {}
    for name, kind in _TABLES.items():
        tables = data.get(name, [])
        if not isinstance(tables, list) or not all(isinstance(each, Mapping) for each in tables):
            raise OptionError(f"{where}: {name} is no list of tables: write [[{name}]] above each")
        made[name] = [_made(kind, each, f"{where}, {name} {number}") for number, each in enumerate(tables, 1)]
    return Rules(tuple(made["rule"]), tuple(made["exclude"]), others, where)


def _made(kind: type[Any], table: Mapping[str, Any], where: str) -> Any:
    _check_keys(table, [each.name for each in fields(kind)], where)
    if not isinstance(table.get("name"), str) or not table["name"]:
        raise OptionError(f"{where}: it has no name; give one, findings refer to it")
    for name, value in table.items():
        if name in ("optional", "fasteners") and not isinstance(value, bool):
            raise OptionError(f"{where}: {name} is {value!r}: give true or false")
    try:
        return kind(**table)
    except OptionError as error:
        raise OptionError(f"{where}, {error}") from None


def _check_keys(table: Mapping[str, Any], known: list[str], where: str) -> None:
    for key in table:
        if key not in known:
            raise OptionError(f"{where}: there is no {key!r}: {near(key, known)}")


def write_rules(path: str | os.PathLike[str], clashes: Clashes) -> None:
    """Writes a first file of rules from the findings of a check.

    It has a rule for each pair of sub-assemblies with findings. The limits are those of the check, so the same findings
    come back. Comments suggest exclusions: parts in contact, and fasteners. Raises `WriteError`.
    """
    with atomic_file(path) as file:
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
            *("", "[[rule]]", f"name = {_quoted(name)}  # {number:,} findings"),
            *(f"a = {_quoted(one)}", f"b = {_quoted(other)}"),
            *(f"clearance = {facts.clearance!r}", f"contact = {contact}", 'severity = "major"'),
        ]
    touching = clashes.where(verdict="contact")
    mates = Counter(
        (clashes.part_paths[a], clashes.part_paths[b])
        for a, b in zip(touching.a.tolist(), touching.b.tolist(), strict=True)
    )
    if mates:
        lines += ["", f"# {len(touching):,} pairs touch. Exclude those that are meant to, such as:"]
    for one, other in list(mates)[:_WRITTEN]:
        lines += ["#", "# [[exclude]]", f"# name = {_quoted(f'{_last(one)} on {_last(other)}')}"]
        lines += [f"# a = {_quoted(one)}", f"# b = {_quoted(other)}"]
    fastened = sum(
        is_fastener(clashes.part_paths[a]) is True or is_fastener(clashes.part_paths[b]) is True
        for a, b in zip(clashes.a.tolist(), clashes.b.tolist(), strict=True)
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
    for a, b in zip(clashes.a.tolist(), clashes.b.tolist(), strict=True):
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


def _quoted(text: str) -> str:
    """A basic string of TOML."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
