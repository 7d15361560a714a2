"""The table of tools: name, description, arguments, fields of the answer, and the function that answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from feeler.agent import pictures, planning, queries, tasks
from feeler.agent.answers import AT_LEAST, AT_MOST, ESTIMATE, EXACT, Field, Fields, finished
from feeler.agent.inputs import Argument, Flag, Many, Names, Number, Pose, Record, Text, Triple, Whole, Word
from feeler.agent.inputs import read_arguments as read
from feeler.agent.job import Cancelled, Job
from feeler.agent.served import Served
from feeler.choices import FASTENER_KINDS, GRIP_AXES, TOUCHINGS
from feeler.clashes import Verdict
from feeler.errors import OptionError
from feeler.scene import CAST_TOLERANCE
from feeler.tasks.planning import MOST_PEOPLE
from feeler.tasks.times import EXAMPLES, LONGEST_S

QUICK_S = 60.0
"""Tools without `seconds` end after this time."""
MOST_S = 600.0
"""The largest `seconds`."""
MOST_POSES = 1_000
MOST_RAYS = 1_000
MOST_EYES = 200
LARGEST_ANSWER_M = 1e4
"""The largest distance up to which a query looks."""
LARGEST_CLEARANCE_M = 0.1
"""The largest distance of a clash check: beyond, every part is near hundreds of others, and findings fill memory."""


@dataclass(frozen=True)
class Tool:
    """A tool that agents call."""

    name: str
    title: str
    description: str
    run: Callable[[Served, dict[str, Any], Job], Any]
    """The answer; with a picture, the answer and the PNG."""
    arguments: Mapping[str, Argument]
    fields: Fields
    rows: str = "rows"
    """The list of the answer that is cut, and that `offset` pages through."""
    is_long: bool = False
    """Whether it may take all cores for long. Such calls run one at a time."""


@dataclass(frozen=True)
class Result:
    """An answer: as an object, as text of less than 4 kB, and a picture."""

    content: dict[str, Any]
    text: str
    png: bytes | None = field(default=None, repr=False)


def call(tool: Tool, served: Served, given: object, job: Job) -> Result:
    """Runs a tool. Raises `FeelerError` for wrong arguments and late answers, `Cancelled`."""
    values = read(given, tool.arguments)
    if "seconds" not in tool.arguments:
        job.limit(QUICK_S)
    try:
        job.check()
        made = tool.run(served, values, job)
        job.check()
    except KeyboardInterrupt:
        job.check()
        seconds = values.get("seconds")
        hint = "ask for less" if seconds is None else "give more seconds"
        raise OptionError(
            f"{tool.name} was stopped after {seconds or QUICK_S:g} s: {hint}, or leave out parts (without)"
        ) from None
    answer, png = made if isinstance(made, tuple) else (made, None)
    content, text = finished(answer, tool.fields, tool.rows, values.get("offset", 0))
    return Result(content, text, png)


_NAMES = "path, name, pattern or number (#12)"
_OFFSET = Argument(Whole(), "skip so many rows: the next page of an answer", 0)
_TOOL = Argument(
    Text("the name of a tool"), "the moving tool, by its name in `info`, or sample:wrench; default: the only one", None
)
_PART = Argument(Names(), f"move these parts of the mock-up instead of a tool: {_NAMES}", None)
_WITHOUT = Argument(Names(), f"leave these parts out of the mock-up: {_NAMES}", None)
_POSE = Argument(
    Pose(),
    'world_from_tool: {"at_m": [x, y, z], "rotate_deg": [rx, ry, rz]}, about the fixed axes x, then y, then z; or a 4 '
    "by 4 matrix, metres. Parts of the mock-up move from their place, which is the default",
    None,
)  # fmt: skip
_MOVING = {"tool": _TOOL, "part": _PART, "without": _WITHOUT}
_TOUCHING = Argument(Word(TOUCHINGS), "free: bodies may touch and slide, and only entering counts", "counts")
_SECONDS = Number("seconds, above 0 up to 600", above=0.0, most=MOST_S)
_ELEMENT = Number("seconds, 0 to 1e6", 0.0, LONGEST_S)
_LENGTH = Number(f"metres, 0 to {LARGEST_ANSWER_M:g}", least=0.0, most=LARGEST_ANSWER_M)

_NEAR = Number(f"metres, 0 to {LARGEST_CLEARANCE_M:g}", least=0.0, most=LARGEST_CLEARANCE_M)

_SOME = {"count": Field("integer", "how many"), "first": Field("names", "the first of them")}
_INSIDE = {
    "inside": Field("object", "closed parts that the moving body is inside of", EXACT, _SOME),
    "contains": Field("object", "parts inside the moving body", EXACT, _SOME),
    "undecided": Field("object", "open parts, for which inside and outside are not defined", None, _SOME),
}
_VERIFIED = f"{EXACT} if true: verified by continuous collision detection; false proves nothing unless held_by is given"
_HIT = {
    "point_m": Field("point", "where, rounded to a nanometre"),
    "normal": Field("point", "unit normal, from the part to the moving body or ray"),
}
_TAKEN_OUT = {
    "parts": Argument(Names(), f"take these parts out, as one: {_NAMES}"),
    "without": Argument(
        Names(), f"leave these out of the mock-up: those already gone, or that it may cross: {_NAMES}", None
    ),
    "tool": Argument(Text("the name of a tool"), "a tool or hand that grips the parts and moves with them", None),
    "tool_pose": Argument(Pose(), "world_from_tool of that tool at the start, as for pose in collide", None),
    "directions": Argument(
        Many(Triple("a direction", is_direction=True), "a list of directions"), "directions to try first", None
    ),
    "clearance_m": Argument(_LENGTH, "distance to keep from all parts that it is not seated on", 0.0),
    "seconds": Argument(_SECONDS, "time limit of the search", 30.0),
    "seed": Argument(Whole(), "seed of the random search", 0),
}
_LEG_FIELDS = {
    "legs": Field("names", "the legs of the path, in words"),
    "path_length_m": Field("number", "travel of their middle; a shorter path may exist", AT_MOST),
}  # fmt: skip
_BLOCKERS = Field(
    "array",
    "parts that stopped attempts, most frequent first",
    ESTIMATE,
    {
        "part": Field("string", "the part"),
        "attempts": Field("integer", "attempts that it stopped"),
        "reach_m": Field("number", "how far the best of them came", AT_LEAST),
    },
)

_ALL = [
    Tool(
        "info",
        "Describe the mock-up",
        "The mock-up that this server was started with (size, unit, number of parts, defects, doubts) and the tools "
        "that can move in it. Ask this first.",
        queries.info,
        {},
        {
            "mockup": Field("names", "the files or the sample that make it"),
            "format": Field("string", "their format"),
            "unit_of_files": Field("string", "the unit of their numbers; all answers are in metres"),
            "up": Field("string", "the axis that points up, if known"),
            "parts": Field("integer", "number of parts", EXACT),
            "parts_left_out": Field("integer", "parts that were left out when the server started", EXACT),
            "triangles": Field("integer", "number of triangles", EXACT),
            "lower_m": Field("point", "lower corner of the bounding box", "exact, rounded to a nanometre"),
            "upper_m": Field("point", "upper corner", "exact, rounded to a nanometre"),
            "defects": Field("object", "numbers of defective triangles, by kind", EXACT),
            "doubts": Field("names", "what puts answers about the mock-up in doubt"),
            "tools": Field(
                "array",
                "tools that were named when the server started",
                None,
                {
                    "tool": Field("string", "its name"),
                    "triangles": Field("integer", "its size", EXACT),
                    "lower_m": Field("point", "its box, in its own frame"),
                    "upper_m": Field("point", "upper corner"),
                },
            ),
            "sample_tools": Field("names", "tools that are always there"),
        },
        "mockup",
    ),
    Tool(
        "parts",
        "List parts",
        "Parts of the mock-up with their boxes, by pattern; or, with level, the assemblies and how many parts each has "
        "(level 1: the top).",
        queries.parts,
        {
            "pattern": Argument(Names(), f"only these: {_NAMES}", None),
            "level": Argument(
                Whole(1, 100), "count parts by the first steps of their path, instead of listing them", None
            ),
            "sort": Argument(Word(("file", "size")), "file: as in the file; size: the largest box first", "file"),
            "offset": _OFFSET,
        },
        {
            "count": Field("integer", "number of parts that match", EXACT),
            "rows": Field(
                "array",
                "parts; or assemblies, with level",
                None,
                {
                    "assembly": Field("string", "the path of an assembly"),
                    "parts": Field("integer", "number of parts in it", EXACT),
                    "part": Field(
                        "string", "the path of a part; a very long one is cut, and begins with the number: #12 ...end"
                    ),
                    "triangles": Field("integer", "number of triangles", EXACT),
                    "lower_m": Field("point", "lower corner of its box", "exact, rounded to a nanometre"),
                    "upper_m": Field("point", "upper corner", "exact, rounded to a nanometre"),
                },
            ),
        },
    ),
    Tool(
        "collide",
        "What does it hit?",
        "Whether a tool (or parts of the mock-up, moved) collides at a pose, with which parts, and how deep.",
        queries.collide,
        {
            **_MOVING,
            "pose": _POSE,
            "touching": _TOUCHING,
            "depth": Argument(Flag(), "measure depths, and a translation that frees the body", True),
            "offset": _OFFSET,
        },
        {
            "colliding": Field("boolean", "whether any triangles share a point", EXACT),
            "free": Field("boolean", "whether it neither collides nor is inside a part nor contains one", EXACT),
            "pairs": Field("integer", "colliding pairs of triangles", EXACT),
            "pair_kinds": Field("object", "their kinds: coplanar, crossing, touching", EXACT),
            **_INSIDE,
            "separation": Field(
                "object",
                "a translation that frees the body",
                None,
                {
                    "translation_m": Field("point", "add it to the position"),
                    "length_m": Field("number", "its length; for its kind see `kind` beside it"),
                    "kind": Field("string", "whether a shorter one may exist"),
                },
            ),
            "depth_note": Field("string", "why no depth is given"),
            "parts": Field("integer", "number of parts in rows", EXACT),
            "rows": Field(
                "array",
                "parts that it hits, contains or is inside of, the deepest first",
                None,
                {
                    "part": Field("string", "the part"),
                    "pairs": Field("integer", "colliding pairs of triangles", EXACT),
                    "depth_m": Field("number", "penetration depth", AT_LEAST),
                    "depth_at_most_m": Field("number", "penetration depth", AT_MOST),
                    "depth_estimate_m": Field("number", "penetration depth, of an open surface", ESTIMATE),
                },
            ),
        },
    ),
    Tool(
        "clearance",
        "How much room is around it?",
        "The distance of a tool (or parts, moved) at a pose to the nearest part, and to each part within a distance, "
        "with the closest points.",
        queries.clearance,
        {
            **_MOVING,
            "pose": _POSE,
            "within_m": Argument(_LENGTH, "list parts up to this distance", 0.005),
            "offset": _OFFSET,
        },
        {
            "distance_m": Field("number", "distance to the nearest part; 0 if and only if they collide", EXACT),
            "nearest": Field("string", "the nearest part"),
            **_INSIDE,
            "within_m": Field("number", "parts are listed up to this distance"),
            "parts": Field("integer", "parts within it", EXACT),
            "rows": Field(
                "array",
                "parts, the nearest first",
                None,
                {
                    "part": Field("string", "the part"),
                    "distance_m": Field("number", "its distance; 0 if and only if it collides", EXACT),
                    "point_on_body_m": Field("point", "the closest point of the moving body, rounded to a nanometre"),
                    "point_on_part_m": Field("point", "the closest point of the part"),
                },
            ),
        },
    ),
    Tool(
        "path",
        "Is a path free?",
        "Moves a tool (or parts) from pose to pose, and finds the first impact of each segment by continuous collision "
        "detection. Between poses the middle of its box moves straight, and it turns the shorter way.",
        queries.path,
        {
            **_MOVING,
            "poses": Argument(Many(Pose(), "a list of poses", 1, MOST_POSES), "the poses, each as for pose in collide"),
            "touching": _TOUCHING,
            "tolerance_m": Argument(
                Number("metres, above 0 up to 1", above=0.0, most=1.0),
                "how much too early an impact may be reported; never too late",
                CAST_TOLERANCE,
            ),
            "offset": _OFFSET,
        },
        {
            "free": Field(
                "boolean",
                "whether no segment has an impact, and it is not inside a part at the first pose",
                f"{EXACT} if true; false may be a pass nearer than tolerance_m",
            ),
            "segments": Field("integer", "number of segments, from 0"),
            "segments_hit": Field("integer", "segments with an impact", AT_MOST),
            "tolerance_m": Field("number", "how much too early an impact may be"),
            **_INSIDE,
            "rows": Field(
                "array",
                "the first impact of each segment that has one",
                None,
                {
                    "segment": Field("integer", "the segment: 0 leads from the first pose to the second"),
                    "fraction": Field("number", "where on the segment, 0 to 1: never late", AT_LEAST),
                    "part": Field("string", "the part that is hit"),
                    **_HIT,
                },
            ),
        },
    ),
    Tool(
        "rays",
        "What is seen along rays?",
        "The first part that each ray hits, with the distance: to look into the mock-up, measure gaps, find surfaces.",
        queries.rays,
        {
            "rays": Argument(
                Many(
                    Record(
                        {
                            "from_m": Triple("three coordinates in metres"),
                            "direction": Triple("a direction", is_direction=True),
                        },
                        ["from_m", "direction"],
                        '{"from_m": [x, y, z], "direction": [dx, dy, dz]}',
                    ),
                    "a list of rays",
                    1,
                    MOST_RAYS,
                ),
                "the rays",
            ),
            "within_m": Argument(_LENGTH, "where rays end", LARGEST_ANSWER_M),
            "without": _WITHOUT,
            "offset": _OFFSET,
        },
        {
            "rays": Field("integer", "number of rays"),
            "hits": Field("integer", "rays that hit a part", EXACT),
            "rows": Field(
                "array",
                "the rays, in their order",
                None,
                {
                    "ray": Field("integer", "which ray, from 0"),
                    "hit": Field("boolean", "whether it hits a part", EXACT),
                    "part": Field("string", "the part"),
                    "distance_m": Field("number", "from its origin", EXACT),
                    **_HIT,
                },
            ),
        },
    ),
    Tool(
        "clash",
        "Check all pairs of parts",
        "All pairs of parts of the mock-up that overlap, touch, contain each other or are too near; the worst first. "
        "Takes seconds to minutes.",
        planning.clash,
        {
            "clearance_m": Argument(_NEAR, "required distance of parts; 0: only collisions", 0.002),
            "contact_m": Argument(_NEAR, "how deep parts may overlap and still count as contact", 0.0),
            "without": _WITHOUT,
            "part": Argument(Names(), f"only findings of these parts: {_NAMES}", None),
            "verdict": Argument(Word([each.value for each in Verdict]), "only findings with this verdict", None),
            "seconds": Argument(_SECONDS, "time limit; then the findings so far are returned", 120.0),
            "offset": _OFFSET,
        },
        {
            "complete": Field("boolean", "false: stopped by the time limit, and findings are missing"),
            "findings": Field("integer", "number of findings", EXACT),
            "verdicts": Field("object", "findings by verdict (of these parts)", EXACT),
            "rows": Field(
                "array",
                "findings, the worst first",
                None,
                {
                    "part_a": Field("string", "a part"),
                    "part_b": Field("string", "another part"),
                    "verdict": Field("string", "clash, contact, clearance, contained or duplicate", EXACT),
                    "depth_m": Field("number", "penetration depth", AT_LEAST),
                    "depth_at_most_m": Field("number", "penetration depth", AT_MOST),
                    "depth_estimate_m": Field("number", "penetration depth, of an open part", ESTIMATE),
                    "gap_m": Field("number", "distance of their surfaces", EXACT),
                    "separation_m": Field("number", "length of a translation that separates them", AT_MOST),
                    "point_a_m": Field("point", "the closest or deepest point on part_a, rounded to a nanometre"),
                },
            ),
        },
        is_long=True,
    ),
    Tool(
        "removal",
        "Can parts be taken out?",
        "A path by which parts come out of the mock-up with all others in place, or the parts that block it. A path "
        "that is found is verified; that none is found proves nothing, unless held_by names parts.",
        planning.removal,
        dict(_TAKEN_OUT),
        {
            "parts": Field("object", "the parts that are taken out", None, _SOME),
            "found": Field("boolean", "whether a path was found", _VERIFIED),
            "method": Field("string", "how it was found"),
            **_LEG_FIELDS,
            "leg_count": Field("integer", "number of legs"),
            "rotation_deg": Field("number", "total rotation along this path", EXACT),
            "clearance_m": Field(
                "number",
                "smallest distance along the path, without seats",
                f"{ESTIMATE}: within 1/20 of it, or 1/64 of the size of the moving parts",
            ),
            "play_m": Field("number", "if it is held: how far any of its points can move", AT_MOST),
            "held_by": Field("names", "parts proven to hold it: no path exists while they stay", EXACT),
            "out_of_time": Field("boolean", "whether `seconds` ran out before the search was complete"),
            "blocked_by": _BLOCKERS,
        },
        "blocked_by",
        is_long=True,
    ),
    Tool(
        "order",
        "Which parts go first?",
        "The parts to take out first so that others come out, step by step, with the path of each step.",
        planning.order,
        {
            **_TAKEN_OUT,
            "keep": Argument(Names(), f"parts that must stay: {_NAMES}", None),
            "seconds": Argument(_SECONDS, "time limit of the search", 60.0),
            "offset": _OFFSET,
        },
        {
            "found": Field(
                "boolean", "whether these steps free the parts", f"{EXACT} if true: verified; false proves nothing"
            ),
            "out_of_time": Field("boolean", "whether `seconds` cut the search: more may find steps, or fewer"),
            "seconds": Field("number", "time taken"),
            "steps": Field("integer", "number of steps: fewer may do", AT_MOST),
            "rows": Field(
                "array",
                "the steps, in order; the wanted parts leave last",
                None,
                {
                    "step": Field("integer", "from 1"),
                    "parts": Field("names", "parts that leave together (the first of them)"),
                    "part_count": Field("integer", "how many"),
                    **_LEG_FIELDS,
                },
            ),
            "held_by": Field("names", "parts proven to hold the wanted ones: no path exists while they stay", EXACT),
            "blocked_by": _BLOCKERS,
        },
        is_long=True,
    ),
    Tool(
        "access",
        "Does a tool reach the fasteners?",
        "Finds bolts, screws, nuts and studs, and tries a tool on each: is there a seat, enough swing, a way in? "
        "The unreachable ones come first. Fasteners are recognised by shape and name: an estimate.",
        planning.access,
        {
            "tool": Argument(
                Text("the name of a tool"),
                "the tool, by its name in `info`, or sample:hand, its z axis out of the joint; or catalogue: of usual "
                "tools the first that fits by drive and size and reaches",
            ),
            "targets": Argument(Names(), f"only fasteners among these: {_NAMES}", None),
            "kind": Argument(Word(FASTENER_KINDS), "only this kind of fastener", None),
            "without": _WITHOUT,
            "hand": Argument(Text("the name of a tool"), "a hand that holds the tool, in the tool's frame", None),
            "grip": Argument(
                Word(GRIP_AXES), "the tool's axis that points out of the joint: y for sample:wrench; default: z", None
            ),
            "lift_m": Argument(
                Number("metres, -1000 to 1000", -1e3, 1e3), "how far the tool sits above the top of the head", 0.0
            ),
            "swing_deg": Argument(
                Number("degrees, above 0 up to 360", above=0.0, most=360.0),
                "required swing; default: 60, or what each tool of the catalogue needs",
                None,
            ),
            "approach_m": Argument(
                Number("metres, above 0 up to 10", above=0.0, most=10.0), "length of the way in", 0.1
            ),
            "seconds": Argument(_SECONDS, "time limit; then the answers so far are returned", 120.0),
            "offset": _OFFSET,
        },
        {
            "complete": Field("boolean", "false: stopped by the time limit, and targets are missing"),
            "targets": Field("integer", "fasteners that were found", ESTIMATE),
            "tried": Field("integer", "fasteners that were tried"),
            "reachable": Field("integer", "reachable ones", AT_LEAST),
            "rows": Field(
                "array",
                "a row for each fastener, unreachable ones first",
                None,
                {
                    "part": Field("string", "the fastener"),
                    "fastener": Field("string", "bolt, screw, nut or stud", ESTIMATE),
                    "reachable": Field("boolean", "whether it is reachable", f"{EXACT} if true; false proves nothing"),
                    "swing_deg": Field("number", "the largest free swing", AT_LEAST),
                    "tool": Field("string", "the tool that reaches it"),
                    "because": Field("string", "the reason"),
                    "looked_m": Field("number", "over which distance a way in was searched"),
                    "drawn_m": Field("number", "how far the tool came out", AT_LEAST),
                    "blockers": Field("names", "parts in the way, most frequent first"),
                },
            ),
        },
        is_long=True,
    ),
    Tool(
        "task",
        "How are parts taken out, with which tools, in how long?",
        "Plans how parts are taken out: which fasteners are undone, with which tool and how many strokes, which parts "
        "go first, and how long it takes. The best plan found, and a time that no plan of this model is below.",
        tasks.task,
        {
            "parts": Argument(Names(), f"take these out, together: {_NAMES}"),
            "without": _WITHOUT,
            "keep": Argument(Names(), f"parts that must stay: {_NAMES}", None),
            "tool": Argument(
                Text("the name of a tool"),
                "catalogue: usual tools by drive and size; none: reach is not checked; or a tool by its name in `info`",
                tasks.CATALOGUE,
            ),
            "times": Argument(
                Record(dict.fromkeys(EXAMPLES, _ELEMENT), (), f"an object of seconds: {', '.join(EXAMPLES)}"),
                "seconds of elements of a step, instead of the built-in examples",
                None,
            ),
            "people": Argument(Whole(1, MOST_PEOPLE), "how many work at once", 1),
            "seconds": Argument(_SECONDS, "time limit; then the best plan so far is returned", 120.0),
            "offset": _OFFSET,
        },
        {
            "found": Field("boolean", "whether they come out", f"{EXACT} if true; false proves nothing"),
            "complete": Field("boolean", "false: the search ended at a limit; there may be a quicker plan"),
            "said": Field("string", "the result in a sentence"),
            "seconds": Field("number", "of the best plan that was found", AT_MOST),
            "spread_seconds": Field("number", "its standard deviation"),
            "bound_seconds": Field("number", "no plan of this model takes less", AT_LEAST),
            "tools": Field("names", "the tools that are used"),
            "steps": Field("integer", "number of steps; without `found`, their ways were not checked"),
            "blocked": Field(
                "array",
                "what nothing frees, if no plan was found",
                None,
                {
                    "part": Field("string", "the part"),
                    "because": Field("string", "why"),
                    "blockers": Field("names", "parts in its way"),
                },
            ),
            "notes": Field("names", "what to know of the plan, such as times that are examples"),
            "rows": Field(
                "array",
                "the steps in order",
                None,
                {
                    "step": Field("integer", "its number, from 1"),
                    "verb": Field("string", "undo, disconnect (it stays on its pipe), or take out"),
                    "parts": Field("names", "the parts that leave"),
                    "part_count": Field("integer", "how many"),
                    "tool": Field("string", "the tool"),
                    "swing_deg": Field("number", "its free swing", AT_LEAST),
                    "strokes": Field("integer", "its strokes", AT_MOST),
                    "person": Field("integer", "who does it, from 1; left out for the first"),
                    "start_seconds": Field("number", "when it begins"),
                    "seconds": Field("number", "how long it takes"),
                    "arithmetic": Field("string", "how its time adds up"),
                },
            ),
        },
        is_long=True,
    ),
    Tool(
        "sight",
        "Are the fasteners seen?",
        "How much of the heads of bolts, screws and nuts is seen: from given eyes, or from the best place on a half "
        "sphere of 0.35 m over each. The least seen come first.",
        tasks.sight,
        {
            "targets": Argument(Names(), f"only fasteners among these: {_NAMES}", None),
            "eyes_m": Argument(
                Many(Triple("a point"), "a list of points", 1, MOST_EYES), "where the eyes may be, metres", None
            ),
            "without": _WITHOUT,
            "seconds": Argument(_SECONDS, "time limit", 120.0),
            "offset": _OFFSET,
        },
        {
            "targets": Field("integer", "fasteners that were found", ESTIMATE),
            "hidden": Field("integer", "of which nothing is seen"),
            "rows": Field(
                "array",
                "a row for each fastener, the least seen first",
                None,
                {
                    "part": Field("string", "the fastener"),
                    "share": Field("number", "of its head, by 64 points: 0 to 1", ESTIMATE),
                    "hidden_by": Field("names", "parts in front of the rest, the worst first"),
                },
            ),
        },
        is_long=True,
    ),
    Tool(
        "picture",
        "Look at it",
        "A picture (PNG): of the mock-up, with parts in red, some parts only, or a section; or, with tool and pose, "
        "cut open at the tool, with a close view of what it hits.",
        pictures.picture,
        {
            "part": Argument(
                Names(), f"draw these red, the others grey: {_NAMES}. With a pose: the parts that move", None
            ),
            "only": Argument(Names(), f"draw nothing but these: {_NAMES}", None),
            "without": _WITHOUT,
            "tool": Argument(Text("the name of a tool"), "draw this tool at the pose", None),
            "pose": _POSE,
            "section": Argument(
                Record(
                    {
                        "point_m": Triple("three coordinates in metres"),
                        "normal": Triple("a direction", is_direction=True),
                    },
                    ["point_m", "normal"],
                    '{"point_m": [x, y, z], "normal": [nx, ny, nz]}',
                ),
                "cut there: the side that the normal points to is not drawn",
                None,
            ),
            "direction": Argument(Triple("a direction", is_direction=True), "the direction of view", None),
            "up": Argument(Triple("a direction", is_direction=True), "up in the picture", None),
            "width_px": Argument(Whole(pictures.SMALLEST_PX, pictures.LARGEST_PX), "width", 800),
            "height_px": Argument(Whole(pictures.SMALLEST_PX, pictures.LARGEST_PX), "height", 600),
        },
        {
            "red": Field("object", "parts that are drawn red", None, _SOME),
            "hit": Field("object", "parts that the tool hits", EXACT, _SOME),
            "width_px": Field("integer", "width of the picture, which may be less than asked for"),
            "height_px": Field("integer", "height of the picture"),
            "png_bytes": Field("integer", "size of the picture, at most 700,000"),
        },
        is_long=True,
    ),
]

TOOLS: dict[str, Tool] = {tool.name: tool for tool in _ALL}

__all__ = ["TOOLS", "Cancelled", "Result", "Tool", "call"]
