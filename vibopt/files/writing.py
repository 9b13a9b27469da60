"""Files that are written: whole or not at all, never over what was read, nor over what vibopt did not write."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from pathlib import Path

from vibopt.errors import InputError
from vibopt.files.marks import is_ours
from vibopt.files.reading import FileFault, Kind, content_of, shown_name, was_read

_OURS = Kind("a file", 1_000_000_000, "", "")
_STREAMS = (stat.S_ISCHR, stat.S_ISFIFO)
"""What is no file and may be written to: a terminal, a pipe, /dev/null."""


def checked_target(path: str, endings: tuple[str, ...] = (), *, force: bool = False) -> Path:
    """The place of an output file, before any work is done for it and after the inputs have been read.

    Parameters
    ----------
    path
        As the user wrote it.
    endings
        The formats that there are; any where there are none.
    force
        Write over a file that vibopt did not write, or that has been changed since.

    Raises
    ------
    InputError
        Its folder is not there, it is a folder itself, its ending is none of `endings`, it cannot be written, it is
        read in this run, or somebody else wrote it.
    """
    shown = shown_name(path)
    if not path or "\0" in path:
        raise InputError(f'"{shown}" cannot be written: it is no name of a file. Name a file.')
    target = Path(path)
    if endings and target.suffix.lower() not in endings and not is_stream(target):
        listed = ", ".join(endings)
        raise InputError(f"{shown} cannot be written: its ending tells the format, and it is none of {listed}.")
    why = _why_not(target, force=force)
    if why:
        raise InputError(f"{shown} cannot be written: {why}")
    return target


def format_of(target: Path, endings: tuple[str, ...]) -> str:
    """The format that an output file is written in, "svg": its ending, or the first there is for a device or a pipe."""
    ending = target.suffix.lower()
    return (ending if ending in endings else endings[0])[1:]


def write_file(target: Path, content: bytes) -> None:
    """Write a whole file or none: into a neighbour first, which then takes its place.

    Raises
    ------
    InputError
        It cannot be written, or it has been read in this run.
    """
    if was_read(target) and not is_stream(target):
        raise InputError(f"{shown_name(target)} cannot be written: {_READ}")
    replace_file(target, content)


def add_line(target: Path, line: str) -> None:
    """One more line of a text file that this run has written: whole or not at all, also where the run is killed."""
    try:
        handle = os.open(target, os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0))
        try:
            os.write(handle, line.encode())
        finally:
            os.close(handle)
    except OSError as error:
        raise InputError(f"{shown_name(target)} cannot be written: {(error.strerror or str(error)).lower()}.") from None


def is_stream(target: Path) -> bool:
    """Whether a name leads to a device or a pipe, which is written to and never replaced."""
    try:
        mode = target.stat().st_mode
    except (OSError, ValueError, RuntimeError):
        return False
    return any(is_one(mode) for is_one in _STREAMS)


def replace_file(target: Path, content: bytes) -> None:
    """As `write_file`, over an input too."""
    try:
        if is_stream(target):
            _send(target, content)
        else:
            _replace(target.resolve(), content)
    except OSError as error:
        raise InputError(f"{shown_name(target)} cannot be written: {(error.strerror or str(error)).lower()}.") from None


_NOBODY = "it is a pipe, and nobody reads from it. Name a file, or begin to read first."
_READ = "it is read in this run. Name another file."
_FOREIGN = (
    "it is there already, and vibopt did not write it or it has been changed since. Name another file, or add --force."
)


def _why_not(target: Path, *, force: bool) -> str:
    """Why a file cannot be written; "" where it can."""
    try:
        if target.is_dir():
            return "it is a folder. Name a file in it."
        folder = target.resolve().parent
        if not folder.is_dir():
            return f"there is no folder {shown_name(folder)}. Make it first."
        there = target.exists()
    except (OSError, RuntimeError) as error:  # a name that is too long, links in a ring
        return f"{(getattr(error, 'strerror', None) or 'its links lead in a ring').lower()}."
    if there and not target.is_file() and not is_stream(target):
        return "it is no file. Name a file."
    if not (os.access(target, os.W_OK) if there else os.access(folder, os.W_OK)):
        return "permission denied. Name a place that you may write to."
    if not there or is_stream(target):
        return ""
    if was_read(target):
        return _READ
    return "" if force or _is_ours(target) else _FOREIGN


def _is_ours(target: Path) -> bool:
    try:
        return is_ours(content_of(target, _OURS, counts=False))
    except FileFault:
        return False


def _send(target: Path, content: bytes) -> None:
    """To a device or a pipe as it stands; a pipe that nobody reads is an error, no wait."""
    try:
        handle = os.open(target, os.O_WRONLY | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        if error.errno == errno.ENXIO and stat.S_ISFIFO(target.stat().st_mode):
            raise InputError(f"{shown_name(target)} cannot be written: {_NOBODY}") from None
        raise
    os.set_blocking(handle, True)
    with os.fdopen(handle, "wb") as stream:
        stream.write(content)


def _replace(target: Path, content: bytes) -> None:
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()
    handle, neighbour = tempfile.mkstemp(dir=target.parent, prefix=".vibopt-")
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
