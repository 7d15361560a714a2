"""The front page of a package index: README.md with links that lead somewhere from there, and the addresses of the
project in pyproject.toml.

    GITHUB_REPOSITORY=who/what python tools/front_page.py v1.2.3

In the repository the links are relative, so that they lead to the files of the same version. A package index shows the
page alone. The release workflow runs this before it builds; nothing of it is committed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from docs_site import FENCE, LINK, repository

ROOT = Path(__file__).resolve().parent.parent


def with_addresses(text: str, address: str, version: str) -> str:
    """A page of the repository's root whose links are absolute. Code blocks stay as they are."""

    def absolute(found: re.Match[str]) -> str:
        sign, label, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        place = ROOT / target.partition("#")[0]
        if not place.exists():
            sys.exit(f"front_page: {target} leads nowhere")
        kind = "raw" if sign else "tree" if place.is_dir() else "blob"
        return f"{sign}[{label}]({address}/{kind}/{version}/{target})"

    pieces, last = [], 0
    for fence in FENCE.finditer(text):
        pieces += [LINK.sub(absolute, text[last : fence.start()]), fence[0]]
        last = fence.end()
    return "".join([*pieces, LINK.sub(absolute, text[last:])])


def with_urls(project: str, address: str, version: str) -> str:
    """pyproject.toml with the addresses of the project."""
    changes = f"{address}/blob/{version}/CHANGELOG.md"
    urls = f'[project.urls]\nRepository = "{address}"\nIssues = "{address}/issues"\nChangelog = "{changes}"\n\n'
    before, sign, after = project.partition("[project.scripts]\n")
    if not sign or "[project.urls]" in project:
        sys.exit("front_page: pyproject.toml has no [project.scripts], or its addresses already")
    return before + urls + sign + after


def main() -> None:
    """Rewrite both files."""
    address = repository()
    if address is None or len(sys.argv) != 2:
        sys.exit("front_page: give GITHUB_REPOSITORY, and the tag or commit as the argument")
    for name, changed in (("README.md", with_addresses), ("pyproject.toml", with_urls)):
        path = ROOT / name
        path.write_text(changed(path.read_text(encoding="utf-8"), address, sys.argv[1]), encoding="utf-8")


if __name__ == "__main__":
    main()
