"""A clash check of a whole assembly, with rules, tracked from one version to the next; with a page to share.

    python examples/clash.py [MOCKUP_FILE]

Without a file it uses the built-in gearbox with faults. Writes clashes.html, clashes.bcf and clashes.json.
"""

import sys

import feeler
from feeler.clashes import write_bcf, write_html
from feeler.types import Fault

FAULTS: list[Fault] = ["pipe_clash", "too_near", "missing_hole", "duplicate", "inside", "mirrored"]

pipes = {"name": "pipes", "a": "*/pipe", "b": "*bracket*", "clearance": 0.005, "severity": "critical", "optional": True}
fits: list[dict[str, object]] = []
if len(sys.argv) == 2:
    mockup = feeler.load_mockup(sys.argv[1])
else:
    # Threads, presses and the facets of round fits cross as drawn: each pair may be as deep as its fit.
    mockup = feeler.sample("gearbox", triangles=75_000, faults=FAULTS)
    for number, fit in enumerate(feeler.sample_truth("gearbox", triangles=75_000, faults=FAULTS).fits):
        if fit.deepest_m > 0.0:
            name = f"{number}: {fit.kind}"
            fits.append({"name": name, "a": fit.a, "b": fit.b, "contact": fit.deepest_m + 1e-6})


def checked() -> feeler.Clashes:
    """All pairs, measured; then judged by the fits."""
    return feeler.clash(mockup, clearance=0.0, rules={"rule": [pipes]}).with_rules({"rule": [pipes, *fits]})


found = checked()
print(f"{len(found)} findings among {mockup.part_count} parts: {found!r}")
wrong = found[found.verdicts != feeler.Verdict.CONTACT]
for row in wrong:
    measured = f"{row.depth * 1e3:.2f} mm deep" if row.depth else f"{row.gap * 1e3:.2f} mm apart"
    print(f"{row.verdict}, {measured}: {row.path_a} and {row.path_b}")

# Somebody looks at the worst, and says that it is meant to be so. The next check remembers.
found.set_status(found.ids[0], "approved", by="ada", note="known, and being changed")
found.save("clashes.json")
again = checked()
print("since the last check:", again.diff(feeler.load_clashes("clashes.json")).counts())

write_html("clashes.html", again, mockup, pictures=6)
topics = write_bcf("clashes.bcf", again, mockup, most=6)
print(f"clashes.html, and {topics} topics in clashes.bcf")
