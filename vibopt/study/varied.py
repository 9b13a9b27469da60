"""What a study varies: facts, the values that each takes, and the points that they make together."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.balancing import is_engine
from vibopt.document.mistakes import Mistakes
from vibopt.document.toml_reading import changed, inside
from vibopt.errors import InputError, QuantityError
from vibopt.jobs import fact_at, is_scene, of_document, with_changes
from vibopt.records import dataclass
from vibopt.scene.open_places import open_places, open_positions
from vibopt.study.seen import chosen
from vibopt.units import Quantity, is_range, to_unit
from vibopt.values.fact_at import FactAt
from vibopt.values.part_of_now import IN_PERCENT, part_in, parts_in
from vibopt.verify.measured_goal import measure_goal

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job

Sample = Literal["", "sobol", "latin"]
DECIBEL = "dB"
MOST_FACTS = 3
USUAL = {1: 50, 2: 21, 3: 9}
"""Values of each fact in a grid, by the number of facts."""
_BARE = re.compile(r"[+-]?[\d.]+(?:e[+-]?\d+)?", re.IGNORECASE)
_HOW = r"(?P<values>.*?)(?:\s+(?P<how>log|linear))?\s*"
_LIST = r"\s*[,;]\s+|;"
_THOUSANDS = r"\s*\d{1,3}(,\d{3})+(\D.*)?"
"""One number with thousands set off, or a list of numbers of three digits: nobody knows."""
_WRITE = 'Write "5 mm..30 mm", a list "10, 12, 15 mm", or parts of what it is now, "-20 %..+20 %".'


@dataclass(frozen=True, slots=True)
class Varied:
    """One fact and where it goes.

    fact
        In the unit of its range.
    low, high
        Ends [SI].
    listed
        The values of a list [SI], rising; () for a range.
    by_ratios
        Whether the values of a range have equal ratios.
    held
        Whether it is a variable that is held at each value, and no fact.
    """

    fact: FactAt
    low: float
    high: float
    listed: tuple[float, ...] = ()
    by_ratios: bool = False
    held: bool = False

    @property
    def whole(self) -> bool:
        """Whether there is nothing between two whole numbers."""
        return self.fact.dimension == "count"

    def at(self, parts: FloatArray) -> FloatArray:
        """Values [SI] at parts of the range, from 0 to 1; those in dB as the text says that will stand in the file."""
        fact, low, high = self.fact, self.low, self.high
        if fact.unit == DECIBEL:
            ends = [to_unit(end, DECIBEL, fact.dimension) for end in (low, high)]
            levels = ends[0] + parts * (ends[1] - ends[0])
            return np.array([fact.read(f"{level:.12g} {DECIBEL}") for level in levels])
        if self.whole:
            return np.round(low + parts * (high - low))
        found = low * (high / low) ** parts if self.by_ratios else low + parts * (high - low)
        return np.asarray(np.where(parts == 1.0, high, np.where(parts == 0.0, low, found)), dtype=float)

    def values(self, count: int) -> FloatArray:
        """So many values from end to end, or those of the list."""
        if self.listed:
            return np.array(self.listed)
        if self.fact.unit == DECIBEL:
            return self.at(np.linspace(0.0, 1.0, count))
        if self.whole:
            return np.unique(self.at(np.linspace(0.0, 1.0, count)))
        spaced = np.geomspace if self.by_ratios else np.linspace
        return np.asarray(spaced(self.low, self.high, count), dtype=float)


@dataclass(frozen=True)
class Points:
    """Where a study looks: values [SI], shape (n_points, n_facts), and the axes of the grid, () of a sample."""

    varied: tuple[Varied, ...]
    values: FloatArray
    axes: tuple[FloatArray, ...]


def varied(job: Job, ranges: Mapping[str, str], design: Answer[Any] | None = None) -> tuple[Job, tuple[Varied, ...]]:
    """The job with its held variables as facts, and what is varied.

    Parameters
    ----------
    job
        As it is; a variable that is varied becomes a fact.
    ranges
        By path: "5 mm..30 mm", with "log" or "linear" behind it; "10, 12, 15 mm"; "-20 %..+20 %" of what it is now.
    design
        What the job answers, from which parts of a variable are counted.

    Raises
    ------
    InputError
        No such fact, or values that cannot be read.
    """
    if not 1 <= len(ranges) <= MOST_FACTS:
        many = f"--vary is given {len(ranges)} times."
        raise InputError(f"{many} A sweep varies one, two or three facts: leave some out.")
    for path, text in ranges.items():
        _check(path, text)
    held = {path: _text(job, path, text, design) for path, text in ranges.items() if is_variable(job, path)}
    made = _holding(job, held) if held else job
    return made, tuple(_varied(made, path, text, path in held) for path, text in ranges.items())


def _holding(job: Job, held: Mapping[str, Any]) -> Job:
    """The job with variables as facts; where nothing is left to choose, limits and what was the goal are measured."""
    if (
        is_scene(job)
        and job.limits
        and len(held) == len(job.variables)
        and not (open_positions(job) or open_places(job))
    ):
        document = {**changed(job.document, held)}
        measure_goal(job, document)
        document.pop("goal", None)
        return of_document(document, Mistakes(job.name, None))
    return with_changes(job, held)


def is_variable(job: Job, path: str) -> bool:
    """Whether a number is chosen from a range of its own, so that it can be held at each value in turn."""
    if not is_scene(job):  # a weight has a size and an angle, and neither is held alone
        alone = is_engine(job) and path.rpartition(".")[2] in job.choices
        return alone and path in job.decided_at and isinstance(inside(job.document, path), dict)
    choice = next((variable.choice for variable in job.variables if variable.path == path), None)
    return (
        choice is not None
        and not (choice.options or choice.whole or choice.tolerance)
        and (inside(job.document, path) is not None)
    )


def _text(job: Job, path: str, text: str, design: Answer[Any] | None) -> str | float:
    """One value of a variable that is held: the last of its range, or what was chosen where parts of it are varied."""
    each = _parts_of(re.fullmatch(_HOW, text.strip())["values"])  # type: ignore[index]
    if parts_in(each) is None:
        return _as_written(each[-1].strip())
    known = {} if design is None else chosen(job, design)
    now = known.get(path) or known.get(path.rpartition(".")[2])
    if not isinstance(now, Entry):
        raise InputError(f'--vary {path}="{text}": it is to be chosen, so it has no value to take parts of. {_WRITE}')
    variable = next(one for one in job.variables if one.path == path) if is_scene(job) else None
    unit = variable.unit if variable is not None else now.unit
    return _as_written(f"{to_unit(now.value, unit, now.dimension):.17g} {unit}".strip())


def _as_written(text: str) -> str | float:
    """A text as it would stand in a file: without a unit the number itself."""
    return float(text) if _BARE.fullmatch(text) else text


def _parts_of(text: str) -> list[str]:
    parts = text.split("..") if is_range(text) else re.split(_LIST, text)
    if len(parts) == 1 and not re.fullmatch(_THOUSANDS, text):
        parts = text.split(",")
    return [part for part in parts if part.strip()]


def _check(path: str, text: str) -> None:
    parts = _parts_of(re.fullmatch(_HOW, text.strip())["values"])  # type: ignore[index]
    if len(parts) < 2 and not is_range(text):
        raise InputError(f'--vary {path}="{text}" is no range. {_WRITE}')


def _varied(job: Job, path: str, text: str, held: bool) -> Varied:
    fact = fact_at(job, path)
    match = re.fullmatch(_HOW, text.strip())
    assert match is not None
    values, how = _absolute(fact, match["values"]), match["how"]
    try:
        many = fact.ends(values) if is_range(values) else _listed(fact, _parts_of(values))
    except QuantityError as error:
        raise InputError(f'--vary {path}="{text}" {error}') from None
    low, high = many[0].value, many[-1].value
    if high <= low:
        raise InputError(f'--vary {path}="{text}" names one value. {_WRITE}')
    if many[-1].unit == DECIBEL and low <= 0.0:
        raise InputError(f'--vary {path}="{text}" begins at a ratio that has no dB. Write "5 dB..30 dB".')
    fact = replace(fact, unit=many[-1].unit)
    if how == "log" and (low <= 0.0 or fact.unit == DECIBEL):
        why = "dB count ratios already" if fact.unit == DECIBEL else "from zero on there are no equal ratios"
        raise InputError(f'--vary {path}="{text}": {why}. Leave "log" out.')
    listed = () if is_range(values) else tuple(quantity.value for quantity in many)
    ratios = fact.unit != DECIBEL and low > 0.0 and (how == "log" or (how is None and high > 100.0 * low))
    return Varied(fact, low, high, listed, ratios and not listed and fact.dimension != "count", held)


def _listed(fact: FactAt, parts: Sequence[str]) -> tuple[Quantity, ...]:
    """Values of a list [SI], rising; those without a unit have that of the last."""
    unit = fact.quantity(parts[-1].strip()).unit
    texts = [f"{one} {unit}".strip() if _BARE.fullmatch(one) else one for one in map(str.strip, parts)]
    found = {quantity.value: replace(quantity, unit=unit) for quantity in map(fact.quantity, texts)}
    return tuple(found[value] for value in sorted(found))


def _absolute(fact: FactAt, text: str) -> str:
    """A range or list of parts of a number, "-20 %..+20 %" (`vibopt.values.part_of_now`), as that of the number."""
    each, join = _parts_of(text), "..".join if is_range(text) else ", ".join
    found = parts_in(each)
    if found is not None and fact.dimension != "level":
        return join(fact.now(part.times) for part in found)
    if fact.dimension in (IN_PERCENT, "level") or len(each) < 2 or part_in(each[-1]) is None:
        return text
    said = [one.strip().removesuffix("%").strip() for one in each]
    if all(part_in(f"{one} %") for one in said):
        way = join(f"{one} %" if one[0] in "+-−" or not float(one) else f"+{one} %" for one in said)
        why = "a part needs its sign" if found is None and all(map(part_in, each)) else "each part needs its %"
        raise InputError(f'--vary {fact.path}="{text}": {why}. Write "{way}".')
    return text


def points_of(facts: tuple[Varied, ...], count: int | None, sample: Sample) -> Points:
    """A grid with so many values of each range, or so many points drawn evenly (Sobol, Latin hypercube).

    Raises
    ------
    InputError
        A list is to be drawn from.
    """
    if sample:
        return _drawn(facts, count or 256, sample)
    axes = tuple(fact.values(count or USUAL[len(facts)]) for fact in facts)
    whole = np.stack([one.ravel() for one in np.meshgrid(*axes, indexing="ij")], axis=-1)
    return Points(facts, whole, axes)


def how_many(ranges: Mapping[str, str], count: int | None, sample: Sample) -> int:
    """Number of points, before any is made: at most, of whole numbers."""
    if sample:
        return count or 256
    usual = count or USUAL.get(len(ranges), 1)
    return prod(usual if is_range(name) else len(_parts_of(name)) for name in ranges.values())


def _drawn(facts: tuple[Varied, ...], count: int, sample: Sample) -> Points:
    from warnings import catch_warnings, simplefilter

    from scipy.stats import qmc

    if sample not in get_args(Sample):
        raise InputError(f'--sample {sample}: is no way to draw points. Write "sobol" or "latin".')
    listed = [fact.fact.path for fact in facts if fact.listed]
    if listed:
        raise InputError(f"--sample {sample} draws from ranges, and {listed[0]} is a list. Leave --sample out.")
    engine = (qmc.Sobol if sample == "sobol" else qmc.LatinHypercube)(d=len(facts), seed=0)
    with catch_warnings():
        simplefilter("ignore")  # a number of points that is no power of two is a little less even
        parts = engine.random(count)
    return Points(facts, np.stack([fact.at(parts[:, i]) for i, fact in enumerate(facts)], axis=-1), ())
