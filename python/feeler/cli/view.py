"""`feeler view`: the workbench in the browser; the page opens while the mock-up is still loading."""

from __future__ import annotations

import contextlib
import json
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

import feeler
from feeler.choices import DEVICE_DRIVERS, DeviceDriver
from feeler.cli.app import BAD_INPUT, command, fail
from feeler.cli.inputs import (
    AsJson,
    Choice,
    MockupUnit,
    Only,
    Threads,
    ToolUnit,
    Up,
    Without,
    check_sources,
    check_unit,
    read_mockup,
    read_tool,
    telling,
)
from feeler.cli.projects import (
    ProjectFile,
    Work,
    completed,
    files_of,
    fitted,
    keep_work,
    named_project,
    open_named,
    unplaced,
)
from feeler.cli.values import Whole, Word
from feeler.errors import FeelerError, OptionError
from feeler.haptics import devices
from feeler.progress import Progress

if TYPE_CHECKING:
    from feeler.project.book import Book
    from feeler.workbench.net.server import Server
    from feeler.workbench.session.benchmark import Opened
    from feeler.workbench.session.openings import Wanted
    from feeler.workbench.session.session import Session

_SAMPLE, _SAMPLE_TOOL = "sample:gearbox", "sample:wrench"
_SHOWN = ("mm", "cm", "m", "in")
_STEP = 0.01  # of progress, between reports
_READ, _INDEXED = 0.6, 0.95  # shares at which the mock-up is read, and indexed
_LOOK_S = 0.1  # Ctrl-C is noticed at this interval, on Windows too


@command(
    name="view",
    examples="""
feeler view
feeler view sample:gearbox
feeler view engine.step --tool wrench.stl
feeler view engine.step --without "*cover*" --record session.jsonl
feeler view sample:turbine:1600000 --tool sample:wrench --no-browser --port 8000
feeler view engine.step --tool wrench.stl --device spacemouse
feeler view sample:engine:10000000 --benchmark
feeler view engine.step --findings clashes.json
feeler view engine.step --mechanism cowl.toml
feeler view engine.step --catalogue tools.toml
feeler view engine.step --project engine.feelproj
feeler view engine.feelproj
feeler view engine-2.step --project engine.feelproj
""",
)
def view(
    mockup: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MOCKUP]...",
            help="Files or folders (several are one mock-up), a saved scene, or "
            "sample:NAME[:TRIANGLES[:SEED[:FAULTS]]] (sample:gearbox).",
        ),
    ] = None,
    *,
    tool: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="A file, or sample:NAME or sample:NAME:fine. Default: sample:wrench if the mock-up is the sample, "
            "else an empty hand, which takes out parts.",
        ),
    ] = None,
    without: Without = None,
    only: Only = None,
    port: Annotated[int, typer.Option(help="Port of the address. 0: any free one."), Whole(0, 65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
    device: Annotated[
        str | None,
        typer.Option(metavar="DEVICE", help="A device for the tool: spacemouse, haply, dhd or openhaptics."),
        Word(DEVICE_DRIVERS),
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="Record all actions, line by line, for feeler replay (.jsonl).")
    ] = None,
    benchmark: Annotated[
        bool,
        typer.Option(
            "--benchmark",
            help="Measure the frame rate on this machine, write feeler-benchmark.json, print it, and exit.",
        ),
    ] = False,
    findings: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Findings of feeler clash --json, to step through.")
    ] = None,
    mechanism: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Joints of the mock-up (.toml), with a slider each: see feeler move."),
    ] = None,
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|built-in", help="Tools that tasks choose from (.toml): see feeler access --write-catalogue."
        ),
    ] = None,
    project: ProjectFile = None,
    read_only: Annotated[
        bool,
        typer.Option("--read-only", help="Open the project without saving, for one that another process has open."),
    ] = False,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    show_unit: Annotated[str, typer.Option(help="Initial unit of lengths in the page."), Word(_SHOWN)] = "mm",
    threads: Threads = None,
    host: Annotated[
        str | None,
        typer.Option(help="Name or address by which other machines reach this one. Default: this machine only."),
    ] = None,
    allow_remote: Annotated[
        bool, typer.Option("--allow-remote", help="Accept other machines at --host; with TLS only.")
    ] = False,
    tls_cert: Annotated[Path | None, typer.Option(help="Certificate of --host, PEM.")] = None,
    tls_key: Annotated[Path | None, typer.Option(help="Its key, PEM.")] = None,
    as_json: AsJson = False,
) -> None:
    """Opens the workbench in the browser: look around in a mock-up, move a tool, take parts out, measure.

    Prints the address, which contains the key for access. The page opens at once and shows loading progress. Ctrl-C
    ends it. With --project, everything is saved as you work; a project alone opens the mock-up that it names.
    Exit status: 0; 2 bad input, a mock-up that could not be read, or changes that could not be saved. A file that is
    missing, or of a format that feeler does not read, ends it at once; other errors of files are shown in the page.

    --benchmark moves camera and tool in the page and reports the frames per second; keep the page visible, because
    browsers do not draw hidden ones.
    """
    from feeler.io import check_target
    from feeler.workbench.document.findings import read_findings
    from feeler.workbench.net.listening import Place
    from feeler.workbench.net.server import Server
    from feeler.workbench.session.benchmark import FILE
    from feeler.workbench.session.session import Session

    is_tool_given = tool is not None
    if tool is not None:
        check_unit("--tool-unit", tool_unit, tool)
    named = named_project(mockup, project, read_only)
    if named is not None and record is not None:
        raise OptionError("--record begins with an empty document, and a project has its own: give one of the two")
    files = files_of(mockup)
    is_sample = not files and (named is None or not named.exists())
    if tool is None and (named is None or is_sample):
        if tool_unit is not None:
            raise OptionError("--tool-unit is for --tool FILE")
        tool = _SAMPLE_TOOL if is_sample else None
    if device is not None and tool is None and named is None:
        raise OptionError("--device moves a tool: give --tool too")
    place = Place(host, port, allow_remote, tls_cert, tls_key)
    place.check()
    if files or tool is not None:
        check_sources(files or [_SAMPLE], tool)
    if record is not None:
        check_target(record, ".jsonl", ".json")
    if benchmark:
        check_target(FILE)
    found = None if findings is None else read_findings(findings)
    joints = None if mechanism is None else _mechanism_of(mechanism)
    tools = None if catalogue is None else _catalogue_of(catalogue)
    # Before anything is loaded, so that a missing device is reported at once.
    held = None if device is None else devices.open_device(cast("DeviceDriver", device))
    opening: _Opening | None = None
    with contextlib.suppress(KeyboardInterrupt), ended_by_signals(), contextlib.ExitStack() as ends:
        work = Work([_SAMPLE] if is_sample else files, tool, tool_unit, unit, up, without or None, only or None)
        opened = None
        if named is not None:
            opened = open_named(named, read_only)
            ends.callback(opened.close)
            work = completed(opened, work, has_tool=True)
        session = Session(unit=show_unit, record=record, project=opened)
        ends.callback(session.close)
        server = Server(session, place=place, has_device=held is not None)
        server.start()
        ends.callback(server.close)
        opening = _Opening(session, work, threads, held, found)
        opening.is_tool_kept = is_tool_given
        opening.mechanism, opening.catalogue = joints, tools
        opening.project = opened
        ends.callback(opening.close)
        opening.begin()
        if record is None and opened is None:  # these are of one mock-up
            session.openings.offer(opening.again)
        say_where(server, place.is_remote, as_json)
        if browser:
            open_browser(server.url)
        if not benchmark:
            wait_for_ctrl_c()
        measured = _Measured(session, opening, as_json)
        while not (measured.is_done() or opening.is_failed):
            time.sleep(_LOOK_S)
    if opening is None:
        return
    if (trouble := opening.unsaved()) is not None:
        fail(f"not saved: {trouble}")
    if opening.is_failed or trouble is not None:
        raise typer.Exit(BAD_INPUT)


def _begin_mechanism(session: Session, name: str, text: str) -> None:
    """Opens a mechanism; one that the project has already stays where its joints stand."""
    kept = session.current.mechanism
    if kept is None or kept.text != text:
        session.command("mechanism_open", {"name": name, "text": text, "is_start": True}, None)


def _mechanism_of(path: Path) -> tuple[str, str]:
    """The name and the text of a file, whose mistakes are told before anything is loaded. Raises `LoadError`."""
    from feeler.io.text import text_of
    from feeler.mechanism import files

    files.read(path)
    return path.name, text_of(path)


def _begin_catalogue(session: Session, name: str, text: str) -> None:
    """Takes a catalogue, unless the project has it already."""
    if session.current.task_catalogue.toml != text:
        session.command("task_catalogue", {"name": name, "toml": text}, None)


def _catalogue_of(source: str) -> tuple[str, str]:
    """The name and the text of a catalogue; both empty for the built-in one. The file is checked before the mock-up is
    loaded. Raises `LoadError`, `OptionError`."""
    from feeler.io.text import text_of
    from feeler.plan.catalogue import BUILT_IN_NAMES
    from feeler.workbench.document.task_commands import MOST_TOML

    if source in BUILT_IN_NAMES:
        return "", ""
    feeler.catalogue(source)
    path = Path(source)
    text = text_of(path)
    if len(text) > MOST_TOML:
        raise OptionError(f"{source} has {len(text):,} characters: the workbench takes {MOST_TOML:,} at most")
    return path.name, text


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """SIGTERM, and SIGHUP of a closed terminal, end the program as Ctrl-C does: saved, and no files left behind."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    names = ("SIGTERM", "SIGHUP")
    before = {each: signal.signal(each, end) for name in names if (each := getattr(signal, name, None)) is not None}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def wait_for_ctrl_c() -> None:
    """Waits until `KeyboardInterrupt`."""
    while True:
        time.sleep(_LOOK_S)


class _Opening:
    """Reads and indexes the mock-up in a thread, and passes it to the session."""

    def __init__(
        self,
        session: Session,
        work: Work,
        threads: int | None = None,
        held: devices.Device | None = None,
        findings: Any = None,
    ) -> None:
        """findings: as read by `read_findings`."""
        self.is_failed = False
        self.is_tool_kept = True
        """Whether the tool is in the hand of mock-ups that are opened later, too; else they have it for `take_tool`."""
        self.opened: Opened | None = None
        """Set when the mock-up is read and indexed."""
        self.project: Book | None = None
        """The project that keeps the names of the opened files and their options, unless it is read-only."""
        self.mechanism: tuple[str, str] | None = None
        """The name and the text of a mechanism of the first mock-up."""
        self.catalogue: tuple[str, str] | None = None
        """The name and the text of a catalogue of tools, for all mock-ups."""
        self._findings = findings
        self._session, self._work, self._threads, self._held = session, work, threads, held
        self._probe: feeler.Tool | None = None
        self._hand: Any = None
        self._is_over = False
        self._told = ("", 0.0)

    def begin(self) -> None:
        """Starts; the page shows the progress."""
        self._session.openings.begin(self._run)

    def again(self, wanted: Wanted) -> bool:
        """Opens another mock-up, or the present one again; returns whether it is open. In the thread of a page."""
        if self._is_over:
            return False
        kept = (self._work, self._findings)
        if wanted.sources is None:
            self._work = replace(self._work, unit=wanted.unit)
        else:
            self._work = Work([*wanted.sources], self._work.tool, self._work.tool_unit, wanted.unit)
        self._findings = None
        self._session.loading("opening", 0.0)
        is_open = self._run()
        if not is_open:
            self._work, self._findings = kept
        return is_open

    def unsaved(self) -> str | None:
        """Why the last changes are not in the project; None if they are, or there is no project."""
        facts = self._session.current.project
        return facts.trouble if facts is not None and facts.state == "failed" else None

    def close(self) -> None:
        """Closes the device."""
        self._is_over = True
        if self._hand is not None:
            self._hand.close()

    def _run(self) -> bool:
        """Whether it is open."""
        try:
            self._open()
        except FeelerError as error:
            self._fail(str(error))
        except MemoryError:
            self._fail("not enough memory: use a smaller mock-up")
        except Exception as error:
            # Report every error: a page that waits for ever says nothing.
            self._fail(f"the mock-up cannot be opened ({type(error).__name__}: {error})")
        else:
            self.is_failed = False
            return True
        return False

    def _fail(self, text: str) -> None:
        fail(text)
        if self._session.current.mockup is not None:
            self._session.not_opened(self._for_pages(text))
            return
        self.is_failed = True
        self._session.failed(self._for_pages(text))

    def _for_pages(self, text: str) -> str:
        """A text with files by their names: the page must not show paths of the disk."""
        project = None if self.project is None else self.project.path
        for source in filter(None, (*self._work.sources, self._work.tool, project)):
            for path in (str(Path(source).resolve()), source):
                if len(Path(path).parts) > 1:  # a bare name stays
                    text = text.replace(path, Path(source).resolve().name)
        return text

    def _telling(self, start: float, end: float) -> Progress:
        """Reports the progress of one stage as a share of the whole."""

        def tell(share: float, stage: str) -> None:
            # The end of a stage is not a stage: another one begins.
            stage, so_far = self._told[0] if share >= 1.0 else stage, start + (end - start) * share
            # Readers report at any rate; the pages get each stage and each hundredth.
            if stage != self._told[0] or abs(so_far - self._told[1]) >= _STEP:
                self._told = (stage, so_far)
                self._session.loading(stage, so_far)

        return tell

    def _open(self) -> None:
        from feeler.cli.outputs import warn
        from feeler.workbench.session.benchmark import Opened

        session, work = self._session, self._work
        begun = time.perf_counter()
        world = read_mockup(work.sources, work.unit, work.up, also=self._telling(0.0, _READ))
        is_first = session.current.mockup is None
        if self.project is not None:
            work = fitted(self.project, work, world)
        if work.tool is not None and self._probe is None:
            self._probe = read_tool(work.tool, work.tool_unit, work.up)
        probe = self._probe
        in_hand = probe if self.is_tool_kept or work.sources[0].startswith("sample:") else None
        doubts = [f"mock-up: {doubt}" for doubt in world.source.doubts]
        doubts += [f"tool: {doubt}" for doubt in probe.source.doubts] if probe is not None else []
        for doubt in doubts:
            warn(doubt)
        read = time.perf_counter()
        with telling("indexing", self._telling(_READ, _INDEXED)) as progress:
            scene = feeler.Scene(world, tool=in_hand, threads=self._threads, progress=progress)
        self.opened = Opened(read - begun, time.perf_counter() - read, time.time())
        scene = Choice(None, work.without, work.only).scene_of(scene)
        self._telling(_INDEXED, 1.0)(0.0, "packing the picture")
        shown = [self._for_pages(doubt) for doubt in doubts]
        tools = [] if probe is None else [probe]
        name = name_of(work.sources)
        session.open(world, scene, in_hand, tools=tools, name=name, doubts=shown, kept=unplaced(work))
        if self.project is not None and not self.project.is_read_only:
            keep_work(self.project, work)
        joints, self.mechanism = self.mechanism, None
        if joints is not None:
            _begin_mechanism(session, *joints)
        if self._findings is not None:
            doubt = session.load_findings(self._findings)
            if doubt:
                warn(f"--findings: {doubt}")
        if self.catalogue is not None:
            _begin_catalogue(session, *self.catalogue)
        if is_first and self._held is not None and probe is not None and not self._is_over:
            from feeler.workbench.engine.device import DeviceHand

            self._hand = DeviceHand(session, self._held)


class _Measured:
    """The measurement of a page, after it has opened and the mock-up is loaded; then written and printed."""

    def __init__(self, session: Session, opening: _Opening, as_json: bool) -> None:
        self._session, self._opening, self._as_json = session, opening, as_json
        self._figures: Future[dict[str, Any]] | None = None

    def is_done(self) -> bool:
        """Whether everything is written. Raises `WorkbenchError`, `WriteError`."""
        opened = self._opening.opened
        if opened is None or self._session.current.mockup is None or not self._session.pages:
            return False
        if self._figures is None:
            self._figures = self._session.benchmark()
        if not self._figures.done():
            return False
        self._write(self._figures.result(), opened)
        return True

    def _write(self, figures: dict[str, Any], opened: Opened) -> None:
        from feeler.atomic import atomic_file
        from feeler.cli import outputs
        from feeler.workbench.session import benchmark

        written = benchmark.report(figures, self._session.document(), opened)
        facts = benchmark.rows(written)
        with atomic_file(benchmark.FILE) as file:
            file.write((json.dumps(written, indent=1) + "\n").encode())
        if self._as_json:
            outputs.print_json(written)
        else:
            outputs.print_facts(outputs.console(), [*facts, ("written", benchmark.FILE)])


def name_of(sources: list[str]) -> str:
    """The name of the mock-up in the page."""
    first = sources[0].split(":")[1] if sources[0].startswith("sample:") else Path(sources[0]).resolve().name
    return first if len(sources) == 1 else f"{first} and {len(sources) - 1} more"


def say_where(server: Server, is_remote: bool, as_json: bool) -> None:
    """Prints the address."""
    from feeler.cli import outputs

    if is_remote:
        outputs.warn(
            f"open to other machines at {server.address}: anyone with the address below can see the mock-up and move "
            "the tool; keep it secret"
        )
    if as_json:
        outputs.print_json({"url": server.url})
    else:
        outputs.say(outputs.console(), f"{server.url}\nCtrl-C ends it")
    sys.stdout.flush()  # in case stdout is a pipe


def open_browser(url: str) -> None:
    """Opens the page, without waiting for the browser."""
    import webbrowser

    # Some browsers keep the call until they are closed.
    threading.Thread(target=webbrowser.open, args=(url,), name="feeler browser", daemon=True).start()
