"""Items of a long run, kept line by line beside what the run writes: with them one that was stopped goes on."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, TypeVar

from vibopt.errors import InputError
from vibopt.files.reading import shown_name
from vibopt.files.writing import add_line, write_file

T = TypeVar("T")


class Journal(Generic[T]):
    """A first line says which run it is, then each item stands in a line of JSON, exactly.

    Parameters
    ----------
    target
        The file.
    kind, key
        Of what run ("sweep"), and what tells this one, of this content, by this program, from every other.
    others
        What else a run of that kind may be of, in words ("another problem, other ranges").
    option
        The option that names the file beside it ("--csv").
    told, made
        An item as plain data, and back.
    """

    def __init__(
        self, target: Path, kind: str, key: str, *, others: str, option: str, told: Callable[[T], Any],
        made: Callable[[Any], T],
    ) -> None:  # fmt: skip
        self.target, self._mark = target, f"vibopt {kind} "
        self._head, self._others, self._option = f"{self._mark}{key}", others, option
        self._told, self._made = told, made
        self.items: list[T] = []
        self._begun = False

    def take_up(self) -> list[T]:
        """The items that are there; InputError where there are none, or they are those of another run."""
        shown = shown_name(self.target)
        lines = self._lines()
        if lines is None:
            raise InputError(f"--resume: there is no {shown} to go on with. Leave --resume out to begin.")
        if lines[0] != self._head:
            raise InputError(
                f"--resume: {shown} is of {self._others} or another version of vibopt. Leave --resume out to begin "
                "anew."
            )
        try:
            self.items = [self._made(json.loads(line)) for line in lines[1:]]
        except (ValueError, TypeError, KeyError, AttributeError):
            raise InputError(f"--resume: {shown} is damaged. Leave --resume out to begin anew.") from None
        return [*self.items]

    def check(self) -> None:
        """InputError where a file of somebody else has the name."""
        lines = self._lines()
        if lines is not None and not lines[0].startswith(self._mark):
            raise InputError(
                f"{shown_name(self.target)} cannot be written: it is there already, and vibopt did not write it. Name "
                f"another {self._option}."
            )

    def _lines(self) -> list[str] | None:
        """Whole lines; what a power cut has left of a last one is none.  None without a file."""
        try:
            text = self.target.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError):
            return [""]
        return [*text.split("\n")[:-1]] or [""]

    def add(self, item: T) -> None:
        """One more item, on the disk when this returns."""
        self.items.append(item)
        if self._begun:
            add_line(self.target, f"{json.dumps(self._told(item))}\n")
        else:
            lines = [self._head, *(json.dumps(self._told(one)) for one in self.items)]
            write_file(self.target, "".join(f"{line}\n" for line in lines).encode())
            self._begun = True

    def end(self) -> None:
        """All is written: away with it."""
        if self.items:
            self.target.unlink(missing_ok=True)
