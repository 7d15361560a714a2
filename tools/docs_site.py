"""Builds the documentation as a site, in target/site: `make docs` runs this in an environment of its own.

    python tools/docs_site.py [--prepare]

The pages of docs/ are written to be read in the repository. For the site they go to target/docs, with README.md,
CONTRIBUTING.md and others beside them. Links to other files of the repository become addresses of the repository, if
one is known (GITHUB_REPOSITORY, as in CI), and else plain text. `mkdocs.yml` has the order of the pages. The pages of
the reference name what is public; mkdocstrings takes its text from the stubs and docstrings. A dead link ends the
build.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "target" / "docs"
SITE = ROOT / "target" / "site"

# Pages from outside of docs/, and their names on the site.
TAKEN_IN = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "architecture.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "bench/README.md": "benchmarks.md",
}

# The public names, in the order of each page. A name without a module is of `feeler`.
REFERENCE: dict[str, tuple[str, list[str]]] = {
    "scenes": (
        "Scenes and queries",
        [
            *("Scene", "open_scene", "optimal_voxel_size", "nearest_rigid", "Screw", "Slide", "Chain"),
            *(
                "Collision",
                "PairKind",
                "Batch",
                "Distance",
                "DistanceBatch",
                "Clearance",
                "ClearanceBatch",
                "ClearanceAlong",
            ),
            *("Cast", "PathCheck", "Depths", "Depth", "Contacts", "ContactPlane", "ContactTracker", "Penetration"),
            *("Containment", "IgnoredPairs", "Rays", "RayHit", "SectionOutline"),
        ],
    ),
    "files": (
        "Mock-ups, tools and files",
        [
            *("load_mockup", "load_tool", "from_trimesh", "from_pyvista", "from_open3d", "from_urdf"),
            *("Mockup", "Tool", "Part", "Parts", "LoadReport", "Source", "Defect", "Packed", "PackedPiece"),
            *("io.write_glb", "io.write_stl"),
        ],
    ),
    "clash": (
        "Clash checks",
        [
            "clash",
            "clash_variants",
            "load_clashes",
            "Clashes",
            "Clash",
            "Verdict",
            "ClashInterrupted",
            "VariantsInterrupted",
            "VariantsError",
            *("verify", "Verified", "Requirement", "read_requirements"),
            *(
                f"clashes.{name}"
                for name in (
                    *("Changes", "Group", "Facts", "PartMatch", "Rules", "Rule", "Exclusion", "write_rules"),
                    *("write_html", "write_xlsx", "write_csv", "write_bcf", "write_clash_glb", "report"),
                    *("read_bcf", "apply_bcf", "Topic", "Comment", "BcfChanges"),
                )
            ),
        ],
    ),
    "mechanisms": (
        "Mechanisms",
        [
            *("Mechanism", "Joint", "JointKind", "JointCoupling", "Range", "MechanismClearance"),
            *("MechanismClashes", "MechanismContact", "MechanismSeat", "MechanismError", "find_joint", "JointError"),
            *("load_tracks", "Tracks"),
        ],
    ),
    "removal": (
        "Removal and access",
        [
            *("removal", "removal_order", "removals", "insertion", "access", "find_fasteners", "swept"),
            *("Removal", "RemovalLeg", "RemovalBlocker", "Certificate", "Blocker", "RemovalOrder", "RemovalStep"),
            *("Removals", "PartsRemoval", "Access", "Reach", "Fasteners", "Fastener"),
            *("catalogue", "Catalogue", "ToolSpec", "TriedTool"),
            *("opening", "Opening", "OpeningFit", "OpeningLimit", "opening_limits"),
            *("RemovalInterrupted", "RemovalOrderInterrupted", "RemovalsInterrupted", "AccessInterrupted"),
        ],
    ),
    "task": (
        "Maintenance tasks",
        [
            *("task", "Task", "TaskStep", "TaskBlocker", "TaskInterrupted", "Times"),
            *("holds", "Hold", "Holds", "sight", "eyes_in", "Sight", "Seen"),
            *("maintain", "Maintenance", "MaintainRow", "MaintainChange", "MaintenanceInterrupted", "load_maintenance"),
        ],
    ),
    "haptics": (
        "Haptics",
        [
            f"haptics.{name}"
            for name in (
                *("Session", "open_device", "devices", "replay", "Step", "Start", "View", "Seat", "Parted", "Planes"),
                *("Plane", "Coupling", "Granted", "Statistics", "Distribution", "Trace", "Tick"),
            )
        ],
    ),
    "workbench": ("Workbench", ["view", "View", "open_project", "Project", "PartChanges"]),
    "samples": (
        "Samples",
        [
            *("sample", "sample_tool", "sample_truth", "sample_poses", "sample_path"),
            *(
                f"samples.{name}"
                for name in (
                    *("sample_names", "sample_tool_names"),
                    *(
                        "Truth",
                        "Body",
                        "Joint",
                        "Fit",
                        "Fastener",
                        "Fault",
                        "Step",
                        "Leg",
                        "Keeper",
                        "Stay",
                        "FAULTS",
                        "KEEPS",
                    ),
                )
            ),
        ],
    ),
    "compat": (
        "trimesh, MuJoCo",
        [
            *(f"compat.trimesh.{name}" for name in ("CollisionManager", "ContactData", "DistanceData")),
            *("compat.trimesh.scene_to_collision", "compat.mujoco.collision_manager", "compat.mujoco.move"),
        ],
    ),
    "errors": (
        "Errors",
        [
            *("FeelerError", "LoadError", "MissingFileError", "MeshError", "PoseError", "OptionError", "LimitError"),
            *("WriteError", "DeviceError", "SessionError", "ProjectError", "WorkbenchError", "WorkerLost"),
        ],
    ),
}

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.M | re.S)


def repository() -> str | None:
    """The address of the repository's files; None where nobody says."""
    name = os.environ.get("GITHUB_REPOSITORY")
    server = os.environ.get("GITHUB_SERVER_URL", "https://github.com")
    return f"{server}/{name}" if name else None


def place_of(path: str) -> str | None:
    """Where a file of the repository is on the site; None if it is not part of it."""
    if path in TAKEN_IN:
        return TAKEN_IN[path]
    return path.removeprefix("docs/") if path.startswith("docs/") and (ROOT / path).is_file() else None


def rewritten(text: str, source: str, address: str | None) -> str:
    """A page whose links lead to places of the site, or to the repository. `source`: its path in the repository."""
    folder = os.path.dirname(source)
    here = os.path.dirname(place_of(source) or "")

    def link(found: re.Match[str]) -> str:
        picture, label, target = found.groups()
        path, anchor = urldefrag(target)
        if not path or "://" in path or path.startswith("mailto:"):
            return found[0]
        named = os.path.normpath(os.path.join(folder, path)).replace(os.sep, "/")
        if not (ROOT / named).exists():
            sys.exit(f"make docs: {source}: {target} leads nowhere")
        place = place_of(named)
        if place is not None:
            there = os.path.relpath(place, here or ".").replace(os.sep, "/")
            return f"{picture}[{label}]({there}{anchor and '#'}{anchor})"
        kind = "tree" if (ROOT / named).is_dir() else "blob"
        return f"{picture}[{label}]({address}/{kind}/HEAD/{named})" if address else label

    # Code is not touched.
    parts, end = [], 0
    for fence in FENCE.finditer(text):
        parts += [LINK.sub(link, text[end : fence.start()]), fence[0]]
        end = fence.end()
    return "".join([*parts, LINK.sub(link, text[end:])])


def prepare(pages: Path, address: str | None) -> None:
    """Writes all pages and pictures into a new folder."""
    shutil.rmtree(pages, ignore_errors=True)
    shutil.copytree(ROOT / "docs", pages)
    sources = [*TAKEN_IN, *(path.relative_to(ROOT).as_posix() for path in ROOT.glob("docs/**/*.md"))]
    for source in sources:
        text = rewritten((ROOT / source).read_text(encoding="utf-8"), source, address)
        (pages / str(place_of(source))).write_text(text, encoding="utf-8")
    (pages / "reference").mkdir()
    for name, (title, names) in REFERENCE.items():
        entries = "\n".join(f"::: feeler.{entry}\n" for entry in names)
        (pages / "reference" / f"{name}.md").write_text(f"# {title}\n\n{entries}", encoding="utf-8")


def not_in_the_navigation(pages: Path, config: str) -> list[str]:
    """What differs between the pages and the navigation in mkdocs.yml: a page that nobody finds, or one that is not
    there."""
    named = re.findall(r"^ +- [^#\n]*: ([\w/-]+\.md)$", config.partition("\nnav:\n")[2].partition("\n\n")[0], re.M)
    made = {path.relative_to(pages).as_posix() for path in pages.rglob("*.md")}
    twice = {name for name in named if named.count(name) > 1}
    return sorted((made ^ {*named}) | twice)


class Page(HTMLParser):
    """The anchors and links of a page."""

    def __init__(self, text: str) -> None:
        """Reads the page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Collects what leads somewhere, and where something may lead."""
        for name, value in attributes:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def dead_links(site: Path) -> Iterator[str]:
    """The links of a built site that lead nowhere in it."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    for path, page in pages.items():
        if path.name == "404.html":  # its links are those of the root, wherever it is shown
            continue
        for link in page.links:
            target, anchor = urldefrag(link)
            if re.match(r"[a-z]+:|//", target):
                continue
            there = (path.parent / unquote(target)).resolve() if target else path
            there = there / "index.html" if there.is_dir() else there
            if not there.is_file() or (anchor and there in pages and unquote(anchor) not in pages[there].anchors):
                yield f"{path.relative_to(site).as_posix()}: {link}"


def main() -> None:
    """The pages, the site, the check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--prepare", action="store_true", help="only write the pages into target/docs")
    only_prepare = parser.parse_args().prepare
    prepare(PAGES, repository())
    found = not_in_the_navigation(PAGES, (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    if found:
        sys.exit("\n".join(["make docs: not once in the navigation of mkdocs.yml, or no page:", *found]))
    if only_prepare:
        return
    if importlib.util.find_spec("zensical") is None:
        sys.exit("make docs: needs Python 3.11 or later, for zensical: rm -r .venv-docs; make PYTHON=python3.12 docs")
    shutil.rmtree(SITE, ignore_errors=True)
    built = subprocess.run([sys.executable, "-m", "zensical", "build", "--clean", "--strict"], cwd=ROOT, check=False)
    if built.returncode != 0:
        sys.exit(f"make docs: zensical ended with exit status {built.returncode}")
    found = sorted(set(dead_links(SITE)))
    if found:
        sys.exit("\n".join(["make docs: dead links:", *found]))
    print(f"make docs: {sum(1 for _ in SITE.rglob('*.html'))} pages in {SITE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
