"""Clashes as a person works on them: checked in the page, looked at, sorted, ignored by rules, written to files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import (
    SCHEMES,
    access_troubles,
    differing,
    document,
    keep,
    needs_axe,
    opened,
    picture,
    program,
    settled,
    troubles,
    wait,
)

import feeler
from feeler.io import write_glb

MANY = 100_000


def press(page: Any, *keys: str) -> None:
    """Keys of the picture."""
    page.locator("#picture").focus()
    for key in keys:
        page.keyboard.press(key)


@pytest.fixture(scope="module")
def pegs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plate with three pegs that were drawn 5 mm into it, and a cover around a ball."""
    from browser import sized

    shapes = {
        "stand/plate": sized((0.4, 0.2, 0.02), (0.0, 0.0, 0.0)),
        **{f"stand/peg_{k}": sized((0.02, 0.02, 0.05), (0.06 * k - 0.12, 0.0, 0.03)) for k in (1, 2, 3)},
        "stand/cover": sized((0.08, 0.08, 0.08), (0.14, 0.0, 0.06)),
        "stand/core": sized((0.02, 0.02, 0.082), (0.14, 0.0, 0.06)),
    }
    mockup = feeler.Mockup(
        np.concatenate([points for points, _ in shapes.values()]),
        np.concatenate([faces + 8 * i for i, (_, faces) in enumerate(shapes.values())]),
        np.repeat(np.arange(len(shapes)), 12),
        [path.split("/")[-1] for path in shapes],
        part_paths=list(shapes),
    )
    path = tmp_path_factory.mktemp("pegs") / "pegs.glb"
    write_glb(path, mockup)
    return path


def count_of(page: Any) -> int:
    return int(page.evaluate("() => window.feeler.document.findings?.count ?? -1"))


def test_clashes_are_checked_looked_at_and_ignored_in_the_page(context: Any, pegs: Path, tmp_path: Path) -> None:
    with program(pegs) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.get_by_role("button", name="Check clashes").click()
        page.locator(".finding").first.wait_for()
        assert count_of(page) == 4 and page.locator(".finding").count() == 4
        # Looked at: two colours, the cover see-through.
        press(page, "7")
        settled(page)
        before = picture(page)
        page.locator(".finding", has_text="core").click()
        page.locator(".finding[aria-current=true]", has_text="core").wait_for()
        page.get_by_role("button", name="Leave (Esc)").wait_for()
        settled(page)
        seen = picture(page)
        keep(page.screenshot(), "clash_seen.png")
        blue = (seen[..., 2] > seen[..., 0] + 30).mean()
        orange = (seen[..., 0] > seen[..., 2] + 60).mean()
        assert blue > 0.01 and orange > 0.001, (blue, orange)
        press(page, "Escape")
        settled(page)
        press(page, "7")
        settled(page)
        assert differing(before, picture(page)) < 0.003
        # Noted, and one of a group of ours.
        page.locator(".finding", has_text="peg_2").click()
        note = page.get_by_label("Note of the finding")
        note.fill("ask ada")
        note.blur()
        wait(page, "() => Object.values(window.feeler.document.findings.notes).join() === 'ask ada'")
        page.get_by_label("Group of the finding").select_option("New group…")
        wait(page, "() => window.feeler.document.findings.own_groups.length === 1")
        name = page.get_by_label("Name of the group")
        name.fill("for ada")
        name.press("Enter")
        wait(page, "() => window.feeler.document.findings.own_groups[0].name === 'for ada'")
        # "Ignore like this" says what it hides before it does.
        page.get_by_role("button", name="Ignore like this").click()
        form = page.get_by_role("form", name="Ignore like this")
        form.get_by_text("Hides 3 findings").wait_for()
        form.get_by_label("Parts", exact=True).fill("*nothing*")
        form.get_by_text("no part matches").wait_for()
        form.get_by_label("Parts", exact=True).fill("*peg_?")
        form.get_by_label("against parts").fill("*plate")
        form.get_by_text("Hides 3 findings").wait_for()
        form.get_by_label("Name of the rule").fill("pegs sit in the plate")
        form.get_by_role("button", name="Hide and keep").click()
        page.get_by_text("1 of 1; rules hide 3").wait_for()
        # The rules, and the findings, as files.
        for wanted, ending in (("Rules", "toml"), ("JSON", "json"), ("BCF", "bcf")):
            with page.expect_download() as coming:
                options = page.get_by_label("Export findings").locator("option")
                value = next(each for each in options.all() if wanted in each.inner_text()).get_attribute("value")
                page.get_by_label("Export findings").select_option(value)
            assert coming.value.suggested_filename.endswith(ending)
            coming.value.save_as(tmp_path / f"written.{ending}")
        rules = feeler.clashes.Rules.read(tmp_path / "written.toml")
        assert [each.name for each in rules.exclusions] == ["pegs sit in the plate"]
        assert len(feeler.load_clashes(tmp_path / "written.json")) == 1
        # A step of undo each.
        press(page, "Control+z")
        wait(page, "() => window.feeler.document.findings.count === 4")
        page.locator(".finding", has_text="peg_2").wait_for()
        press(page, "Control+Shift+z")
        wait(page, "() => window.feeler.document.findings.count === 1")
        page.get_by_role("button", name="Check again").click()
        page.get_by_text("1 finding", exact=True).last.wait_for()
        assert document(page)["findings"]["hidden"] == {"pegs sit in the plate": 3}
        assert troubles(page) == []


@needs_axe
def test_axe_finds_nothing_serious_in_findings(context: Any, tmp_path: Path) -> None:
    """With names that are cut, statuses, and findings of an earlier revision."""
    from browser import sized

    names = ("stand/plate", "stand/" + "very_" * 12 + "long_peg_1", "stand/peg (2)", "stand/peg_3")
    for revision, height in (("a", 0.05), ("b", 0.06)):
        shapes = [sized((0.4, 0.2, 0.02), (0.0, 0.0, 0.0))]
        shapes += [sized((0.02, 0.02, height), (0.06 * k, 0.0, 0.03)) for k in range(3)]
        mockup = feeler.Mockup(
            np.concatenate([points for points, _ in shapes]),
            np.concatenate([faces + 8 * i for i, (_, faces) in enumerate(shapes)]),
            np.repeat(np.arange(len(shapes)), 12),
            [name.split("/")[-1] for name in names],
            part_paths=list(names),
        )
        write_glb(tmp_path / f"{revision}.glb", mockup)
    project = tmp_path / "a.feelproj"
    with program(tmp_path / "a.glb", "--project", project) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.get_by_role("button", name="Check clashes").click()
        page.locator(".finding", has_text="peg_3").click()
        page.get_by_label("Status of the finding").select_option("approved")
        page.get_by_label("Group of the finding").select_option("New group…")
        page.get_by_label("Name of the group").wait_for()
        assert access_troubles(page, SCHEMES) == []
        keep(page.screenshot(), "findings_named.png")
        wait(page, "() => window.feeler.document.project.state === 'saved'")
    with program(tmp_path / "b.glb", "--project", project) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        cut = page.locator(".finding", has_text="very_long_peg_1").locator(".name-head")
        assert [each.evaluate("each => each.scrollWidth > each.clientWidth") for each in cut.all()] == [False, True]
        page.locator(".finding", has_text="earlier revision").first.wait_for()
        assert page.locator(".finding").count() == 3
        assert access_troubles(page) == []
        keep(page.screenshot(), "findings_stale.png")


def test_what_clashes_with_a_part(context: Any, pegs: Path) -> None:
    with program(pegs) as started:
        page = opened(context, started)
        page.get_by_label("Search parts").fill("peg_1")
        page.keyboard.press("Enter")
        press(page, "Control+k")
        page.keyboard.type("what clashes")
        page.keyboard.press("Enter")
        page.get_by_text("Only pairs with peg_1 were checked").wait_for()
        page.locator(".finding").first.wait_for()
        assert count_of(page) == 1
        # After a whole check the list is filtered instead.
        page.get_by_role("button", name="Check again").click()
        wait(page, "() => window.feeler.document.findings.count === 4")
        press(page, "Control+k")
        page.keyboard.type("what clashes")
        page.keyboard.press("Enter")
        page.get_by_text("Only with peg_1").wait_for()
        wait(page, "() => document.querySelectorAll('.finding').length === 1")
        page.get_by_role("button", name="All", exact=True).click()
        wait(page, "() => document.querySelectorAll('.finding').length === 4")
        assert troubles(page) == []


def test_a_check_is_cancelled(context: Any) -> None:
    with program("sample:engine:400000") as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.get_by_role("button", name="Check clashes").click()
        page.get_by_role("button", name="Cancel: Clash check").click()
        page.get_by_role("alert").get_by_text("cancelled").wait_for()
        assert document(page)["findings"] is None
        wait(page, "() => document.querySelectorAll('.status .job').length === 0")


def test_a_hundred_thousand_findings_stay_smooth(context: Any, pegs: Path, tmp_path: Path) -> None:
    paths = ["stand/plate", "stand/peg_1", "stand/peg_2", "stand/peg_3", "stand/cover", "stand/core"]
    rows = [
        {
            **{"id": f"finding {k}", "a": paths[k % 6], "b": paths[(k + 1 + k // 6 % 4) % 6], "verdict": "clash"},
            **{"depth": 0.01 / (k + 1), "depth_kind": "bound", "group": f"group {k % 400}", "point_a": [0, 0, 0.01]},
            **{"point_b": [0, 0, 0.01], "translation": [0, 0, 0.01], "rule": "default"},
        }
        for k in range(MANY)
    ]
    file = tmp_path / "many.json"
    file.write_text(json.dumps({"version": 1, "clashes": rows}))
    assert file.stat().st_size > 20_000_000
    with program(pegs) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        with page.expect_file_chooser() as chooser:
            page.locator("#panel").get_by_role("button", name="Open a file").click()
        chooser.value.set_files(file)
        page.locator(".finding").first.wait_for(timeout=120_000)
        assert count_of(page) == MANY
        assert "at most 10 mm deep" in page.locator(".finding").first.inner_text()
        assert page.evaluate("() => JSON.stringify(window.feeler.document).length") < 100_000
        assert page.locator(".finding, .finding-group").count() < 80
        page.get_by_label("Filter findings").focus()
        for letter in "peg_2":
            page.keyboard.type(letter)
            page.evaluate("() => new Promise(done => requestAnimationFrame(() => setTimeout(done)))")
        assert 0 < page.locator(".finding, .finding-group").count() < 80
        page.get_by_label("Filter findings").fill("")
        page.locator(".finding-list").evaluate("list => { list.scrollTop = 0.5 * list.scrollHeight; }")
        settled(page)
        assert page.locator(".finding, .finding-group").count() < 80
        page.get_by_label("Groups of findings").select_option("none")
        page.locator(".finding-list").evaluate("list => { list.scrollTop = 0; }")
        press(page, *"nnnnn")
        page.locator(".finding[aria-current=true]", has_text="2 mm deep").wait_for()
        # All of them at once: a step of undo.
        page.locator(".finding").first.click()
        page.locator(".finding[tabindex='0']").focus()
        page.keyboard.press("End")
        page.keyboard.press("Shift+Enter")
        page.get_by_text("100\u202f000 findings", exact=True).wait_for()
        page.get_by_label("Status of the finding").select_option("reviewed")
        wait(page, "n => Object.keys(window.feeler.document.findings.status).length > n - 100", MANY)
        press(page, "Control+z")
        wait(page, "() => Object.keys(window.feeler.document.findings.status).length === 0")
        assert [line for line in troubles(page) if "WebGL" not in line] == []


def test_findings_say_how_sure_they_are_and_nothing_twice(context: Any, pegs: Path, tmp_path: Path) -> None:
    pair = {"a": "stand/peg_1", "b": "stand/plate", "verdict": "clash", "depth": 0.0733, "rule": "default"}
    kinds = ("measured", "bound", "estimate")
    rows = [{**pair, "id": kind, "depth_kind": kind} for kind in kinds]
    file = tmp_path / "kinds.json"
    file.write_text(json.dumps({"version": 1, "clashes": rows}))
    with program(pegs, "--findings", file) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.locator(".finding").first.wait_for()
        said = [" ".join(each.inner_text().split()) for each in page.locator(".finding").all()]
        assert [each.split(" clash")[0] for each in said] == [
            "peg_1 is 73.3 mm deep in plate",
            "peg_1 is at most 73.3 mm deep in plate",
            "peg_1 is about 73.3 mm deep in plate",
        ]
        assert all(each.count("73.3") == 1 and "default" not in each for each in said)


def test_a_clearance_that_must_hold_is_added_checked_and_looked_at(context: Any, pegs: Path) -> None:
    with program(pegs) as started:
        page = opened(context, started)
        page.keyboard.press("Alt+6")
        page.get_by_text("Clearances that must hold").click()
        page.get_by_role("button", name="Add", exact=True).click()
        card = page.locator(".requirement")
        card.wait_for()
        for label, value in (("Parts: ", "*peg_1"), ("Away from: ", "*peg_2")):
            field = card.get_by_label(label)
            field.fill(value)
            field.press("Enter")
        distance = card.get_by_label("Least distance")
        distance.fill("50")
        distance.press("Enter")
        wait(page, "() => window.feeler.document.requirements[0].gap === 0.05")
        page.get_by_role("button", name="Check", exact=True).click()
        card.get_by_text("violated: 40 mm").wait_for()
        card.get_by_role("button", name="Look").click()
        page.get_by_text("40 mm").last.wait_for()
        settled(page)
        keep(page.screenshot(), "requirement.png")
        press(page, "Escape")
        distance.fill("40")
        distance.press("Enter")
        card.get_by_text("not checked").wait_for()
        assert troubles(page) == []
