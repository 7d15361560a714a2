"""A clash check of a whole assembly, with rules, followed from one version to the next; with a page to hand on.

    python examples/clash.py [MOCKUP_FILE]

Without a file it takes the built-in gearbox. Writes clashes.html, clashes.bcf and clashes.json.
"""

import sys

import feeler
from feeler.clashes import write_bcf, write_html

mockup = feeler.load_mockup(sys.argv[1]) if len(sys.argv) == 2 else feeler.sample("differential", triangles=20_000)
rules = {
    "rule": [
        {"name": "gears", "a": "*gear*", "clearance": 0.0005, "contact": 1e-5, "severity": "critical", "optional": True}
    ],
    "exclude": [{"name": "standard parts", "fasteners": True}],
}
found = feeler.clash(mockup, clearance=0.001, rules=rules)
print(f"{len(found)} findings among {mockup.part_count} parts: {found!r}")
for group in found.groups("part")[:5]:
    worst = group.worst
    print(f"{group.name}: {len(group)} findings, the worst {worst.verdict.name.lower()} {worst.depth * 1e3:.2f} mm")

# Somebody looks at the worst, and says that it is meant to be so. The next check remembers.
found.set_status(found.ids[0], "approved", by="ada", note="pressed together")
found.save("clashes.json")
again = feeler.clash(mockup, clearance=0.001, rules=rules)
print("since the last check:", again.diff(feeler.load_clashes("clashes.json")).counts())

write_html("clashes.html", again, mockup, pictures=6)
topics = write_bcf("clashes.bcf", again, mockup, most=6)
print(f"clashes.html, and {topics} topics in clashes.bcf")
