"""How far a number of the machine as built may be off, and how it scatters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, QuantityError, counted
from vibopt.files.reading import FileFault, file_of
from vibopt.units import read_quantity

NORMAL, UNIFORM, DATA = "normal", "uniform", "data"
SIGMAS = 3.0
"""Standard deviations within which the worst case of a normal distribution is looked for."""
_WIDEST = 0.2
"""Greatest standard deviation of a normal distribution: five of them leave a mass what it is."""
_FEWEST = 2
_WAY_OUT = 'Write less than 100 %, for example tolerance = "5 %".'
_KINDS = 'Write { normal = "2 %" } for a standard deviation, { uniform = "5 %" } or { data = ["+1 %", "-0.5 %"] }.'


class Scatter(float):
    """A tolerance with its distribution; as a number how far the worst case goes at most, `span` says which way.

    kind
        NORMAL, UNIFORM or DATA.
    size
        Standard deviation, or half the width, as a part; 0 of data.
    data
        Deviations that were measured, each as likely as the others.
    """

    kind: str
    size: float
    data: tuple[float, ...]

    def __new__(cls, kind: str, size: float, data: tuple[float, ...] = ()) -> Scatter:
        reach = SIGMAS * size if kind == NORMAL else size if kind == UNIFORM else max(abs(value) for value in data)
        made = super().__new__(cls, reach)
        made.kind, made.size, made.data = kind, size, data
        return made

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self.kind, self.size, self.data

    def __hash__(self) -> int:
        return hash((self.kind, self.size, self.data))

    def __eq__(self, other: object) -> bool:
        same = (self.kind, self.size, self.data)
        return (other.kind, other.size, other.data) == same if isinstance(other, Scatter) else float(self) == other

    def factors(self, shares: FloatArray) -> FloatArray:
        """By which factor the number is off where a share (n,) of all machines has less."""
        if self.kind == UNIFORM:
            return 1.0 + self.size * (2.0 * shares - 1.0)
        if self.kind == NORMAL:
            from scipy.special import ndtri

            return np.asarray(1.0 + self.size * ndtri(np.clip(shares, 1e-16, 1.0 - 1e-16)))
        ordered = np.sort(np.array(self.data))
        return np.asarray(1.0 + ordered[np.minimum((shares * len(ordered)).astype(int), len(ordered) - 1)])

    @property
    def written(self) -> dict[str, Any]:
        """As it stands in a file."""
        return {self.kind: list(self.data) if self.kind == DATA else self.size}


def span(tolerance: float) -> tuple[float, float]:
    """Least and greatest factor by which a number is off; of data those of the least and the greatest deviation."""
    measured = isinstance(tolerance, Scatter) and tolerance.kind == DATA
    ends = tolerance.data if isinstance(tolerance, Scatter) and measured else (-tolerance, float(tolerance))
    return 1.0 + min(ends), 1.0 + max(ends)


def written(tolerance: float) -> Any:
    """A tolerance as it stands in a file."""
    return tolerance.written if isinstance(tolerance, Scatter) else tolerance


def read_tolerance(given: object) -> float:
    """A part of the value, "5 %" as 0.05, or a distribution as a Scatter.

    Raises
    ------
    QuantityError
        No ratio, negative, or so much that nothing of the value may be left.
    """
    if isinstance(given, Mapping):
        return _scatter(given)
    value = _part(given)
    if value < 0.0:
        raise QuantityError("has a negative tolerance, but a tolerance goes both ways. Write it without the sign.")
    if not value < 1.0:
        raise QuantityError(f"has a tolerance that may leave nothing of it. {_WAY_OUT}")
    return value


def _part(given: object) -> float:
    if isinstance(given, str) and given.strip().endswith("dB"):
        raise QuantityError(f"has a tolerance in dB. {_WAY_OUT}")
    if isinstance(given, (Mapping, list, bool)):
        raise QuantityError(f"has a tolerance that is no number. {_WAY_OUT}")
    if isinstance(given, (int, float)) and 1.0 <= given < 100.0:
        raise QuantityError(f'has a tolerance of {given:g}, which is {100.0 * given:g} %. Write "{given:g} %".')
    try:
        return read_quantity(given, "ratio").value
    except QuantityError:
        raise QuantityError(f"has a tolerance that is no ratio. {_WAY_OUT}") from None


def _scatter(given: Mapping[str, object]) -> Scatter:
    """A distribution of one of the kinds."""
    if list(given) not in ([NORMAL], [UNIFORM], [DATA]):
        raise QuantityError(f"has a tolerance that is no distribution. {_KINDS}")
    ((kind, said),) = given.items()
    if kind == DATA:
        said = _deviations(said) if isinstance(said, str) else said
        if not isinstance(said, list) or len(said) < _FEWEST:
            raise QuantityError(f"has a tolerance from data without a list of deviations. {_KINDS}")
        data = tuple(_part(one) for one in said)
        if not max(abs(value) for value in data) < 1.0:
            raise QuantityError(f"has a tolerance from data that leaves nothing of it. {_KINDS}")
        if not any(data):
            raise QuantityError(f"has a tolerance from data that is never off. {_KINDS}")
        return Scatter(DATA, 0.0, data)
    try:
        size = _part(said)
    except QuantityError:
        if not isinstance(said, str):
            raise
        raise QuantityError(f'has a {kind} tolerance of "{said}", which is no ratio. {_KINDS}') from None
    if size <= 0.0:
        raise QuantityError(f"has a {kind} tolerance that is not greater than zero. {_KINDS}")
    if kind == UNIFORM and not size < 1.0:
        raise QuantityError(f"has a uniform tolerance that may leave nothing of it. {_KINDS}")
    if kind == NORMAL and size > _WIDEST:
        raise QuantityError(
            f"has a standard deviation above {100.0 * _WIDEST:g} %, with which some machines would have nothing of it. "
            'Write { uniform = "..." } or { data = [...] }.'
        )
    return Scatter(kind, size)


def _deviations(given: str) -> list[str]:
    """The cells of a CSV file of deviations: its only column, or the one called deviation, "deviation [%]"."""
    from vibopt.values.csv_tables import heading_of, sheet_of

    try:
        sheet = sheet_of(file := file_of(given))
    except FileFault as fault:
        raise QuantityError(f"has a tolerance from data that {fault.text}") from None
    except InputError as error:
        raise QuantityError(f"has a tolerance from data that cannot be read: {error}") from None
    rows = [(number, tuple(map(sheet.number, row))) for number, row in sheet.rows]
    heads = [heading_of(cell) for cell in rows[0][1]] if rows else []
    place = next((k for k, (name, _) in enumerate(heads) if name.casefold() == _COLUMN), 0)
    headed = bool(heads) and heads[place][0].casefold() == _COLUMN
    if len(heads) > 1 and not headed:
        raise QuantityError(
            f"has a tolerance from {file.name} with {counted(len(heads), 'columns')}, of which none is called "
            f'{_COLUMN}. Name the one that is meant "{_COLUMN} [%]", or leave the others out.'
        )
    unit = heads[place][1] if headed else ""
    found = [(number, row[place] if place < len(row) else "") for number, row in (rows[1:] if headed else rows)]
    for number, cell in found:
        try:
            read_quantity(f"{cell} {unit}".strip() if cell else "", "ratio")
        except QuantityError:
            raise QuantityError(
                f'has a tolerance from data, and "{cell}" in row {number} of {file.name} is no deviation. Write '
                f'"+1 %", or 1 below "{_COLUMN} [%]".'
            ) from None
    return [f"{cell} {unit}".strip() for _, cell in found]


_COLUMN = "deviation"
