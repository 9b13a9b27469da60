"""What leaves the program on its standard streams: text and JSON."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TextIO

from vibopt.errors import VibOptError

if TYPE_CHECKING:
    from vibopt.answer.console import Console

_ASCII = str.maketrans(
    {
        "²": "^2",
        "³": "^3",
        "µ": "u",
        "μ": "u",
        "·": " ",
        "…": "...",
        "–": "-",
        "—": "-",
        "−": "-",
        "≤": "<=",
        "≥": ">=",
        "→": "->",
        "×": "x",
        "°": "deg",
        "ζ": "zeta",
        "ω": "w",
        "█": "#",
    }
)


class UnwritableError(VibOptError):
    """Standard output takes nothing (more): a full disk, or it is closed."""

    def __init__(self, why: str) -> None:
        super().__init__(f"The answer cannot be written to standard output: {why}.")


def keep_streams() -> None:
    """Put nothing where a standard stream is closed, lest the next file that is opened takes its place."""
    for stream in range(3):
        try:
            os.fstat(stream)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the least number that is free


def check_open() -> None:
    """Refuse to work for nobody: UnwritableError where standard output was closed from the beginning."""
    if sys.stdout is None:
        raise UnwritableError("it is closed. Send it to /dev/null to do without it")


def note_kept(words: str) -> None:
    """What is left of the work if the user stops it from here on, and where; "" for nothing."""
    _kept[:] = [words] if words else []


def kept_words() -> str:
    """What is left of the work that was stopped."""
    return " ".join(_kept) or "Nothing was written."


_kept: list[str] = []


def say(text: str) -> None:
    """Write lines to standard output; a reader who has gone away is no error."""
    _write(sys.stdout, text)


def complain(text: str) -> None:
    """Write lines to standard error."""
    _write(sys.stderr, text)


def say_json(data: object) -> None:
    """Write strict JSON to standard output, escaped where the terminal knows no UTF-8."""
    from vibopt.answer.jsonable import json_text

    text = json_text(data)
    _write(sys.stdout, text if _fits(text, sys.stdout) else json_text(data, ascii_only=True))


def fail(code: int, status: str, *messages: str, as_json: bool) -> int:
    """The code with which a command ends that has no answer, and why."""
    if as_json:
        say_json({"status": status, "messages": messages})
    else:
        complain("\n".join(messages))
    return code


def width() -> int:
    """Columns to fill: those of the terminal, 80 in a pipe, never more than 120."""
    if sys.stdout is None or not sys.stdout.isatty():
        return 80
    return min(shutil.get_terminal_size().columns, 120)


def colour() -> bool:
    """Whether standard output is a terminal that wants colour."""
    return (
        sys.stdout is not None
        and sys.stdout.isatty()
        and not os.environ.get("NO_COLOR")
        and os.environ.get("TERM") != "dumb"
    )


def plain_text(text: str) -> str:
    """The same in ASCII."""
    return text.translate(_ASCII).encode("ascii", "replace").decode("ascii")


def flush() -> None:
    """Bring standard output to its end."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        _silence(sys.stdout)
    except OSError as error:
        _silence(sys.stdout)
        raise UnwritableError(str(error.strerror)) from None


def _fits(text: str, stream: TextIO | None) -> bool:
    try:
        text.encode(getattr(stream, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _write(stream: TextIO | None, text: str) -> None:
    if stream is None:
        return
    whole = text if text.endswith("\n") else f"{text}\n"
    try:
        stream.write(whole if _fits(whole, stream) else plain_text(whole))
    except BrokenPipeError:
        _silence(stream)
    except OSError as error:
        _silence(stream)
        if stream is sys.stdout:
            raise UnwritableError(str(error.strerror)) from None


def _silence(stream: TextIO) -> None:
    """Let what is still to come fall into nothing."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def told(
    result: Any, view: Callable[[Any, Console], None], *, as_json: bool, status: str = "ok",
    written: Sequence[str] | None = None, messages: Sequence[str] = (),
) -> None:  # fmt: skip
    """What was found, as JSON or as `view` sets it on a console, the files that were written, and why some were not."""
    if as_json:
        from vibopt.answer.jsonable import plain

        data = result if isinstance(result, Mapping) else plain(result)
        besides = {"messages": list(messages)} if messages else {}
        say_json({"status": status, **({} if written is None else {"written": written}), **data, **besides})
        return
    show(lambda console: view(result, console))
    for one in written or ():
        say(f"Written: {one}")
    for one in messages:
        complain(one)


def show(write: Callable[[Console], None], least: int = 0) -> None:
    """Say what `write` sets on a console as wide as the terminal, at `least` so many columns."""
    from vibopt.answer.text import rendered

    say(rendered(write, width=max(width(), least), colour=colour()))
