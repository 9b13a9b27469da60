"""What leaves the program: text, JSON, files.  Nothing half-written is ever left behind."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from vibopt.errors import InputError, VibOptError

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
    """Standard output takes nothing more (a full disk)."""

    def __init__(self, error: OSError) -> None:
        super().__init__(f"The answer cannot be written to standard output: {error.strerror}.")


def say(text: str) -> None:
    """Write lines to standard output; a reader who has gone away is no error."""
    _write(sys.stdout, text)


def complain(text: str) -> None:
    """Write lines to standard error."""
    _write(sys.stderr, text)


def say_json(data: object) -> None:
    """Write strict JSON to standard output, escaped where the terminal knows no UTF-8."""
    from vibopt.design.jsonable import json_text

    text = json_text(data)
    _write(sys.stdout, text if _fits(text, sys.stdout) else json_text(data, ascii_only=True))


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
        raise UnwritableError(error) from None


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
            raise UnwritableError(error) from None


def _silence(stream: TextIO) -> None:
    """Let what is still to come fall into nothing."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def checked_target(path: str, endings: tuple[str, ...] = ()) -> Path:
    """The place of an output file, before any work is done for it.

    Raises
    ------
    InputError
        Its folder is not there, it is a folder itself, its ending is none of `endings`, or it cannot be written.
    """
    target = Path(path)
    if endings and target.suffix.lower() not in endings:
        listed = ", ".join(endings)
        raise InputError(f"{path} cannot be written: its ending tells the format, and it is none of {listed}.")
    if target.is_dir():
        raise InputError(f"{path} cannot be written: it is a folder. Name a file in it.")
    folder = target.resolve().parent
    if not folder.is_dir():
        raise InputError(f"{path} cannot be written: there is no folder {folder}. Make it first.")
    writable = os.access(target, os.W_OK) if target.exists() else os.access(folder, os.W_OK)
    if not writable:
        raise InputError(f"{path} cannot be written: permission denied. Name a place that you may write to.")
    return target


def write_file(target: Path, content: bytes) -> None:
    """Write a whole file or none: into a neighbour first, which then takes its place."""
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(content)
            return
        _replace(target.resolve(), content)
    except OSError as error:
        raise InputError(f"{target} cannot be written: {(error.strerror or str(error)).lower()}.") from None


def _replace(target: Path, content: bytes) -> None:
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()
    handle, neighbour = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.chmod(neighbour, mode)
        os.replace(neighbour, target)
    except BaseException:
        Path(neighbour).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
