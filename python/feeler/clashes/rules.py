"""The rules of a clash check, from TOML or Python: limits for pairs of parts, and pairs to hide.

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

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from feeler.arguments import (
    check_flag,
    check_kind,
    check_length,
    check_list,
    check_path,
    check_text,
    check_word,
    near,
    shown,
)
from feeler.choices import Chord, Severity
from feeler.clashes.verdict import DEFAULT_RULE, DEFAULT_SEVERITY, SEVERITIES
from feeler.errors import LoadError, OptionError
from feeler.field_docs import documented
from feeler.io.toml import check_version, parsed_toml, toml_of

Words = tuple[str, ...]
WordsLike: TypeAlias = str | Sequence[str]
EVERYTHING: Words = ("*",)


@documented
@dataclass(frozen=True)
class Rule:
    """Limits for some pairs of parts.

    a, b: patterns as `Parts.select` takes them, or `re:` and a regular expression for whole paths. The order of the two
    parts does not matter. clearance: metres. contact: metres, or "chord". level: hides pairs within one sub-assembly,
    that is with this many equal first path steps; 0: none. optional: patterns may match nothing.
    """

    name: str
    """Reports name it."""
    a: Words = EVERYTHING
    b: Words = EVERYTHING
    clearance: float | None = None
    contact: float | Chord | None = None
    severity: Severity = DEFAULT_SEVERITY
    """The severity of its findings."""
    level: int = 0
    optional: bool = False

    if TYPE_CHECKING:  # it takes more than its fields become

        def __init__(
            self,
            name: str,
            a: WordsLike = "*",
            b: WordsLike = "*",
            clearance: float | None = None,
            contact: float | Chord | None = None,
            severity: Severity = DEFAULT_SEVERITY,
            level: int = 0,
            optional: bool = False,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_text("the name of a rule", self.name)
        who = f"rule {self.name!r}"
        check_flag(f"{who}: optional", self.optional)
        _check_words(self, who)
        if self.clearance is not None:
            check_length(f"{who}: clearance", self.clearance)
        if self.contact is not None and not is_chord(self.contact):
            check_length(f"{who}: contact", self.contact, ', or "chord"')
        check_word(f"{who}: severity", self.severity, SEVERITIES)
        _check_level(f"{who}: level", self.level)


@documented
@dataclass(frozen=True)
class Exclusion:
    """Pairs to hide: some parts against others, parts of one sub-assembly, or fasteners against everything.

    a, b: as in `Rule`; `a` is empty for the other two kinds. same_assembly: hides pairs with this many equal first path
    steps; 0: not used.
    """

    name: str
    """Reports name it, with how many findings it hides."""
    a: Words = ()
    b: Words = EVERYTHING
    same_assembly: int = 0
    fasteners: bool = False
    optional: bool = False
    """Its patterns may match nothing."""

    if TYPE_CHECKING:  # it takes more than its fields become

        def __init__(
            self,
            name: str,
            a: WordsLike = (),
            b: WordsLike = "*",
            same_assembly: int = 0,
            fasteners: bool = False,
            optional: bool = False,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_text("the name of an exclusion", self.name)
        who = f"exclusion {self.name!r}"
        check_flag(f"{who}: optional", self.optional)
        check_flag(f"{who}: fasteners", self.fasteners)
        _check_words(self, who)
        _check_level(f"{who}: same_assembly", self.same_assembly)
        if bool(self.a) + bool(self.same_assembly) + bool(self.fasteners) != 1:
            raise OptionError(f"{who}: give one of a, same_assembly and fasteners, to say what to hide")


@dataclass(frozen=True)
class Rules:
    """Rules in the order in which they are tried, and exclusions.

    others: whether to check pairs that no rule names. where: the name of the rules in messages, such as their file.
    """

    rules: tuple[Rule, ...] = ()
    exclusions: tuple[Exclusion, ...] = ()
    others: bool = True
    where: str = "rules"

    def __post_init__(self) -> None:
        check_text("where", self.where)
        check_flag(f"{self.where}: others", self.others)
        for what, each, kind in (("rules", self.rules, Rule), ("exclusions", self.exclusions, Exclusion)):
            wanted = f"a list of feeler.clashes.{kind.__name__}"
            made = tuple(check_kind(what, one, kind, wanted) for one in check_list(what, each, wanted))
            object.__setattr__(self, what, made)
        names = [each.name for each in self.rules]
        for name in names:
            if not name or name == DEFAULT_RULE or names.count(name) > 1:
                why = "is that of the pairs that no rule names" if name == DEFAULT_RULE else "must be given, and unique"
                raise OptionError(f"{self.where}: the name of a rule {why}: {name!r}")

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Rules:
        """Reads the rules of a TOML file. Raises `MissingFileError`, and `LoadError` if the file is invalid."""
        file = check_path("path", path)
        data = toml_of(file, f"feeler clash --write-rules {file} starts one")
        try:
            return cls(**_parsed(data, str(file)))
        except OptionError as error:
            raise LoadError(str(error)) from None

    @classmethod
    def parse(cls, text: str, where: str = "rules") -> Rules:
        """Reads the text of such a file. Raises `LoadError` if it is invalid."""
        check_text("text", text)
        try:
            return cls(**_parsed(parsed_toml(text, where), where))
        except OptionError as error:
            raise LoadError(str(error)) from None


def renamed(rules: Rules, pattern: Callable[[str], str]) -> Rules:
    """The same rules with other patterns."""
    words = [(each, tuple(map(pattern, each.a)), tuple(map(pattern, each.b))) for each in rules.rules]
    others = [(each, tuple(map(pattern, each.a)), tuple(map(pattern, each.b))) for each in rules.exclusions]
    return replace(
        rules,
        rules=tuple(replace(each, a=a, b=b) for each, a, b in words),
        exclusions=tuple(replace(each, a=a, b=b) for each, a, b in others),
    )


def tolerant(rules: Rules) -> Rules:
    """The same rules, whose patterns may match nothing."""
    return replace(
        rules,
        rules=tuple(replace(each, optional=True) for each in rules.rules),
        exclusions=tuple(replace(each, optional=True) for each in rules.exclusions),
    )


RulesLike: TypeAlias = Rules | Mapping[str, object] | str | os.PathLike[str]
"""Rules, a dict of them, or the path of a file."""


def rules_from(rules: RulesLike | None) -> Rules:
    """Rules from None, a dict, `Rules`, or a file. Raises `OptionError`, and errors as in `Rules.read`."""
    if rules is None:
        return Rules()
    if isinstance(rules, Mapping):
        return Rules(**_parsed(rules))
    if isinstance(rules, Rules):
        return rules
    given: object = rules
    if not isinstance(given, (str, os.PathLike)):
        raise OptionError(f"rules is {shown(rules)}: give Rules, a dict, or the path of a file")
    return Rules.read(check_path("rules", rules))


_TABLES = {"rule": Rule, "exclude": Exclusion}


def is_chord(contact: object) -> bool:
    """Whether a limit is `"chord"`: the chordal errors of both parts."""
    return isinstance(contact, str) and contact == "chord"


def _parsed(data: Mapping[str, Any], where: str = "rules") -> dict[str, Any]:
    """The arguments of the `Rules` of a TOML document as a dict. Raises `OptionError` for mistakes in it."""
    _check_keys(data, ["version", "others", *_TABLES], where)
    check_version(data, where, OptionError)
    others = data.get("others", True)
    if not isinstance(others, bool):
        raise OptionError(f"{where}: others is {others!r}: give true or false")
    made: dict[str, list[Any]] = {}
    for name, kind in _TABLES.items():
        tables = data.get(name, [])
        if not isinstance(tables, list) or not all(isinstance(each, Mapping) for each in tables):
            raise OptionError(f"{where}: {name} is not a list of tables: write [[{name}]] above each")
        made[name] = [_made(kind, each, f"{where}, {name} {number}") for number, each in enumerate(tables, 1)]
    return {"rules": tuple(made["rule"]), "exclusions": tuple(made["exclude"]), "others": others, "where": where}


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


def _check_words(each: Rule | Exclusion, who: str) -> None:
    """Turns a single pattern into a tuple. Raises `OptionError` for values that are not text."""
    for side in ("a", "b"):
        words: object = getattr(each, side)
        if isinstance(words, str):
            words = (words,)
        if not isinstance(words, (list, tuple)) or not all(isinstance(word, str) and word for word in words):
            raise OptionError(f"{who}: {side} is {words!r}: give a pattern of paths, or several")
        object.__setattr__(each, side, tuple(words))


def _check_level(what: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise OptionError(f"{what} is {shown(value)}: give a number of steps down the paths, 1 or more; 0 for none")
