"""The messages of the workbench: packed as the golden files have them, read strictly, and known to the page alike.

Run as a program, this writes the golden files; the page's own test reads them too.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
import struct
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from feeler.workbench.document import openings, protocol
from feeler.workbench.document.frames import MOST_DEEP, dumps
from feeler.workbench.document.protocol import (
    ProtocolError,
    decode_from_page,
    decode_from_server,
    encode,
    id_of,
    version_of,
)

ROOT = Path(__file__).parent.parent
GOLDEN = ROOT / "testdata" / "workbench"


def turned() -> np.ndarray:
    pose = np.eye(4)
    pose[:3] = [[0, -1, 0, 0.25], [1, 0, 0, -0.5], [0, 0, 1, 1.125]]
    return pose


def state(**changes: Any) -> protocol.State:
    values: dict[str, Any] = {
        "seq": 7,
        "pose_seq": 41,
        "engine_us": 217.5,
        "age_ms": 1.75,
        "rate_hz": 249.5,
        "mode": "stop",
        "is_free": False,
        "blocked": True,
        "force": (0.5, -1.5, 2.25),
        "torque": (0.0625, 0.5, -0.125),
        "depth": 0.0015,
        "depth_kind": "bound",
        "hit_count": 20_003,
        "hit_more": 20_000,
        "contact_more": 0,
        "distance": {
            "value": 0.0125,
            "tool_point": (1.5, 0.5, 0.25),
            "mockup_point": (1.5, 0.5, 0.2375),
            "part": 3,
        },
        "parts": [3, 4315],
        "pose": turned(),
        "wish": np.eye(4),
        "hits": np.array([0, 70_000, 4_000_000_000], np.uint32),
        "tool_hits": np.array([9], np.uint32),
        "planes": np.arange(16, dtype=np.float32).reshape(2, 8) / 8,
        "plane_parts": np.array([3, 4315], np.uint32),
        "clearance": np.arange(7, dtype=np.float32).reshape(1, 7) / 4,
        "clearance_parts": np.array([12], np.uint32),
    }
    return protocol.State(**{**values, **changes})


NOTHING = {
    "hits": np.zeros(0, np.uint32),
    "tool_hits": np.zeros(0, np.uint32),
    "planes": np.zeros((0, 8), np.float32),
    "plane_parts": np.zeros(0, np.uint32),
    "clearance": np.zeros((0, 7), np.float32),
    "clearance_parts": np.zeros(0, np.uint32),
    "distance": None,
    "parts": [],
}
MESSAGES = {
    "pose": protocol.Wish(seq=41, time_ms=1234.5, source="spacemouse", pose=turned()),
    "file_piece": openings.FilePiece(id=7, files=1, file=0, data=np.frombuffer(b"solid", np.uint8)),
    "state": state(),
    "state_free": state(**NOTHING, is_free=True, blocked=False, mode="glide"),
}
DOCUMENT: protocol.DocumentFields = {
    "mockup": {"name": "engine", "hash": "00ff", "triangles": 12, "parts": 2},
    "loading": None,
    "failed": None,
    "tool": {"name": "wrench", "triangles": 4},
    "tools": ["wrench", "hand"],
    "record": None,
    "project": None,
    "absent": [],
    "held_version": 1,
    "unit": "mm",
    "mode": "stop",
    "hidden": [1],
    "ghost": [],
    "explode": 0.5,
    "isolated": False,
    "sections": [{"id": 1, "normal": (0, 0, 1), "offset": 0.25, "is_on": True}],
    "section_box": {"lower": (0, 0, 0), "upper": (0.1, 0.2, 0.3), "is_on": True},
    "pose": turned().ravel().tolist(),
    "gripped": [],
    "moved": {"1": np.eye(4).ravel().tolist()},
    "out": [],
    "sequence": [],
    "replaying": None,
    "guiding": None,
    "measures": [],
    "viewpoints": [],
    "findings": None,
    "cards": [
        {
            **{
                "id": 1,
                "question": "removal",
                "parts": [3],
                "without": [],
                "options": {},
                "title": "Can pump come out?",
            },
            **{"setting": "as loaded", "state": "running", "share": 0.5, "stage": "tree 3", "sentence": ""},
            **{"is_good": None, "is_stale": False, "line": None, "is_earlier": False, "clearances": [0.001, None]},
            "edits": {"off": ["lid"], "times": [("bolt", 9.5)], "before": [("a", "b")], "table": "0a", "catalogue": ""},
        }
    ],
    "clash": {"clearance": 0.002, "contact": None, "rules": ""},
    "requirements": [{"id": 3, "name": "pipes", "a": "*", "b": "*", "gap": 0.01, "verdict": None}],
    "material": "steel",
    "doubts": ["mock-up: 743 m long"],
    "mechanism": None,
    "joint_ranges": [],
    "task_times": {"name": "times.toml", "given": 3},
    "task_catalogue": {"name": "tools.toml", "tools": 12},
    "on_joint": None,
}
OPENS: openings.Opens = {
    "formats": [".stl"],
    "companions": [".bin"],
    "samples": ["gearbox"],
    "most_bytes": 1000,
    "most_files": 2,
}
CAMERA: protocol.Camera = {"position": (0, 0, 1), "target": (0, 0, 0), "up": (0, 1, 0), "fov_rad": 0.8}
TEXT_FROM_SERVER = [
    protocol.Joints([[1.0] + [0.0] * 15], {"hinge": 0.5}),
    protocol.Welcome(1, "s", DOCUMENT, 5, False, True, None, {"feeler": "0.1.0"}, OPENS),
    protocol.Patch(6, {"hidden": [1, 2], "explode": 0.25}, "hide", 3, 0),
    protocol.Impact(7, 3, 0.25, 0.125, (1.0, 2.0, 3.0), None, 4.5),
    protocol.Progress(2, 0.5, "cutting"),
    protocol.Notice(9, "warning", "the device is gone <b>"),
    protocol.ShotWanted(10, 1, 640, 360, {"position": (0, 0, 1), "target": (0, 0, 0), "up": (0, 1, 0), "fov_rad": 0.8}),
    protocol.ShotWanted(
        10,
        1,
        640,
        360,
        {"position": (0, 0, 1), "target": (0, 0, 0), "up": (0, 1, 0), "fov_rad": 0.8, "is_parallel": True},
    ),
    protocol.HeldChanged(11, 2, None),
    protocol.BenchmarkWanted(12, 5),
    protocol.Answer(4, {"distance": 1.5}),
    protocol.Refusal(None, {"what": "is wrong", "where": "here", "do": "that"}),
    protocol.People(
        2,
        [{"id": 2, "name": "Ann <b>", "colour": 0, "is_away": False}],
        {"kind": "page", "person": 2, "is_free": False, "asked": [3]},
    ),
    protocol.People(2, [], {"kind": None, "person": None, "is_free": True, "asked": []}),
    protocol.Seen(3, None, [1, 2], CAMERA),
]
TEXT_FROM_PAGE = [
    protocol.Hello(1, "token", None, 0),
    protocol.Ack(3),
    protocol.Command(1, "hide", {"parts": [1, "*pump*"]}),
    protocol.Ask(2, "ray", {"origin": [0, 0, 0]}),
    protocol.Job(3, "outline", {}),
    protocol.Cancel(3),
    protocol.Ping(5),
    protocol.Shot(4, "view", "aGVsbG8=", False),
    protocol.Benchmarked(5, {"moving_ms": [16.5, 17.0]}),
    openings.SendFiles(6, "open", [{"name": "a <b>.stl", "bytes": 84}]),
    openings.OpenMockup(8, 1, None, "mm"),
    protocol.Named("Ann <b>"),
    protocol.Here((0.5, 0.0, 1.0), [4], CAMERA, True),
    protocol.Turning(9, "give", 3),
]


def same(one: Any, other: Any) -> bool:
    assert type(one) is type(other)
    for field in dataclasses.fields(one):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, theirs)
            assert mine.dtype == theirs.dtype
        else:
            assert mine == theirs, field.name
    return True


@pytest.mark.parametrize("name", MESSAGES)
def test_binary_messages_are_as_the_golden_files(name: str) -> None:
    frame = (GOLDEN / f"{name}.bin").read_bytes()
    assert encode(MESSAGES[name]) == frame
    is_of_page = name in ("pose", "file_piece")
    assert same(decode_from_page(frame) if is_of_page else decode_from_server(frame), MESSAGES[name])


def test_arrays_begin_at_multiples_of_eight() -> None:
    frame = encode(MESSAGES["state"])
    assert isinstance(frame, bytes)
    version, size = struct.unpack_from("<II", frame)
    assert (version, size % 8) == (protocol.VERSION, 0)
    places = json.loads(frame[8 : 8 + size])["arrays"]
    assert all(offset % 8 == 0 for _, _, offset in places.values())


@pytest.mark.parametrize("message", TEXT_FROM_SERVER, ids=lambda each: type(each).__name__)
def test_text_from_the_server_comes_back(message: Any) -> None:
    assert same(decode_from_server(encode(message)), message)


@pytest.mark.parametrize("message", TEXT_FROM_PAGE, ids=lambda each: type(each).__name__)
def test_text_from_the_page_comes_back(message: Any) -> None:
    assert same(decode_from_page(encode(message)), message)


def test_every_message_is_tried_here() -> None:
    binary = [MESSAGES[name] for name in ("pose", "file_piece")]
    assert {type(each) for each in [*TEXT_FROM_PAGE, *binary]} == {*protocol.FROM_PAGE}
    assert {type(each) for each in [*TEXT_FROM_SERVER, MESSAGES["state"]]} == {*protocol.FROM_SERVER}


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ("", "not JSON"),
        ("{", "not JSON"),
        ("[]", "a JSON list: an object is needed"),
        ("null", "a JSON null"),
        ("{}", "kind is None"),
        ('{"kind":7}', "kind is 7"),
        ('{"kind":["hello"]}', "kind is a JSON list"),
        ('{"kind":"welcome"}', "no message of this direction"),
        ('{"kind":"ack"}', "Ack: without seq"),
        ('{"kind":"ack","seq":1,"more":2}', "Ack: has 'more'"),
        ('{"kind":"ack","seq":"1"}', "Ack.seq: is '1': a whole number"),
        ('{"kind":"ack","seq":true}', "Ack.seq: is True: a whole number"),
        ('{"kind":"ack","seq":1.5}', "Ack.seq: is 1.5: a whole number"),
        ('{"kind":"ack","seq":null}', "Ack.seq: is None: a whole number"),
        ('{"kind":"ack","seq":9007199254740993}', r"beyond 2\^53"),
        ('{"kind":"ack","seq":' + "9" * 5000 + "}", "digits|beyond 2\\^53"),
        ('{"kind":"ack","seq":NaN}', "NaN is not a JSON number"),
        ('{"kind":"command","id":1,"name":"a","args":[]}', "Command.args: is a JSON list"),
        ('{"kind":"command","id":1,"name":"a","args":{"b":1e999}}', "not a finite number"),
        ('{"kind":"command","id":1,"name":"a","args":{"b":[-Infinity]}}', "not a JSON number"),
        ('{"kind":"command","id":1,"name":"a","args":{"b":"\\ud800"}}', "surrogate"),
        ('{"kind":"command","id":1,"name":"\\udfff","args":{}}', "surrogate"),
        ('{"kind":"command","id":1,"name":"a","args":{"\\ud800":1}}', "surrogate"),
        ('{"kind":"command","id":1,"name":["a"],"args":{}}', "Command.name"),
        ('{"kind":"command","id":1,"name":"a","args":{"b":' + "[" * 40 + "]" * 40 + "}}", f"{MOST_DEEP} deep"),
        ("[" * 100_000, "not JSON"),
        ('{"kind":' + "[" * 500 + "]" * 500 + "}", "kind is a JSON list"),
        ('{"kind":"pose","seq":1,"time_ms":0,"source":"mouse","arrays":{}}', "Wish: a text frame"),
        (b"", "shorter than its prefix"),
        (struct.pack("<II", 2, 0), "of version 2"),
        (struct.pack("<II", 1, 8), "a header of 8 bytes"),
        (struct.pack("<II", 1, 2**32 - 1), "a header of"),
        (struct.pack("<II", 1, 7) + b"{}     ", "a header of 7"),
        (struct.pack("<II", 1, 8) + b"\xff" * 8, "not UTF-8"),
        (struct.pack("<II", 1, 24) + b'{"kind":"ack","seq":1}  ', "Ack: a binary frame"),
    ],
)
def test_frames_that_are_no_message(frame: str | bytes, words: str) -> None:
    with pytest.raises(ProtocolError, match=words) as raised:
        decode_from_page(frame)
    assert raised.value.what and raised.value.where and raised.value.do
    assert len(str(raised.value)) < 400, "what is wrong may be huge, what is said of it may not"


def pose_frame(body: bytes = turned().tobytes(), **changes: Any) -> bytes:
    header = {"kind": "pose", "seq": 1, "time_ms": 2, "source": "mouse", "arrays": {"pose": ["f8", [4, 4], 0]}}
    header.update(changes)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<II", 1, len(text)) + text + body


def test_a_pose_by_hand_is_read() -> None:
    np.testing.assert_array_equal(decode_from_page(pose_frame()).pose, turned())  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (pose_frame(source="nose"), "Wish.source: is 'nose': one of mouse"),
        (pose_frame(source=["mouse"]), "Wish.source"),
        (pose_frame(arrays=[]), "Wish.arrays: is a JSON list"),
        (pose_frame(arrays={}), "Wish.arrays: without pose"),
        (pose_frame(arrays={"pose": ["f8", [4, 4], 0], "more": ["f8", [4, 4], 0]}), "Wish.arrays: has 'more'"),
        (pose_frame(arrays={"pose": 5}), "Wish.pose: is a JSON number"),
        (pose_frame(arrays={"pose": ["f8", [4, 4]]}), "has 2 items: 3 are needed"),
        (pose_frame(arrays={"pose": ["f4", [4, 4], 0]}), "an array of 'f4': f8 is needed"),
        (pose_frame(arrays={"pose": ["O", [4, 4], 0]}), "an array of 'O'"),
        (pose_frame(arrays={"pose": ["f8", [16], 0]}), "has shape"),
        (pose_frame(arrays={"pose": ["f8", [4, 3], 0]}), "has shape"),
        (pose_frame(arrays={"pose": ["f8", [-4, -4], 0]}), "has shape"),
        (pose_frame(arrays={"pose": ["f8", [4, 4.0], 0]}), "a whole number"),
        (pose_frame(arrays={"pose": ["f8", [4, 4], 8]}), "out of bounds"),
        (pose_frame(arrays={"pose": ["f8", [4, 4], -8]}), "out of bounds"),
        (pose_frame(arrays={"pose": ["f8", [4, 4], 4]}), "out of bounds"),
        (pose_frame(arrays={"pose": ["f8", [4, 4], 2**53]}), "out of bounds"),
        (pose_frame(bytes(256), arrays={"pose": ["f8", [4, 4], 4]}), "out of bounds"),
        (pose_frame(turned().tobytes()[:-1]), "out of bounds"),
        (pose_frame(b""), "out of bounds"),
        (pose_frame(np.full((4, 4), np.nan).tobytes()), "NaN or infinite"),
        (pose_frame(np.full((4, 4), -np.inf).tobytes()), "NaN or infinite"),
        (pose_frame(time_ms="now"), "Wish.time_ms: is 'now': a number"),
    ],
)
def test_poses_that_are_none(frame: bytes, words: str) -> None:
    with pytest.raises(ProtocolError, match=words):
        decode_from_page(frame)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"hits": np.zeros(protocol.MOST_HITS + 1, np.uint32)}, "at most 20000"),
        ({"planes": np.zeros((33, 8)), "plane_parts": np.zeros(33, np.uint32)}, "at most 32"),
        ({"clearance": np.zeros((17, 7)), "clearance_parts": np.zeros(17, np.uint32)}, "at most 16"),
        ({"plane_parts": np.zeros(1, np.uint32)}, "State.plane_parts: has shape"),
        ({"planes": np.zeros((2, 7))}, "State.planes: has shape"),
        ({"depth": float("nan")}, "JSON"),
        ({"force": (0.0, float("inf"), 0.0)}, "JSON"),
        ({"parts": [object()]}, "object has no place in a message"),
    ],
)
def test_a_state_that_cannot_be_sent(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ProtocolError, match=words):
        encode(state(**changes))


def test_too_many_rows_are_refused_when_read_too() -> None:
    frame = encode(state())
    assert isinstance(frame, bytes)
    size = struct.unpack_from("<II", frame)[1]
    header = json.loads(frame[8 : 8 + size])
    header["arrays"]["hits"] = ["u4", [protocol.MOST_HITS + 1], 0]
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    with pytest.raises(ProtocolError, match="at most 20000"):
        decode_from_server(struct.pack("<II", 1, len(text)) + text + bytes(200_000))


def test_a_document_is_checked_to_its_leaves() -> None:
    def refused(words: str, **changes: Any) -> None:
        document = {**DOCUMENT, **changes}
        with pytest.raises(ProtocolError, match=words):
            decode_from_server(encode(protocol.Welcome(1, "s", document, 5, False, True, None, {}, None)))  # type: ignore[arg-type]

    refused(r"Welcome.document.sections\[0\]: without is_on", sections=[{"id": 1, "normal": [], "offset": 0}])
    refused("Welcome.document.unit: is 'ft'", unit="ft")
    refused("Welcome.document.mockup.parts", mockup={"name": "a", "hash": "b", "triangles": 1, "parts": None})
    refused("Welcome.document: has 'more'", more=1)
    with pytest.raises(ProtocolError, match=r"Patch.fields: has 'colour'"):
        decode_from_server(encode(protocol.Patch(1, {"colour": 1}, None, 0, 0)))
    with pytest.raises(ProtocolError, match=r"Patch.fields.unit"):
        decode_from_server(encode(protocol.Patch(1, {"unit": 1}, None, 0, 0)))


def test_numbers_of_numpy_may_be_sent() -> None:
    answer = protocol.Answer(1, {"point": np.arange(3.0), "part": np.int64(4), "near": np.float32(0.5), "is": np.True_})
    assert decode_from_server(encode(answer)).result == {"point": [0, 1, 2], "part": 4, "near": 0.5, "is": True}  # type: ignore[union-attr]
    with pytest.raises(ProtocolError):
        dumps({"a": np.array([np.nan])})


def test_version_and_id_are_found_in_what_is_wrong_otherwise() -> None:
    assert version_of('{"kind":"hello","protocol":9,"new":1}') == 9
    assert [version_of(each) for each in ("", "{}", '{"kind":"ack","protocol":9}', b"a", '{"kind":"hello"}')] == [
        None
    ] * 5
    assert id_of('{"kind":"nothing","id":12}') == 12
    assert [id_of(each) for each in ("", '{"id":"a"}', '{"id":true}', '{"id":1e3}', b"", f'{{"id":{2**60}}}')] == [
        None
    ] * 6


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inside: st.lists(inside, max_size=4) | st.dictionaries(st.text(max_size=10), inside, max_size=4),
    max_leaves=20,
)
kinds = st.sampled_from(
    ["hello", "pose", "ack", "command", "ask", "job", "cancel", "shot", "state", "name", "here", "turn"]
)
fields = st.sampled_from(
    [
        *("seq", "id", "name", "args", "token", "protocol", "session", "last_event", "arrays", "source"),
        *("point", "selection", "camera", "is_moving", "wish", "to"),
    ]
)


@given(st.binary(max_size=200) | st.text(max_size=200))
def test_random_frames_are_errors(frame: str | bytes) -> None:
    with pytest.raises(ProtocolError):
        decode_from_page(frame)


@given(kinds, st.dictionaries(fields, json_values, max_size=8), st.binary(max_size=140))
def test_random_messages_are_messages_or_errors(kind: str, value: dict[str, Any], body: bytes) -> None:
    text = json.dumps({**value, "kind": kind})
    try:
        message = decode_from_page(text)
    except ProtocolError:
        pass
    else:
        assert same(decode_from_page(encode(message)), message)
    with pytest.raises(ProtocolError):
        decode_from_page(pose_frame(body, **value, kind=kind) if value else body)


@given(st.integers(0, len(pose_frame()) - 1), st.binary(min_size=1, max_size=4))
def test_a_frame_with_a_few_bytes_changed_is_a_message_or_an_error(at: int, change: bytes) -> None:
    frame = bytearray(pose_frame())
    frame[at : at + len(change)] = change
    try:
        message = decode_from_page(bytes(frame))
    except ProtocolError:
        return
    assert isinstance(message, protocol.Wish) and np.isfinite(message.pose).all()


FINDINGS: dict[str, Any] = {
    **{"version": "00ff", "count": 2, "counts": {"clash": 2}, "hidden": {"fits": 3}, "status": {"c1": "active"}},
    **{"notes": {"c1": "by design"}, "own_groups": [{"id": 1, "name": "mine"}], "members": {"c1": 1}},
    **{"is_touching_hidden": True, "check": None, "stale": {"3": {"change": "moved"}}},
}


def test_findings_come_without_their_rows() -> None:
    frame = encode(protocol.Patch(1, {"findings": FINDINGS}, None, 0, 0))  # type: ignore[typeddict-item]
    assert decode_from_server(frame).fields["findings"] == FINDINGS  # type: ignore[union-attr]
    wrong = encode(protocol.Patch(1, {"findings": {**FINDINGS, "status": {"c1": "so so"}}}, None, 0, 0))
    with pytest.raises(ProtocolError, match="is 'so so': one of new"):
        decode_from_server(wrong)


@pytest.fixture
def protocol_ts(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(ROOT / "tools")
    return importlib.import_module("protocol_ts")


COMMANDS = """
def hide(document, given):
    \"\"\"Out of sight.

    They still collide.
    \"\"\"

def edit(document, given): ...

WHAT: Shape = {"points": Maybe(list[Vec3]), "parts": Maybe(Selection)}
COMMANDS: dict[str, Command] = {
    "hide": Command(hide, {"parts": list[int | str], "is_on": bool}, moves_hand=True),
    "edit": Command(edit, {"type": Unit | None, **WHAT}),
    "reset": Command(hide, moves_hand=True),
}
STEPS = ("undo",)
"""
ASKING = """
def ray(place, given) -> RayHit | None: ...
def outline(place, given, progress) -> Outline: ...
def _writing(name) -> Work[Written]: ...
ASKS: dict[str, Question[Any]] = {"ray": Question(ray, WHAT)}
JOBS: dict[str, Work[Any]] = {"outline": Work(outline, {"at": Pose}), "csv": _writing("a.csv")}
"""


def test_tables_of_commands_questions_and_jobs_as_the_page_has_them(protocol_ts: ModuleType) -> None:
    text = protocol_ts.document("", "", COMMANDS, ASKING)
    begin, end = text.index("/** The arguments of commands"), text.index("/** What is sent of a command")
    assert (
        text[begin:end]
        == """\
/** The arguments of commands. */
export interface Commands {
  /** Out of sight. */
  readonly hide: { readonly parts: readonly (number | string)[]; readonly is_on: boolean };
  readonly edit: { readonly type: Unit | null; readonly points?: readonly Vec3[]; readonly parts?: Selection };
  /** Out of sight. */
  readonly reset: Record<string, never>;
  readonly undo: Record<string, never>;
}

/** The arguments of questions, and their answers. */
export interface Questions {
  readonly ray: {
    readonly args: { readonly points?: readonly Vec3[]; readonly parts?: Selection };
    readonly answer: RayHit | null;
  };
}

/** The arguments of jobs, and their results. */
export interface Jobs {
  readonly outline: { readonly args: { readonly at: Pose }; readonly answer: Outline };
  readonly csv: { readonly args: Record<string, never>; readonly answer: Written };
}

"""
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('is_on": bool', 'is_on": set[int]', "set.int. has no TypeScript"),
        (" -> Outline", "", "does not name its answer"),
        ("ray, WHAT", "ray, ()", "is no table"),
    ],
)
def test_what_the_page_could_not_be_told(protocol_ts: ModuleType, old: str, new: str, words: str) -> None:
    with pytest.raises(protocol_ts.ShapeError, match=words):
        protocol_ts.document("", "", COMMANDS.replace(old, new), ASKING.replace(old, new))


def test_the_page_knows_the_same_messages() -> None:
    done = subprocess.run([sys.executable, "tools/protocol_ts.py", "--check"], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for name, message in MESSAGES.items():
        frame = encode(message)
        assert isinstance(frame, bytes)
        (GOLDEN / f"{name}.bin").write_bytes(frame)
