"""Files that are read: regular files of a stated size, and nothing that a name may lead to besides."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from vibopt.errors import VibOptError, shortened
from vibopt.records import dataclass

_SORTS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe, and only files are read"),
    (stat.S_ISSOCK, "a socket, and only files are read"),
    (stat.S_ISCHR, "a device, and only files are read"),
    (stat.S_ISBLK, "a device, and only files are read"),
)
_LONGEST = 200
"""Most letters of a file name in a message."""
_BLOCK = 1 << 16
"""Bytes asked for at once, or the whole file: room for the largest of its kind takes longer to make than to fill."""
_read: dict[tuple[int, int], str] = {}
"""Device and number of every file that this run has looked into, and its name: numbers are given to others later."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What sort of file is read: its noun for messages, most bytes, and the way out where it is missing or no file."""

    noun: str
    largest: int
    missing: str
    way: str


class FileFault(VibOptError):  # noqa: N818 - the file is at fault
    """A file that cannot be read; `text` continues its name, as in "is a folder. Name a problem file (.toml)."

    missing, folder
        Whether there is nothing of that name, or a folder: then its whole path helps.
    """

    exit_code = 2

    def __init__(self, text: str, *, missing: bool = False, folder: bool = False) -> None:
        self.text, self.missing, self.folder = text, missing, folder
        super().__init__(text)


def file_of(given: str) -> Path:
    """The file that a text in a problem file names, as seen from the folder that comes with the text.

    Raises
    ------
    FileFault
        It is blank.
    """
    if not given.strip():
        raise FileFault("is no file name. Write the name of a file.")
    return Path(getattr(given, "folder", "")) / given


@dataclass(frozen=True, slots=True)
class Stamp:
    """What tells one content of a file from another, without looking into it."""

    changed: int
    size: int


def stamp_of(file: str | Path, kind: Kind, *, counts: bool = True) -> Stamp:
    """The state of a file, which from here on counts as read in this run unless said otherwise.

    Raises
    ------
    FileFault
        It is not there, no regular file, or too large.
    """
    file = str(file)
    if "\0" in file:
        raise FileFault("has a sign of number 0 in its name, which no file name has. Take it out.")
    try:
        found = os.stat(file)
    except OSError as error:
        raise _fault(error, kind) from None
    _check(found, kind)
    if counts:
        _read[found.st_dev, found.st_ino] = file if os.path.isabs(file) else os.path.abspath(file)
    return Stamp(found.st_mtime_ns, found.st_size)


def content_of(file: str | Path, kind: Kind, *, counts: bool = True) -> bytes:
    """All bytes of a file, which counts as an input of this run unless said otherwise; errors as of `stamp_of`."""
    file = str(file)
    stamp_of(file, kind, counts=counts)  # a device is not even opened: some act on that
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    parts: list[bytes] = []
    try:
        raw = os.open(file, flags)
        try:
            _check(found := os.fstat(raw), kind)
            wanted = max(found.st_size + 1, _BLOCK)
            while part := os.read(raw, wanted):
                parts.append(part)
                _check_size(sum(map(len, parts)), kind)  # it may still grow
        finally:
            os.close(raw)
    except OSError as error:
        raise _fault(error, kind) from None
    return b"".join(parts)


def was_read(file: str | Path) -> bool:
    """Whether this run has looked into the file, by whatever name."""
    try:
        found = os.stat(file)
        name = _read.get((found.st_dev, found.st_ino))
        return name is not None and os.path.samestat(found, os.stat(name))
    except (OSError, ValueError):
        return False


def forget() -> None:
    """A new run begins: nothing has been read."""
    _read.clear()


def shown_name(file: str | Path) -> str:
    """A file name for messages and titles: signs that no terminal shows replaced, long ones cut in the middle.

    That of a folder without a name, where the file lies, is a point.
    """
    text = str(file).encode("utf-8", "replace").decode() or "."
    shown = text if text.isprintable() else "".join(one if one.isprintable() else "?" for one in text)
    return shortened(shown, _LONGEST)


def _check(found: os.stat_result, kind: Kind) -> None:
    for is_one, word in () if stat.S_ISREG(found.st_mode) else _SORTS:
        if is_one(found.st_mode):
            raise FileFault(f"is {word}. {kind.way}", folder=is_one is stat.S_ISDIR)
    _check_size(found.st_size, kind)


def _check_size(size: int, kind: Kind) -> None:
    if size > kind.largest:
        raise FileFault(f"has {size / 1e6:.1f} MB; {kind.noun} has at most {kind.largest / 1e6:.0f} MB.")


def _fault(error: OSError, kind: Kind) -> FileFault:
    if isinstance(error, (FileNotFoundError, NotADirectoryError)):
        return FileFault(f"is not there. {kind.missing}", missing=True)
    return FileFault(f"cannot be read: {error.strerror or error}.")
