"""Answers kept in a file, and how they compare with the answers of today or of another machine."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from hashlib import sha256
from math import tau
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.jsonable import json_text, plain
from vibopt.errors import InputError
from vibopt.files.marks import is_ours, with_json_check
from vibopt.files.reading import FileFault, Kind, content_of, shown_name
from vibopt.jobs import is_scene
from vibopt.records import dataclass
from vibopt.values.directions import is_number

if TYPE_CHECKING:
    from vibopt.jobs import Job

MARK = "vibopt verify"
_KEEP = "Keep answers with vibopt verify PATH... --save FILE."
_ARCHIVE = Kind("an archive of answers", 1_000_000_000, _KEEP, _KEEP)
LIBRARIES = ("vibopt", "numpy", "scipy", "clarabel", "casadi")
EQUAL, CLOSE, DIFFERS = "byte-equal", "equal to 1e-9", "differs"
CLOSENESS = 1e-9
"""Greatest difference of two numbers, relative to the greater; of margins and gaps, which are ratios, in itself."""
NOISE = 1e-12
"""What is smaller than this part of the greatest value of its unit in the answer is rounding around zero."""
RATIOS = ("margin", "gap")
FLAT = 1e-6
"""The same for a speed at which a response is worst: a peak is flat, its place has half the digits of its height."""
NOT_COMPARED = ("timings", "details")
"""How long it took, and how the answer was found."""
_NUMERAL = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def kept_answer(file: Path, job: Job, found: Answer[Any]) -> dict[str, Any]:
    """What is kept of one answer: digests of the files it was made from, and the answer with its prices.

    Parameters
    ----------
    file
        The problem file.
    job, found
        What it asks, and the answer.
    """
    from vibopt.study.prices import priced

    answer = {key: one for key, one in plain(priced(found).to_json()).items() if key != "timings"}
    return {"sha256": _digests(file, job), "answer": json.loads(json_text(answer))}


def _digests(file: Path, job: Job) -> dict[str, str]:
    if is_scene(job):
        from vibopt.report.sheet import digests_of

        return digests_of(file, job)
    readings = getattr(job, "document", {}).get("readings")
    files = [file, *([file.parent / readings] if isinstance(readings, str) else [])]
    return {one.name: sha256(content_of(one, _ARCHIVE)).hexdigest() for one in files}


def archive_text(answers: Mapping[str, Mapping[str, Any]]) -> str:
    """Answers by the name of their file, as text that is the same for the same answers: sorted keys, exact numbers."""
    return with_json_check(_canonical({"kept_by": MARK, "made_with": versions(), "answers": answers}))


def versions() -> dict[str, str]:
    """Python and the libraries that compute."""
    from importlib.metadata import PackageNotFoundError, version
    from platform import python_version

    found = {"python": python_version()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def read_archive(path: str | Path) -> dict[str, Any]:
    """Answers that were kept.

    Raises
    ------
    InputError
        The file cannot be read, or was not written by `vibopt verify --save`.
    """
    shown = shown_name(path)
    try:
        content = content_of(path, _ARCHIVE)
    except FileFault as error:
        raise InputError(f"{shown} {error}") from None
    try:
        data = json.loads(content)
    except (ValueError, RecursionError):
        data = None
    if not is_archive(data):
        raise InputError(
            f"{shown} holds no answers kept by vibopt. Write them with vibopt verify PATH... --save {shown}."
        )
    if not is_ours(content):
        raise InputError(f"{shown} has been changed since vibopt wrote it. Take the file as it was written.")
    return dict(data)


def is_archive(data: object) -> bool:
    """Whether this is what `archive_text` writes."""
    if not isinstance(data, dict) or data.get("kept_by") != MARK or not isinstance(data.get("made_with"), dict):
        return False
    answers = data.get("answers")
    return isinstance(answers, dict) and all(
        isinstance(answer, dict) and isinstance(answer.get("answer"), dict) and isinstance(answer.get("sha256"), dict)
        for answer in answers.values()
    )


@dataclass(frozen=True, slots=True)
class Comparison:
    """The answer of one file beside the one that was kept.

    verdict
        EQUAL, CLOSE or DIFFERS.
    largest, at
        Greatest difference of two numbers within CLOSENESS, and its path; 0 and "" where there is none.
    differences
        What differs, one sentence each.
    note
        That the files are not those the kept answer was made from; "" where they are.
    kept_as
        Another name that the answer of the same files was kept by; "" where it is this one.
    """

    file: str
    verdict: str
    largest: float = 0.0
    at: str = ""
    differences: tuple[str, ...] = field(default=())
    note: str = ""
    kept_as: str = ""

    @property
    def words(self) -> str:
        """The verdict with what belongs to it."""
        more = f" (largest difference {self.largest:.2g} at {self.at})" if self.verdict == CLOSE and self.at else ""
        note = f"kept as {self.kept_as}" if self.kept_as else self.note
        return f"{self.verdict}{more}{f'; {note}' if note else ''}"


def compared_among(name: str, answers: Mapping[str, Any], now: Mapping[str, Any] | None) -> Comparison:
    """The answer of one file, and what was kept by its name, else of the same files seen from another folder."""
    if name in answers or now is None:
        return compared(name, answers.get(name), now)
    same = [other for other, answer in answers.items() if answer["sha256"] and answer["sha256"] == now["sha256"]]
    if not same:
        return compared(name, None, now)
    return replace(compared(name, answers[min(same)], now), note="", kept_as=min(same))


def compared(name: str, kept: Mapping[str, Any] | None, now: Mapping[str, Any] | None) -> Comparison:
    """The answer of one file, and the one that was kept; None where there is none."""
    if kept is None:
        return Comparison(name, DIFFERS, differences=("no answer of it was kept.",))
    if now is None:
        return Comparison(name, DIFFERS, differences=("it has no answer now.",))
    note = "" if kept["sha256"] == now["sha256"] else "the problem file or a file that it names has changed since"
    before, after = kept["answer"], now["answer"]
    if _canonical(before) == _canonical(after):
        return Comparison(name, EQUAL, note=note)
    beside = _Beside(before, after)
    beside.walk(before, after, "")
    if beside.differences:
        return Comparison(name, DIFFERS, differences=tuple(beside.differences), note=note)
    return Comparison(name, CLOSE, beside.largest, beside.at, note=note)


class _Beside:
    """Two answers walked side by side."""

    def __init__(self, before: Any, after: Any) -> None:
        self.greatest: dict[str, float] = {}
        for one in (before, after):
            for unit, value in _values(one):
                self.greatest[unit] = max(self.greatest.get(unit, 0.0), abs(value))
        self.largest, self.at = 0.0, ""
        self.differences: list[str] = []

    def walk(self, before: Any, after: Any, path: str, unit: str | None = None) -> None:
        """Go down both as far as they are alike."""
        if isinstance(before, dict) and isinstance(after, dict):
            self._tables(before, after, path)
        elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
            for index, pair in enumerate(zip(before, after, strict=True)):
                self.walk(*pair, f"{path}.{index + 1}")
        elif is_number(before) and is_number(after):
            self._numbers(before, after, path, unit)
        elif not (before == after or _same_words(before, after, shown=path.endswith("shown"))):
            self.differences.append(f"{path}: {_short(after)} instead of {_short(before)}")

    def _tables(self, before: dict[str, Any], after: dict[str, Any], path: str) -> None:
        unit = before.get("unit") if isinstance(before.get("unit"), str) else None
        for key in (*before, *(one for one in after if one not in before)):
            inner = f"{path}.{key}".lstrip(".")
            if inner in NOT_COMPARED:
                continue
            if key in before and key in after:
                self.walk(before[key], after[key], inner, unit if key == "value" else None)
            else:
                self.differences.append(f"{inner}: {'not there now' if key in before else 'was not there'}")

    def _numbers(self, before: float, after: float, path: str, unit: str | None) -> None:
        gap, size = abs(before - after), max(abs(before), abs(after))
        if unit == "rad":  # 359.999... and 0 degrees are the same direction
            gap = min(gap, abs(gap - tau))
        whole = self.greatest.get(unit, 0.0) if unit is not None else 0.0
        if path.rpartition(".")[2] not in RATIOS and gap:
            gap /= whole if gap <= NOISE * whole else size
        if ".worst_at." in path and gap <= FLAT:
            return
        if gap > CLOSENESS:
            self.differences.append(f"{path}: {after:.12g} instead of {before:.12g}, difference {gap:.2g}")
        elif gap > self.largest:
            self.largest, self.at = gap, path


def _values(data: Any) -> Iterator[tuple[str, float]]:
    """Every value with its unit."""
    if isinstance(data, dict):
        if isinstance(data.get("unit"), str) and is_number(data.get("value")):
            yield data["unit"], data["value"]
        for one in data.values():
            yield from _values(one)
    elif isinstance(data, list):
        for one in data:
            yield from _values(one)


def _same_words(before: object, after: object, *, shown: bool) -> bool:
    """Whether two texts say the same, numbers alike to the digits that are said; shown ones stand beside exact ones."""
    if not (isinstance(before, str) and isinstance(after, str)):
        return False
    if _NUMERAL.sub("#", before) != _NUMERAL.sub("#", after):
        return False
    pairs = zip(_NUMERAL.findall(before), _NUMERAL.findall(after), strict=True)
    return shown or all(_same_numeral(*pair) for pair in pairs)


def _same_numeral(before: str, after: str) -> bool:
    """Whether two numerals differ by no more than one in the last digit, or are both rounding around zero."""
    value, other = (float(text.replace("−", "-")) for text in (before, after))
    size = max(abs(value), abs(other))
    return abs(value - other) <= 1.5 * max(_last_digit(before), _last_digit(after)) or size <= CLOSENESS


def _last_digit(text: str) -> float:
    """What one more in its last digit is worth; of a whole number nothing: it counts things."""
    digits, _, power = text.partition("e")
    _, point, behind = digits.partition(".")
    return 10.0 ** (int(power or 0) - len(behind)) if point or power else 0.0


def _short(value: Any) -> str:
    text = " ".join(json.dumps(value, ensure_ascii=False).split())
    return text if len(text) <= 120 else f"{text[:117]}..."


def _canonical(data: object) -> str:
    return json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def changed_versions(kept: Mapping[str, Any]) -> Sequence[str]:
    """Libraries that were others when the answers were kept, "numpy 2.3.0 then, 2.4.6 now"."""
    now, then = versions(), kept["made_with"]
    return [f"{name} {then.get(name, 'unknown')} then, {now[name]} now" for name in now if then.get(name) != now[name]]
