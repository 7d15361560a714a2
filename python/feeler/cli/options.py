"""Reads the options of a command: typer passes them as text, and each `Value` reads its own.

So wrong values get one form of error, whatever the version of typer: the option, its text, and what to give.
"""

from __future__ import annotations

import contextlib
import copy
import inspect
from collections.abc import Callable, Collection, Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import typer
from typer.models import OptionInfo

from feeler.cli.values import FileName, Text, Value
from feeler.errors import OptionError

_SHOWN = 60  # characters of a wrong text


class Needs:
    """An option that does nothing without one of others, given ("--glb") or with a value ("--storage hashed")."""

    def __init__(self, *others: str) -> None:
        self.others = others


class Ends:
    """An option that writes a file and ends the command; `used`: the options that do something beside it."""

    def __init__(self, *used: str) -> None:
        self.used = used


@dataclass(frozen=True)
class Option:
    """An option of a command: its name, its kind, its default as value and as text, and the others it goes with."""

    name: str
    value: Value | None
    default: Any = None
    shown: str | None = None
    needs: tuple[str, ...] = ()
    ends_with: tuple[str, ...] | None = None
    """Of one that ends the command: the options that may be given with it."""

    def read(self, given: Any) -> Any:
        """The value of a text, or of a list of texts. Raises `OptionError` for a wrong one."""
        if self.value is None or given is None:
            return given
        if given == self.shown:
            return self.default
        values = []
        for text in [given] if isinstance(given, str) else given:
            try:
                values.append(self.value.read(text))
            except ValueError as error:
                cut = text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
                raise OptionError(f"{self.name} is {cut!r}: {error}") from None
        return values[0] if isinstance(given, str) else values


def in_text(function: Callable[..., Any]) -> tuple[inspect.Signature, dict[str, Option]]:
    """The signature of a command in which options with a `Value` are text, and its options by parameter."""
    signature = inspect.signature(function, eval_str=True)
    parameters, options = [], {}
    for name, parameter in signature.parameters.items():
        annotation = parameter.annotation
        plain, *extra = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
        info = next((each for each in extra if isinstance(each, OptionInfo)), None)
        value = next((each for each in extra if isinstance(each, Value)), None)
        if info is not None:
            kinds = (plain, *get_args(plain))
            if value is None and bool not in kinds:
                value = FileName() if Path in kinds else Text()
            needs = next((each.others for each in extra if isinstance(each, Needs)), ())
            used = next((each.used for each in extra if isinstance(each, Ends)), None)
            option = replace(_option(name, info, value, parameter.default), needs=needs, ends_with=used)
            options[name] = option
            info = copy.copy(info)
            if info.metavar is None:
                info.metavar = value.metavar if value else ""
            if value is None:
                parameter = parameter.replace(annotation=Annotated[plain, info])
            else:
                is_list = any(get_origin(each) is list for each in kinds)
                text: Any = list[str] if is_list else str
                if parameter.default is None:
                    text = text | None
                elif parameter.default is not parameter.empty:
                    parameter = parameter.replace(default=option.shown)
                parameter = parameter.replace(annotation=Annotated[text, info])
        parameters.append(parameter)
    return signature.replace(parameters=parameters), options


def _option(name: str, info: OptionInfo, value: Value | None, default: Any) -> Option:
    declared = [word for word in (info.default, *(info.param_decls or ())) if isinstance(word, str)]
    words = [word for word in declared if word.startswith("--")]
    option = words[0].partition("/")[0] if words else "--" + name.strip("_").replace("_", "-")
    if value is None or default in (None, inspect.Parameter.empty):
        return Option(option, value)
    return Option(option, value, default, value.shown(default))


def given_of(context: typer.Context) -> set[str]:
    """The parameters that were given on the command line."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return {name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"}


def check_together(options: Mapping[str, Option], given: Collection[str], values: Mapping[str, Any]) -> None:
    """Checks that no option is given in vain. Raises `OptionError` for one without another that it is for, and for one
    that a command would not come to."""
    told = [option.name for name, option in options.items() if name in given]
    chosen = {f"{option.name} {values[name]}" for name, option in options.items()}
    for option in (options[name] for name in options if name in given):
        if option.needs and not any(each in told or each in chosen for each in option.needs):
            too = "it" if len(option.needs) == 1 else "one of these"
            raise OptionError(f"{option.name} is for {' or '.join(option.needs)}: give {too}, too")
        if option.ends_with is not None:
            more = [each for each in told if each not in (option.name, *option.ends_with)]
            if more:
                raise OptionError(f"{option.name} writes a file and ends: leave out {', '.join(more)}")


def in_command_line_words(message: str, options: Mapping[str, Option], given: Mapping[str, Any]) -> str:
    """An error of the library, with the option that it is about.

    An argument at its beginning ("triangles is 5") becomes the option; in front of an error about a file or a name that
    an option gave, the option is added. Of a text that several options gave nobody knows which one it is about: all
    are named, or none if it may be an argument without a name, as the mock-up is.
    """
    for name, option in options.items():
        if message.startswith(f"{name} is "):
            return option.name + message[len(name) :]
    if message.startswith("--"):
        return message
    about = [option.name for name, option in options.items() if _is_about(message, given.get(name))]
    if not about or any(_is_about(message, value) for name, value in given.items() if name not in options):
        return message
    return f"{' or '.join(about)}: {message}"


def _is_about(message: str, value: Any) -> bool:
    """Whether an error is about a file or a name that was given."""
    texts = [str(each) for each in (value if isinstance(value, list) else [value]) if isinstance(each, str | Path)]
    return any(
        message.startswith((f"{text}: ", f"{text} ", f"pose file {text} ")) or repr(text) in message for text in texts
    )


_named: ContextVar[tuple[tuple[str, Path], ...]] = ContextVar("named", default=())


@contextlib.contextmanager
def running(options: Mapping[str, Option], values: Mapping[str, Any]) -> Iterator[None]:
    """A run of a command with these values, by parameter."""
    named = []
    for name, option in options.items():
        for each in values[name] if isinstance(values[name], (list, tuple)) else [values[name]]:
            if isinstance(each, (str, Path)) and str(each):
                named.append((option.name.removeprefix("--"), Path(each)))
    token = _named.set(tuple(named))
    try:
        yield
    finally:
        _named.reset(token)


def named_files() -> tuple[tuple[str, Path], ...]:
    """What options of the running command gave as text, as paths, each with its option, without dashes. Some may be no
    paths, such as patterns of parts."""
    return _named.get()
