"""Figures in a page of documentation, between two markers that stay."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PERFORMANCE = ROOT / "docs" / "performance.md"


def fill(page: Path, what: str, text: str) -> None:
    """Replace what stands between `<!-- <what> -->` and `<!-- end of <what> -->`."""
    before, rest = page.read_text(encoding="utf-8").split(f"<!-- {what} -->")
    after = rest.split(f"<!-- end of {what} -->")[1]
    page.write_text(f"{before}<!-- {what} -->\n{text}\n<!-- end of {what} -->{after}", encoding="utf-8")
