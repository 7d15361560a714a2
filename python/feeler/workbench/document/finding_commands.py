"""The commands of findings, for the table in `commands.py`."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Protocol

from feeler.arguments import shown
from feeler.clashes import Rules
from feeler.errors import FeelerError, LoadError, WorkbenchError
from feeler.parts import Parts
from feeler.project.settings import MOST_RULES, ClashSettings
from feeler.workbench.document import findings
from feeler.workbench.document.arguments import Arguments, replaced, without
from feeler.workbench.document.document import Document, Findings, OwnGroup
from feeler.workbench.document.finding_rules import excluded, with_exclusion
from feeler.workbench.document.finding_table import STATUS
from feeler.workbench.document.protocol_findings import FindingStatus
from feeler.workbench.document.values import is_sequence

_MOST_NOTE = 10_000
"""Characters of a text of rules."""


class KnownFindings(Protocol):
    """The facts that these commands need."""

    @property
    def parts(self) -> Parts:
        """Of the mock-up."""

    @property
    def absent(self) -> frozenset[int]:
        """Parts that were left out."""

    @property
    def findings(self) -> Findings | None:
        """Those that a job found, for `findings_take`."""

    @property
    def author(self) -> str:
        """Who gives the command; empty without a name."""


def findings_open(document: Document, given: Arguments, known: KnownFindings) -> Document:
    """Opens the findings of a clash check, as `feeler clash --json` writes them."""
    try:
        found = findings.findings_of(given.raw("findings", Any), known.parts, known.absent)
    except LoadError as error:
        raise given.fail("findings", str(error), "give findings of feeler.clash, or choose another file") from None
    return replace(document, findings=found)


def findings_take(document: Document, given: Arguments, known: KnownFindings) -> Document:
    """Opens the findings that a job found. `saved`: these findings, for a record that is replayed."""
    found = known.findings
    if found is None and given.has("saved"):
        try:
            found = findings.restored(given.raw("saved", Any), known.parts, known.absent)
        except LoadError as error:
            raise given.fail("saved", str(error), "leave it out") from None
    if found is None:
        raise given.fail("key", f"there are no findings {given.text('key')!r}", "run the check, or open the file again")
    return replace(document, findings=found)


def findings_close(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Closes the findings."""
    _of(document, given)
    return replace(document, findings=None)


def finding_status(document: Document, given: Arguments, known: KnownFindings) -> Document:
    """Sets the status of a finding."""
    found, name = _of(document, given), given.text("id")
    if name not in found.table.row_of:
        raise given.fail(
            "id", f"there is no finding {shown(name)}", "give one of Project.findings, or of the page's rows"
        )
    return _with_status(document, found, [name], given.choice("status", STATUS), known.author)


def finding_mark(document: Document, given: Arguments, known: KnownFindings) -> Document:
    """Sets the status, the note or the own group (its id; 0: none) of findings.

    `version`: that of the findings that are open; the command fails for another. `rows`: indices into their rows.
    """
    found = _of(document, given)
    names = _named(found, given)
    if given.has("status"):
        document = _with_status(document, found, names, given.choice("status", STATUS), known.author)
    if given.has("note"):
        text: Any = given.raw("note", str)
        if not isinstance(text, str) or len(text) > _MOST_NOTE:
            raise given.fail("note", "it is not text, or too long", f"send at most {_MOST_NOTE} characters")
        found = _of(document, given)
        notes = findings.changed(found.notes, dict.fromkeys(names, text), found.table.note_of)
        # Who approved stays who approved, whoever writes a note later.
        unsigned = [name for name in names if not found.mark_of(name).by]
        document = replace(document, findings=_by(replace(found, notes=notes), found, unsigned, known.author))
    if given.has("group"):
        found = _of(document, given)
        number = given.whole("group")
        if number and number not in {each.id for each in found.own_groups}:
            raise given.fail("group", f"there is no group {number}", "make it first")
        document = replace(document, findings=_moved(found, names, number))
    return document


def finding_filter(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Hides or shows findings that only touch."""
    found = replace(_of(document, given), is_touching_hidden=given.flag("is_touching_hidden"))
    return replace(document, findings=found)


def finding_group_add(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Makes a group by hand, of rows of the findings of a version."""
    found, number = _of(document, given), document.next_id
    names = _named(found, given)
    made = replace(found, own_groups=(*found.own_groups, OwnGroup(number, given.text("name"))))
    return document.with_id(findings=_moved(made, names, number))


def finding_group_rename(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Renames a group that was made by hand."""
    found = _of(document, given)
    place = given.place_of(found.own_groups)
    group = replace(found.own_groups[place], name=given.text("name"))
    return replace(document, findings=replace(found, own_groups=replaced(found.own_groups, place, group)))


def finding_group_remove(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Removes a group that was made by hand; its findings go back to where they were."""
    found = _of(document, given)
    place = given.place_of(found.own_groups)
    number = found.own_groups[place].id
    members = {name: group for name, group in found.members.items() if group != number}
    groups = without(found.own_groups, place)
    return replace(document, findings=replace(found, own_groups=groups, members=MappingProxyType(members)))


def finding_ignore(document: Document, given: Arguments, known: KnownFindings) -> Document:
    """Adds an exclusion to the rules, for pairs of parts by two patterns, and hides the findings that it names."""
    name, a, b = given.text("name"), given.text("a"), given.text("b")
    try:
        rules = with_exclusion(document.clash.rules, name, a, b)
        found = document.findings and excluded(document.findings, known.parts, name, a, b)
    except FeelerError as error:
        raise given.fail("a", str(error), "change the patterns") from None
    return replace(document, clash=replace(document.clash, rules=rules), findings=found)


def clash_settings(document: Document, given: Arguments, _known: KnownFindings) -> Document:
    """Sets how the next clash check is made.

    `clearance`, `contact`: metres, as of `feeler.clash`; `contact` may be "chord". `rules`: TOML, as of
    `feeler clash --rules`; empty for none.
    """
    clearance = given.number("clearance", 0.0, 1e3) if given.has("clearance") else document.clash.clearance
    contact = document.clash.contact
    if given.has("contact"):
        said: Any = given.raw("contact", float | str)
        contact = None if isinstance(said, str) and said == "chord" else _length(given, "contact")
    rules: Any = given.raw("rules", str) if given.has("rules") else document.clash.rules
    if not isinstance(rules, str) or len(rules) > MOST_RULES:
        raise given.fail("rules", "they are not text, or too long", f"send at most {MOST_RULES} characters")
    if rules != document.clash.rules:
        try:
            Rules.parse(rules)
        except FeelerError as error:
            raise given.fail("rules", str(error), "mend it there; docs/clash.md has the form") from None
    return replace(document, clash=ClashSettings(clearance, contact, rules))


def _length(given: Arguments, name: str) -> float:
    value: Any = given.raw(name, float | str)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 <= value <= 1e3:
        raise given.fail(name, f"{value!r} is no length", 'send metres from 0 to 1000, or "chord"')
    return float(value)


def _of(document: Document, given: Arguments) -> Findings:
    if document.findings is None:
        raise WorkbenchError("there are no findings", given.command, "check clashes, or open findings")
    return document.findings


def _named(found: Findings, given: Arguments) -> list[str]:
    """The ids of the argument "rows"."""
    table = found.table
    if given.text("version") != table.key:
        raise given.fail("version", "the findings are others now", "choose them again")
    rows: Any = given.raw("rows", list[int])
    if not is_sequence(rows) or not all(type(row) is int and 0 <= row < len(table) for row in rows):
        raise given.fail("rows", "they are not rows of the findings", f"send whole numbers below {len(table)}")
    return [table.ids[row] for row in rows]


def _with_status(
    document: Document, found: Findings, names: Collection[str], status: FindingStatus | str, author: str
) -> Document:
    made: Mapping[str, str] = findings.changed(found.status, dict.fromkeys(names, status), found.table.status_of)
    return replace(document, findings=_by(replace(found, status=made), found, names, author))


def _by(made: Findings, before: Findings, names: Iterable[str], author: str) -> Findings:
    """Findings with the author of those that have another status or note than before."""
    differ = (name for name in names if made.mark_of(name) != before.mark_of(name))
    return findings.signed(made, dict.fromkeys(differ, author))


def _moved(found: Findings, names: Iterable[str], group: int) -> Findings:
    members = {**found.members, **dict.fromkeys(names, group)}
    return replace(found, members=MappingProxyType({name: number for name, number in members.items() if number}))
