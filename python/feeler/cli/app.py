"""The program: its commands, `--version`, and its exit status.

Exit status: 0 fine, 1 a finding (a collision; too little clearance; a blocked path), 2 bad input, or output that cannot
be written, 130 interrupted. A reader that closes the pipe (head, less) changes nothing: the command ends as it would.
"""

from __future__ import annotations

import atexit
import codecs
import contextlib
import functools
import inspect
import io
import os
import re
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Annotated, Any, NoReturn, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

from feeler.cli.options import check_together, given_of, in_command_line_words, in_text, running
from feeler.errors import FeelerError

Command = TypeVar("Command", bound=Callable[..., Any])

FOUND, BAD_INPUT, INTERRUPTED = 1, 2, 130

_CONTEXT = "context_of_run"
"""The parameter by which typer passes the context to a command that does not ask for it."""


class _PlainWords:
    """A command whose --help has no types of Python: arguments and flags are their own words."""

    def get_params(self, ctx: Any) -> list[Any]:
        params: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for param in params:
            if param.param_type_name == "argument":
                param.display_type_rich = lambda ctx: None
            elif param.metavar is None and param.is_flag:
                param.metavar = ""
        return params


class Commands(_PlainWords, TyperGroup):
    """All commands."""


app = typer.Typer(
    name="feeler",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def command(
    *, examples: str, parent: typer.Typer | None = None, name: str | None = None
) -> Callable[[Command], Command]:
    """Registers a function as a command; its errors become one line and an exit status. examples: shown by --help.

    parent: the group of commands that it belongs to; name: if it differs from the function's.
    """

    def register(function: Command) -> Command:
        signature, options = in_text(function)
        signature, context_name = _with_context(signature)

        @functools.wraps(function)
        def run(*args: Any, **kwargs: Any) -> Any:
            context = kwargs[context_name]
            if context_name == _CONTEXT:
                del kwargs[_CONTEXT]
            try:
                values = kwargs | {name: option.read(kwargs[name]) for name, option in options.items()}
                check_together(options, given_of(context), values)
                with running(options, values):
                    return function(*args, **values)
            except FeelerError as error:
                fail(in_command_line_words(str(error), options, kwargs))
                raise typer.Exit(BAD_INPUT) from None
            except MemoryError:
                fail("not enough memory: use a smaller mock-up, or a larger --voxel-size")
                raise typer.Exit(BAD_INPUT) from None
            except KeyboardInterrupt:
                fail("interrupted")
                raise typer.Exit(INTERRUPTED) from None

        class WithExamples(_PlainWords, TyperCommand):
            def format_help(self, ctx: Any, formatter: Any) -> None:
                super().format_help(ctx, formatter)
                print_examples(examples.strip().splitlines())

        run.__signature__ = signature  # type: ignore[attr-defined]
        run.__annotations__ = {name: each.annotation for name, each in signature.parameters.items()}
        paragraphs = inspect.cleandoc(function.__doc__ or "").split("\n\n")
        (parent or app).command(
            name=name or function.__name__.rstrip("_"),
            cls=WithExamples,
            help="\n\n".join(" ".join(each.split()) for each in paragraphs),
        )(run)
        return function

    return register


def _with_context(signature: inspect.Signature) -> tuple[inspect.Signature, str]:
    """With a parameter for the context, unless the command has one; and its name."""
    for name, parameter in signature.parameters.items():
        if parameter.annotation is typer.Context:
            return signature, name
    context = inspect.Parameter(_CONTEXT, inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    return signature.replace(parameters=[*signature.parameters.values(), context]), _CONTEXT


def print_examples(examples: Iterable[str]) -> None:
    """Prints commands below a help page; long ones are continued as a shell reads them."""
    width = shutil.get_terminal_size().columns - len("   \\")
    print(" Examples\n")
    for example in examples:
        lines = [" "]
        for word in re.findall(r'(?:"[^"]*"|[^\s"])+', example):
            if len(lines[-1]) + 1 + len(word) > width:
                lines.append("     ")
            lines[-1] += f" {word}"
        print(" \\\n".join(lines))
    print()


def fail(message: str) -> None:
    """Writes one line to stderr."""
    print(f"feeler: {_line(message)}", file=sys.stderr)


def _line(message: str) -> str:
    from feeler.words import printable

    return printable(" ".join(message.split()))


def main() -> None:
    """Runs the program and exits."""
    output = _Output.instead_of("stdout")
    _Output.instead_of("stderr")  # a finding is one, whether or not its warnings can be written
    warnings.showwarning = _show  # type: ignore[assignment]
    try:
        os.getcwd()
    except FileNotFoundError:
        fail("the current folder is gone; change to one that is there")
        _exit(BAD_INPUT)
    try:
        app(prog_name="feeler")
    except KeyboardInterrupt:
        fail("interrupted")
        _exit(INTERRUPTED)
    except SystemExit as end:
        # From here on Ctrl-C could only stop the interpreter from ending, and be told as an error.
        with contextlib.suppress(ValueError):  # in another thread
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        if output is not None:
            sys.stdout.flush()
            if output.trouble is not None:
                fail(f"cannot write the output: {output.trouble}; free some space or choose another place")
                _exit(BAD_INPUT)
        _exit(end.code)


def _show(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: Any) -> None:
    """A warning of feeler's in one line, without the line of its code; others as Python shows them."""
    if category.__module__.partition(".")[0] == "feeler":
        print(f"feeler: warning: {_line(str(message))}", file=sys.stderr)
    else:
        sys.stderr.write(warnings.formatwarning(message, category, filename, lineno))


def _exit(status: Any) -> NoReturn:
    """Ends the program. The interpreter is not torn down below threads that nobody waits for, such as one that opens a
    mock-up: it would stop them wherever they take its lock, and the process aborts if that is in C++, as in NumPy's."""
    if isinstance(status, int) and any(thread.daemon for thread in threading.enumerate()):
        # The interpreter would begin so: wait for the other threads, then call the functions registered for the end.
        threading._shutdown()  # type: ignore[attr-defined]
        atexit._run_exitfuncs()
        for stream in filter(None, (sys.stdout, sys.stderr)):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(status)
    sys.exit(status)


_PLAIN = {"\N{MULTIPLICATION SIGN}": "x", "\N{MICRO SIGN}": "u", "\N{DEGREE SIGN}": " deg"}
"""What stands for characters of feeler's own where the output's encoding has none."""


def _plainly(error: UnicodeError, *, escapes: bool) -> tuple[str | bytes, int]:
    """Writes what the encoding has no character for: feeler's own in plain letters, others as escapes.

    `escapes`: bytes of paths that are no text come out as they were.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    first = error.object[error.start]
    if escapes and "\udc80" <= first <= "\udcff":
        return bytes([ord(first) - 0xDC00]), error.start + 1
    return _PLAIN.get(first) or first.encode("ascii", "backslashreplace").decode("ascii"), error.start + 1


codecs.register_error("feeler.strict", functools.partial(_plainly, escapes=False))
codecs.register_error("feeler.surrogateescape", functools.partial(_plainly, escapes=True))


class _Output(io.BufferedWriter):
    """stdout or stderr that never fails: after the first error nothing more is written, and `trouble` has the reason.

    So the command ends as it would have, with its files and its exit status. A closed pipe is no trouble.
    """

    def __init__(self, descriptor: int) -> None:
        # The file below has no method in Python, where Ctrl-C could come between writing and saying how much was
        # written: what the buffer believes to be still there would be written again.
        super().__init__(io.FileIO(descriptor, "w", closefd=False))
        self.trouble: str | None = None
        self._is_open = True

    @classmethod
    def instead_of(cls, name: str) -> _Output | None:
        """Puts one in the place of `sys.stdout` or `sys.stderr`; None for a terminal, which is left alone."""
        stream = getattr(sys, name)
        if stream is None:  # closed before the program began
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
            return None
        try:
            errors = f"feeler.{stream.errors}" if stream.errors in ("strict", "surrogateescape") else stream.errors
            if stream.isatty():
                stream.reconfigure(errors=errors)
                return None
            output = cls(stream.fileno())
            stream.flush()
        except (OSError, ValueError):  # no file at all
            return None
        # What is told on stderr is told at once.
        by_lines = stream.line_buffering or name == "stderr"
        setattr(sys, name, io.TextIOWrapper(output, stream.encoding, errors, line_buffering=by_lines))
        return output

    def write(self, data: Any, /) -> int:
        if self._is_open:
            with self._noting_trouble():
                return super().write(data)
        return memoryview(data).nbytes

    def flush(self) -> None:
        if self._is_open:
            with self._noting_trouble():
                super().flush()

    @contextlib.contextmanager
    def _noting_trouble(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._is_open = False
            if not isinstance(error, BrokenPipeError):
                self.trouble = error.strerror or str(error)


def _show_version(value: bool) -> None:
    if value:
        from importlib.metadata import version

        print(f"feeler {version('feeler')}")
        raise typer.Exit()


@app.callback()
def feeler(
    _version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Exact collision detection between a moving tool and a large digital mock-up, clash checks and removal paths.

    Lengths, times and angles take a unit: 5mm, 0.2in, 2min, 1.05rad. Plain numbers are metres, seconds and degrees.

    Exit status: 0 fine, 1 a finding (a collision, too little clearance, a blocked path; of clash what --fail-on names),
    2 bad input.
    """
