"""Answers of the last files, kept by the content of all that was read, so that a report does not solve again."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.cli.output import note_kept
from vibopt.errors import InputError
from vibopt.files.reading import FileFault, Kind, Stamp, content_of, stamp_of
from vibopt.jobs import is_scene
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job

MOST_ANSWERS, MOST_BYTES = 50, 50_000_000
"""What is kept; the oldest go first."""
MANY_VALUES, WORK_OF_ONE = 2_000, 0.1
"""From how many values on it counts what it takes to keep one [nominal ms]: rotors have as many as coefficients."""
LEAST_WORK = 12.0
"""What an answer to a machine takes at least to be kept [nominal ms]: the press on its mount is sooner solved."""
_PRICED = 4.0
"""Times as much with its prices: the answers behind them are found sooner than the first."""
OFF = "VIBOPT_CACHE"
"""Environment variable that turns it off ("off") or names another folder."""
_ANY = Kind("a file", 1_000_000_000, "", "")


@dataclass(frozen=True, slots=True)
class Asked:
    """What an answer depends on: the file, its changes, the method; `job` is what was read of them.

    whole
        Whether no freedom was left out of its models.
    """

    file: str
    job: Job
    changes: tuple[str, ...] = ()
    method: str | None = None
    whole: bool = False

    def key(self, stage: str) -> str:
        """SHA-256 [hex] of all of it; "" where a file is gone."""
        from hashlib import sha256

        try:
            held = {name: sha256(content_of(path, _ANY, counts=False)).hexdigest() for name, path in self._files()}
        except FileFault:
            return ""
        told = [stage, self.job.name, self.method, list(self.changes), held, self.whole]
        return sha256(repr(told).encode()).hexdigest()

    def stamps(self) -> list[Stamp]:
        """What tells whether its files are still the same; empty where one is gone."""
        try:
            return [stamp_of(path, _ANY, counts=False) for _, path in self._files()]
        except FileFault:
            return []

    def _files(self) -> Iterator[tuple[str, Path]]:
        from vibopt.document.toml_reading import FileText, texts_of

        yield "", Path(self.file)
        for text in texts_of(self.job.document):
            if isinstance(text, FileText):
                yield str(text), text.folder / text
            elif self.changes and Path(text).suffix and len(text) < 200 and Path(text).is_file():
                yield text, Path(text)  # a name that --set has put in


@cache
def program() -> list[Any]:
    """The state of the program's files, hundreds of them: after a change nothing kept is used."""
    home = Path(__file__).parents[1]
    files = list(_sources(str(home)))
    return [str(home), len(files), max(file.st_mtime_ns for file in files), sum(file.st_size for file in files)]


def _sources(home: str) -> Iterator[os.stat_result]:
    """State of every file of Python in a folder and in those below it."""
    for one in os.scandir(home):
        if one.name.endswith(".py"):
            yield one.stat()
        elif "." not in one.name and one.name != "__pycache__" and one.is_dir():
            yield from _sources(one.path)


def folder() -> Path | None:
    """Where answers are kept: the user's folder for what may be thrown away; None where nothing is to be kept."""
    told = os.environ.get(OFF, "")
    if told.lower() in ("off", "0", "no"):
        return None
    if told:
        return Path(told)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", "")
    elif sys.platform == "darwin":
        base = str(Path("~/Library/Caches").expanduser())
    else:
        base = os.environ.get("XDG_CACHE_HOME", "") or str(Path("~/.cache").expanduser())
    return Path(base) / "vibopt" / "answers" if base and not base.startswith("~") else None


def kept(asked: Asked, stage: str) -> Answer[Any] | None:
    """The answer that was kept; None where there is none, or what is there is damaged."""
    home = folder()
    key = asked.key(stage) if home is not None else ""
    if home is None or not key:
        return None
    file = home / f"{key}.json"
    try:
        digest, _, text = file.read_text(encoding="utf-8").partition("\n")
        if digest != _digest(text):
            return None
        import json

        from vibopt.answer.stored import unpacked

        answer: Answer[Any] = unpacked(json.loads(text), lambda told: _job(asked.job, told))
        os.utime(file)  # looked at last, thrown away last
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return answer


def keep(asked: Asked, stage: str, answer: Answer[Any], before: Sequence[Stamp], work: float) -> None:
    """Keep an answer, if it can be made again and the files still are what they were before it.

    Parameters
    ----------
    asked, stage
        What was answered.
    before
        Stamps of its files when it was asked; without any nothing is kept.
    work
        What it took [nominal ms]: what is sooner found again than kept is not.
    """
    home = folder()
    if home is None or not before or _is_sooner_found(answer, work / (_PRICED if stage == "prices" else 1.0)):
        return
    import json

    from vibopt.answer.stored import NotStoredError, alike, packed, unpacked
    from vibopt.files.writing import replace_file

    key = asked.key(stage)
    if not key or asked.stamps() != before:
        return
    try:
        data = packed(answer, lambda job: _told(asked.job, job, answer))
        again = unpacked(data, lambda told: _job(asked.job, told))
        if not alike(data, packed(again, lambda job: _told(asked.job, job, again))):
            return
        text = json.dumps(data)
        home.mkdir(parents=True, exist_ok=True, mode=0o700)
        replace_file(home / f"{key}.json", f"{_digest(text)}\n{text}".encode())
        _thin(home)
        note_kept(f"The answer that was found is kept in {home}: plot and report of the same file do not solve again.")
    except (NotStoredError, OSError, InputError, ValueError, RecursionError):
        return


def _digest(text: str) -> str:
    """SHA-256 [hex] of what is kept, and of the program that keeps it."""
    from hashlib import sha256

    return sha256(f"{program()}\n{text}".encode()).hexdigest()


def _is_sooner_found(answer: Answer[Any], work: float) -> bool:
    """Whether to find an answer again is less work than to write all its values and to read them."""
    many = len(answer.values)
    return work < (LEAST_WORK if is_scene(answer.job) else WORK_OF_ONE * many if many > MANY_VALUES else 0.0)


def _thin(home: Path) -> None:
    """Throw the oldest away until what is left is within its bounds."""
    found = []
    for one in os.scandir(home):
        with suppress(OSError):  # another run has thrown it away
            state = one.stat()
            found.append((state.st_mtime_ns, state.st_size, Path(one)))
    room, count = MOST_BYTES, 0
    for _, size, file in sorted(found, key=lambda each: -each[0]):
        room, count = room - size, count + 1
        if room < 0 or count > MOST_ANSWERS:
            with suppress(OSError):
                file.unlink()


def _told(job: Job, made: Any, answer: Answer[Any]) -> Any:
    """What stands for the job of an answer: itself, or the places and positions chosen in it."""
    from vibopt.answer.stored import NotStoredError

    if made is job:
        return None
    told = {
        "places": {path: place.value for path, place in answer.places.items()},
        "positions": {path: variable.value.value for path, variable in answer.variables.items()},
    }
    if _job(job, told).document != made.document:
        raise NotStoredError("the job of the answer cannot be made again")
    return told


def _job(job: Any, told: Any) -> Any:
    """The job of an answer, from what stands for it."""
    if told is None:
        return job
    from dataclasses import replace

    from vibopt.scene.open_places import open_places, open_positions, positioned, settled

    made, opened = job, open_positions(job)
    if opened:
        if not set(opened) <= set(told["positions"]):
            raise ValueError("no positions were chosen")
        made = positioned(made, [told["positions"][path] for path in opened])
    if open_places(made):
        fitting = [scene for words, scene in settled(made) if dict(words) == told["places"]]
        if not fitting:
            raise ValueError("no places were chosen")
        made = fitting[0]
    return made if made.asked is job else replace(made, asked=job)
