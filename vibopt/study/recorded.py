"""Records: what a problem file says its answer is, against the answer."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isinf, tau
from typing import Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry
from vibopt.document.expected import REL_TOL, complaint_of
from vibopt.errors import QuantityError, UnknownName, way_out
from vibopt.jobs import is_scene
from vibopt.records import dataclass
from vibopt.responses import Response
from vibopt.scene.scene import Design
from vibopt.units import read_quantity, show, to_unit
from vibopt.units.parsing import BARE
from vibopt.units.spelling import split_detector
from vibopt.values.speeds import ROTATION

DIGITS = 8


@dataclass(frozen=True, slots=True)
class Row:
    """One record against our answer.

    file, what, printed, verdict
        As recorded; `printed` is what the source says, never compared.
    right
        The recorded answer.
    ours
        The answer now, in the unit of the record.
    difference
        Relative difference; None where the answer is a word.
    ok
        Whether they agree.
    why
        What is wrong with the record or the answer; "" when nothing is.
    """

    file: str
    what: str
    printed: str
    right: str
    ours: str
    verdict: str
    ok: bool
    difference: float | None = None
    why: str = ""


def compare(answer: Answer[Any], record: Mapping[str, Any], file: str = "") -> Row:
    """One record against the answer it speaks of."""
    path, given = str(record.get("path", "")), record.get("value")
    tolerance = record.get("rel_tol", REL_TOL)
    said = str(record.get("what", path)) or "a record"
    printed, verdict = str(record.get("printed", "")), str(record.get("verdict", ""))
    complaint = complaint_of(record)
    ours, difference = "nothing", None
    if not complaint:
        try:
            if is_scene(answer.job):
                ours, difference = _compared(answer, path, given)
            else:
                ours, difference = _compared_balancing(answer, path, given)
        except (QuantityError, _NoSuchPathError) as error:
            complaint = f"{path} = {_text(given)} {error}" if isinstance(error, QuantityError) else str(error)
    ok = not complaint and (ours == given if difference is None else difference <= tolerance)
    if not ok and not complaint and difference is not None:
        complaint = f"{ours} instead of {_text(given)}, relative difference {difference:.2g}, allowed {tolerance:.2g}."
    return Row(
        file, said, printed, _text(given) if "value" in record else "-", ours, verdict, ok, difference, complaint
    )


class _NoSuchPathError(Exception):
    """A record points at nothing in the answer."""


def _compared(design: Design, path: str, given: object) -> tuple[str, float | None]:
    """Our answer as text, and its relative difference; None for a word."""
    if path == "status":
        return design.status, None
    if path == "set":
        return _compared_set(design, given)
    placed = design.places.get(path.removeprefix("variables."))
    if placed is not None:
        return placed.value, None
    shown, dimension, amplitude = _find(design, path)
    right, unit = _read(given, dimension, amplitude, shown.unit)
    return _in_unit(shown.value, unit, dimension), _difference(shown.value, right)


def _compared_balancing(answer: Answer[Any], path: str, given: object) -> tuple[str, float | None]:
    """As above for a balancing job: angles differ by radians, and beside zero the unit of the record counts."""
    try:
        entry = answer.find(path)
    except UnknownName as error:
        raise _NoSuchPathError(f"the answer has no such path: {error}") from None
    if isinstance(entry.value, str):
        return entry.value, None
    word = split_detector(entry.unit)[2]
    right, unit = _read(given, entry.dimension, entry.amplitude or bool(word))
    if word and given != "infinite" and not split_detector(unit)[2]:
        raise QuantityError(f'says neither pk, pp nor rms. Write "{given} {word}".')
    ours = entry.value
    if entry.dimension == "angle":
        gap = abs((ours - right + 0.5 * tau) % tau - 0.5 * tau)
    else:
        gap = _difference(ours, right) if right else abs(to_unit(ours, unit, entry.dimension))
    return _in_unit(entry.value, unit or entry.unit, entry.dimension), gap


def _compared_set(design: Design, given: object) -> tuple[str, float]:
    """Intervals end by end, each relative to the greatest end."""
    if design.found is None:
        raise _NoSuchPathError("the answer has no set: the file asks for none, or none was found.")
    pairs = given if isinstance(given, list) else []
    if not all(isinstance(pair, list) and len(pair) == 2 for pair in pairs) or not isinstance(given, list):
        raise QuantityError('is no list of pairs. Write [["0 rpm", "540 rpm"]].')
    dimension = _found_dimension(design)
    right = [_read(end, dimension, False) for pair in pairs for end in pair]
    unit = right[-1][1] if right else ""
    ours = [end.value for pair in design.found for end in pair]
    text = [_in_unit(value, unit, dimension) for value in ours]
    shown = ", ".join(f"{low}..{high}" for low, high in zip(text[::2], text[1::2], strict=True)) or "empty"
    if len(ours) != len(right):
        return shown, inf
    top = max((abs(value) for value, _ in right), default=1.0) or 1.0
    gaps = [abs(our - value) / (abs(value) or top) for our, (value, _) in zip(ours, right, strict=True)]
    return shown, max(gaps, default=0.0)


def _found_dimension(design: Design) -> str:
    """Of the speeds or values that are found."""
    if design.scene.finds == "values":
        return _dimension(design, str(design.scene.find_all))
    name = str(design.scene.find_all).removesuffix(".speed")
    return design.scene.excitations[name].speed.dimension if name in design.scene.excitations else ROTATION


def _dimension(design: Design, path: str) -> str:
    """Of a variable; a position of a mount is a length."""
    return next((variable.dimension for variable in design.scene.variables if variable.path == path), "length")


def _find(design: Design, path: str) -> tuple[Entry, str, bool]:
    """The value at a path of the answer, its dimension, and whether it is an amplitude."""
    family, _, rest = path.partition(".")
    if family == "variables":
        chosen = _entry(design.variables, rest, "variable")
        return chosen.value, _dimension(design, rest), False
    if family in ("limits", "measures"):
        return _find_checked(design, family, rest)
    if path == "goal":
        if design.goal is None or design.scene.goal is None:
            raise _NoSuchPathError("the answer has no goal.")
        response = design.scene.goal.response
        return design.goal[1], response.dimension, response.amplitude
    known = ("status", "goal", "set", "variables", "limits", "measures")
    raise _NoSuchPathError(f'there is no "{family}" in an answer.{way_out(family, known)}')


def _find_checked(design: Design, family: str, rest: str) -> tuple[Entry, str, bool]:
    """NAME.value, NAME.worst_at or NAME.worst_at.EXCITATION."""
    name, _, key = rest.partition(".")
    checked: Checked = _entry(getattr(design, family), name, family.removesuffix("s"))
    response: Response = getattr(design.scene, family)[checked.name]
    if key == "value":
        return checked.value, response.dimension, response.amplitude
    if key == "worst_at" or key.startswith("worst_at."):
        return _worst_at(design, checked, key.removeprefix("worst_at").removeprefix("."))
    raise _NoSuchPathError(f'{family}.{name} has no "{key}". Write value or worst_at.')


def _worst_at(design: Design, checked: Checked, excitation: str) -> tuple[Entry, str, bool]:
    if not excitation and len(checked.worst_at) != 1:
        names = ", ".join(checked.worst_at) or "none"
        raise _NoSuchPathError(f"the worst of {checked.name} is at a speed of each of: {names}. Write worst_at.NAME.")
    name = excitation or next(iter(checked.worst_at))
    speed = _entry(checked.worst_at, name, "excitation")
    return speed, design.scene.excitations[name].speed.dimension, False


def _entry(table: Mapping[str, Any], name: str, what: str) -> Any:
    if name not in table:
        raise _NoSuchPathError(f'the answer has no {what} "{name}".{way_out(name, table)}')
    return table[name]


def _read(given: object, dimension: str, amplitude: bool, ours: str = "") -> tuple[float, str]:
    """A recorded value in SI (amplitudes peak), and its unit; one without any most likely has that of our answer."""
    if given == "infinite":
        return inf, ""
    if ours and isinstance(given, (int, float)) and not isinstance(given, bool) and dimension not in BARE:
        raise QuantityError(f'has no unit. Write "{given} {ours}".')
    quantity = read_quantity(given, dimension, amplitude=amplitude)
    return quantity.value, quantity.unit


def _difference(ours: float, right: float) -> float:
    """Relative to the right value; absolute [SI] where that is zero."""
    if isinf(ours) or isinf(right):
        return 0.0 if ours == right else inf
    gap = abs(ours - right)
    return gap / abs(right) if right else gap


def _in_unit(value: float, unit: str, dimension: str) -> str:
    """Our value in the unit of the record, with eight digits."""
    return show(value, unit, dimension, digits=DIGITS)


def _text(given: object) -> str:
    """A recorded value as it stands in the file, short."""
    if isinstance(given, list):
        pairs = [pair if isinstance(pair, list) else [pair] for pair in given]
        return ", ".join("..".join(map(str, pair)) for pair in pairs) or "empty"
    return str(given)
