"""The workbook of findings, read back from its XML: text that is no formula, numbers that are numbers, pictures."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from clash_scene import house, mockup_of
from commands import error_of
from shapes import box

import feeler
from feeler.clashes import as_xlsx, write_xlsx
from feeler.clashes.columns import COLUMNS
from feeler.errors import OptionError
from feeler.io import xlsx

pytest.importorskip("xlsxwriter")
SPACE = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


def sheet_of(path: Path, number: int = 1) -> ElementTree.Element:
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        return ElementTree.fromstring(archive.read(f"xl/worksheets/sheet{number}.xml"))


def rows_of(path: Path, number: int = 1) -> list[dict[str, Any]]:
    """The cells of each row by their columns: text as str, numbers as float."""
    found = []
    for row in sheet_of(path, number).iter(f"{SPACE}row"):
        cells: dict[str, Any] = {}
        for cell in row:
            column = cell.attrib["r"].rstrip("0123456789")
            if cell.attrib.get("t") == "inlineStr":
                cells[column] = "".join(each.text or "" for each in cell.iter(f"{SPACE}t"))
            elif (value := cell.find(f"{SPACE}v")) is not None:
                cells[column] = float(value.text or "nan")
        found.append(cells)
    return found


def pictures_in(path: Path) -> int:
    with zipfile.ZipFile(path) as archive:
        drawn = [archive.read(name) for name in archive.namelist() if name.startswith("xl/drawings/drawing")]
    return sum(each.count(b"<xdr:pic>") for each in drawn)


def table_of(path: Path) -> list[dict[str, Any]]:
    """The findings by their headings."""
    head, *rows = rows_of(path)
    return [{title: row.get(column) for column, title in head.items()} for row in rows]


def test_numbers_are_numbers_with_their_units(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    write_xlsx(tmp_path / "a.xlsx", found)
    rows = table_of(tmp_path / "a.xlsx")
    assert list(rows[0]) == ["picture", *(column.title for column in COLUMNS)]
    # Excel has 15 digits.
    assert [row["depth, m"] for row in rows] == pytest.approx(found.depths.tolist(), rel=1e-15)
    assert [row["point a x, m"] for row in rows] == pytest.approx(found.points_a[:, 0].tolist(), rel=1e-15)
    assert [(row["path a"], row["path b"]) for row in rows] == [(each.path_a, each.path_b) for each in found]
    assert {row["volume, m³"] for row in rows} == {None}, "what was not measured is empty"


@pytest.mark.parametrize("name", ["=1+1", "@SUM(A1)", "{=1}", "http://x", "12", "-5", "a\x01b", "\ud800x"])
def test_text_is_text(tmp_path: Path, name: str) -> None:
    mockup = mockup_of({name: box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (2, 1, 1))})
    write_xlsx(tmp_path / "a.xlsx", feeler.clash(mockup))
    (row,) = table_of(tmp_path / "a.xlsx")
    assert isinstance(row["path a"], str) and row["path a"][0] == name[0].replace("\ud800", "\ufffd")
    sheet = sheet_of(tmp_path / "a.xlsx")
    assert not [*sheet.iter(f"{SPACE}f")] and not [*sheet.iter(f"{SPACE}hyperlink")]


def test_a_long_name_is_cut_where_excel_ends(tmp_path: Path) -> None:
    mockup = mockup_of({"x" * 40_000: box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (2, 1, 1))})
    write_xlsx(tmp_path / "a.xlsx", feeler.clash(mockup))
    assert table_of(tmp_path / "a.xlsx")[0]["path a"] == "x" * 32_767


def test_the_heading_stays_and_filters(tmp_path: Path, mockup: feeler.Mockup) -> None:
    write_xlsx(tmp_path / "a.xlsx", feeler.clash(mockup))
    sheet = sheet_of(tmp_path / "a.xlsx")
    (pane,) = sheet.iter(f"{SPACE}pane")
    (chosen,) = sheet.iter(f"{SPACE}autoFilter")
    assert pane.attrib["state"] == "frozen" and pane.attrib["ySplit"] == "1"
    assert chosen.attrib["ref"].startswith("A1:") and chosen.attrib["ref"].endswith("10")


def test_each_row_has_its_picture(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    told: list[float] = []
    write_xlsx(tmp_path / "a.xlsx", found, mockup, progress=lambda share, _stage: told.append(share))
    assert pictures_in(tmp_path / "a.xlsx") == len(found) == len(told) and told == sorted(told)
    write_xlsx(tmp_path / "b.xlsx", found)
    assert pictures_in(tmp_path / "b.xlsx") == 0


def test_the_worst_have_pictures_and_the_summary_says_so(tmp_path: Path, mockup: feeler.Mockup) -> None:
    write_xlsx(tmp_path / "a.xlsx", feeler.clash(mockup), mockup, pictures=2)
    assert pictures_in(tmp_path / "a.xlsx") == 2
    assert {"A": "note", "B": "The 2 worst findings have pictures"} in rows_of(tmp_path / "a.xlsx", 2)


def test_rows_have_a_stated_cap(tmp_path: Path, mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(as_xlsx, "MOST_ROWS", 4)
    found = feeler.clash(mockup)
    write_xlsx(tmp_path / "a.xlsx", found)
    assert [row["id"] for row in table_of(tmp_path / "a.xlsx")] == list(found.ids[:4])
    assert {"A": "note", "B": "The 4 worst findings are in this workbook"} in rows_of(tmp_path / "a.xlsx", 2)


def test_the_summary_has_what_rules_hide(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, rules={"exclude": [{"name": "copies", "a": "*copy*"}]})
    write_xlsx(tmp_path / "a.xlsx", found)
    assert {"A": "hidden", "B": "4 by copies"} in rows_of(tmp_path / "a.xlsx", 2)


def test_the_same_findings_are_the_same_file(tmp_path: Path, mockup: feeler.Mockup) -> None:
    for name in ("a.xlsx", "b.xlsx"):
        write_xlsx(tmp_path / name, feeler.clash(mockup), mockup)
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()


def test_nothing_found_is_a_workbook_too(tmp_path: Path, mockup: feeler.Mockup) -> None:
    write_xlsx(tmp_path / "a.xlsx", feeler.clash(mockup)[:0], mockup)
    assert table_of(tmp_path / "a.xlsx") == []


def test_the_extra_is_asked_for_before_the_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xlsxwriter", None)
    with pytest.raises(OptionError, match=r'pip install "feeler\[xlsx\]", or write CSV'):
        xlsx.xlsx_library()
    assert "needs XlsxWriter" in error_of("clash", "none.glb", "--xlsx", tmp_path / "a.xlsx")
