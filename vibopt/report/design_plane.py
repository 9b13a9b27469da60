"""The plane of two design variables: where each limit holds, and what the goal is.

For pictures only: speeds are sampled, closely around every resonance of every design; no answer is read off it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from vibopt.answer.blocks import spoken
from vibopt.arrays import FloatArray
from vibopt.errors import InputError, way_out
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Limit
from vibopt.records import dataclass
from vibopt.report.worst_off import LARGE, over
from vibopt.responses.absorber_responses import Stroke
from vibopt.scene.places import place_of
from vibopt.scene.scene import MAXIMISE, Design, Scene, Variable
from vibopt.units import best_unit, to_unit
from vibopt.units.spelling import split_detector

SIDE, MIDDLE_SIDE, SMALL_SIDE = 61, 37, 21
_SPRINGS = ("tuning", "frequency", "stiffness", "torsional_stiffness", "length", "shaft")
_DAMPERS = ("damping_ratio", "damping", "torsional_damping", "loss_factor")
_MASSES = ("mass", "mass_ratio", "inertia")


@dataclass(frozen=True, slots=True)
class PlaneAxis:
    """One variable: label with unit, values in that unit, and whether the axis is logarithmic."""

    label: str
    values: FloatArray
    log: bool


@dataclass(frozen=True, slots=True)
class Boundary:
    """A limit over the plane: `excess` (n_y, n_x) is positive where the limit is broken."""

    name: str
    excess: FloatArray


@dataclass(frozen=True, slots=True)
class Plane:
    """What the design map shows; `goal` (n_y, n_x) in `goal_label`'s unit, `best` in the axes' units.

    With `levels` the level lines are what the map is about; without the goal, of a worst response.
    """

    title: str
    x: PlaneAxis
    y: PlaneAxis
    boundaries: tuple[Boundary, ...]
    goal: FloatArray | None
    goal_label: str
    best: tuple[float, float] | None
    best_words: str
    levels: bool = False


def plane(design: Design, absorber: str = "") -> Plane | None:
    """The map of an answer with exactly two continuous variables, or of two variables of one absorber.

    Parameters
    ----------
    design
        Any answer.
    absorber
        Its spring and its damper (else its mass) are the axes; all other variables stay as chosen.

    Returns
    -------
    Plane | None
        None where there are no such two variables, or no design in which the others could stay.
    """
    pair = _pair(design.scene, absorber)
    if pair is None or (absorber and len(design.x) != len(design.scene.variables)):
        return None
    program = pose(design.scene)
    slow = any(limit.form.harmonic is not None and limit.form.harmonic.rigid_link for limit in program.limits)
    slow |= program.model.n_free >= LARGE or any(part.form.screened for part in program.parts)
    whole = np.array(design.x) if len(design.x) == len(design.scene.variables) else None
    variables = [design.scene.variables[i] for i in pair]
    best = None if whole is None else (float(whole[pair[0]]), float(whole[pair[1]]))
    side = SMALL_SIDE if slow else MIDDLE_SIDE if absorber and program.model.n_free > 2 else SIDE
    axes = [_values(variable, best[i] if best else None, side) for i, variable in enumerate(variables)]
    if design.scene.absorbers and best is not None:
        axes = [(_closer(values, here), log) for (values, log), here in zip(axes, best, strict=True)]
    grid = np.stack(np.meshgrid(axes[0][0], axes[1][0]), axis=-1)
    flat = np.tile(whole if whole is not None else np.zeros(2), (grid[..., 0].size, 1))
    flat[:, list(pair)] = grid.reshape(-1, 2)
    shape = grid.shape[:2]
    units = [_unit(variable, values) for variable, (values, _) in zip(variables, axes, strict=True)]
    factors = [to_unit(1.0, unit, variable.dimension) for unit, variable in zip(units, variables, strict=True)]
    shown = [
        PlaneAxis(_axis_words(design, program.aim, i, unit), values * factor, log)
        for i, unit, factor, (values, log) in zip(pair, units, factors, axes, strict=True)
    ]
    excesses = [_excess(limit, flat) for limit in program.limits]
    goal, label = _goal(design, program.aim, flat, shape)
    if goal is None and design.scene.absorbers:
        goal, label = _worst_of(design, program.limits, excesses, shape)
    here = None
    if best is not None:
        x, y = (to_unit(a, unit, variable.dimension) for a, unit, variable in zip(best, units, variables, strict=True))
        here = x, y
    lines = zip(program.limits, excesses, strict=True)
    return Plane(
        title=_title(absorber, len(design.scene.variables) - 2),
        x=shown[0],
        y=shown[1],
        boundaries=tuple(Boundary(limit.name, excess.reshape(shape)) for limit, excess in lines),
        goal=goal,
        goal_label=label,
        best=here,
        best_words=_chosen_words(design, variables),
        levels=bool(design.scene.absorbers),
    )


def _chosen_words(design: Design, variables: Sequence[Variable]) -> str:
    """What was chosen for both, a line each."""
    chosen = [variable.path for variable in variables if variable.path in design.variables]
    return "\n".join(f"{_plain(path)} {design.variables[path].value.shown}" for path in chosen)


def _plain(path: str) -> str:
    """A variable in words: "stiffness of mount"."""
    _, name, *rest = path.split(".")
    return f"{' '.join(rest).replace('_', ' ')} of {name}"


def _axis_words(design: Design, aim: Aim | None, index: int, unit: str) -> str:
    """A variable with its unit, and where the goal is this variable, which way is better."""
    words = _plain(design.scene.variables[index].path) + (f" [{unit}]" if unit else "")
    goal = design.scene.goal
    if goal is None or aim is None or aim.form.powers is None:
        return words
    powers = np.asarray(aim.form.powers.exponents)
    if np.count_nonzero(powers) != 1 or not powers.reshape(-1, powers.shape[-1])[:, index].any():
        return words
    more = (goal.sense == MAXIMISE) == (powers.sum() > 0)
    return f"{words}, {'more is better →' if more else '← less is better'}"


def _title(absorber: str, left: int) -> str:
    whose = f": absorber {absorber}" if absorber else ""
    others = "the other variable" if left == 1 else f"the other {left} variables"
    return f"Where every limit holds{whose}" + (f" ({others} as chosen)" if left else "")


def absorbers_with_map(design: Design) -> list[str]:
    """Absorbers of which two continuous variables make a map of a design."""
    scene = design.scene
    return [name for name in scene.absorbers if _pair(scene, name) and len(design.x) == len(scene.variables)]


def axes_asked(scene: Scene, absorber: str) -> str:
    """The absorber of which two variables are the axes of a map; "" where they are the two of the scene.

    Raises
    ------
    InputError
        There are no such two variables, or more than one absorber has them and none is named.
    """
    if absorber and absorber not in scene.absorbers:
        raise InputError(
            f"{scene.name}: there is no absorber called {absorber}.{way_out(absorber, list(scene.absorbers))}"
        )
    if _pair(scene, absorber) is not None:
        return absorber
    possible = [name for name in scene.absorbers if _pair(scene, name) is not None]
    if len(possible) == 1 and not absorber:
        return possible[0]
    if possible:
        listed = " or ".join(f"--map absorbers.{name}" for name in possible)
        raise InputError(f"{scene.name}: a map has two axes. Write {listed}.")
    asked = f"two variables of {absorber}" if absorber else "exactly two variables"
    raise InputError(f"{scene.name}: a map needs {asked} that are not whole or listed.")


def _pair(scene: Scene, absorber: str) -> tuple[int, int] | None:
    """Which two variables are the axes."""
    variables = scene.variables
    if not absorber:
        plain = len(variables) == 2 and all(variable.values is None for variable in variables)
        return (0, 1) if plain else None
    order = {word: rank for rank, words in enumerate((_SPRINGS, _DAMPERS, _MASSES)) for word in words}
    own = [
        i
        for i, variable in enumerate(variables)
        if variable.path.startswith(f"absorbers.{absorber}.") and variable.values is None
    ]
    own.sort(key=lambda i: order.get(variables[i].path.split(".")[2], len(order)))
    return (own[0], own[1]) if len(own) >= 2 else None


def _worst_of(
    design: Design, limits: Sequence[Limit], excesses: Sequence[FloatArray], shape: tuple[int, ...]
) -> tuple[FloatArray | None, str]:
    """The response of a limit on the machine itself: of those that hold the design back, the one that varies most."""
    active = {name for name, row in design.limits.items() if row.active}
    order = sorted(range(len(limits)), key=lambda i: (limits[i].name not in active, -float(np.std(excesses[i]))))
    for limit, excess in ((limits[i], excesses[i]) for i in order):
        response = design.scene.limits.get(limit.name)
        if response is None:  # what a part is rated for knows no speeds
            continue
        if limit.side != "at_most" or limit.complement or isinstance(response, Stroke) or not response.harmonic:
            continue
        unit = response.unit or response.at_most.unit
        if split_detector(unit)[0] == "dB":
            continue
        said = unit if split_detector(unit)[1] or not response.amplitude else f"{unit} pk"
        values = limit.bound * np.exp(excess) * to_unit(1.0, unit, response.dimension)
        words = f"worst {spoken(response.response, place_of(response))}"
        return values.reshape(shape), f"{words} [{said}]" if said else words
    return None, ""


def _values(variable: Variable, best: float | None, side: int) -> tuple[FloatArray, bool]:
    """Values along one axis [SI]: around the best if there is one, else the whole range."""
    low, high = variable.low, variable.high
    if not isfinite(high):
        high = 1e3 * max(best or 0.0, low, 1e-3)
    if high <= 12.0 * low or (low == 0.0 and best is None):
        return np.linspace(low, high, side), False
    if best is None or best <= 0.0:
        return np.geomspace(max(low, 1e-6 * high), high, side), True
    return np.geomspace(max(low, best / 10.0), min(high, 10.0 * best), side), True


def _closer(values: FloatArray, best: float) -> FloatArray:
    """The same axis with more values next to the chosen one, where level lines bend most."""
    step = (values[-1] - values[0]) / len(values) if best < 3.0 * values[0] else best / 10.0
    near = best + step * np.array([-1.5, -1.0, -0.6, -0.3, -0.15, 0.0, 0.15, 0.3, 0.6, 1.0, 1.5])
    merged: FloatArray = np.unique(np.concatenate([values, near[(near >= values[0]) & (near <= values[-1])]]))
    return merged


def _unit(variable: Variable, values: FloatArray) -> str:
    """The unit of the middle value: round numbers stand on the axis."""
    if variable.dimension == "angular_rate" and variable.unit:
        return variable.unit
    unit = best_unit(float(values[len(values) // 2]), variable.dimension)
    return unit if variable.unit in ("", unit) or _metric(variable.unit) else variable.unit


def _metric(unit: str) -> bool:
    return not any(word in unit for word in ("lb", "in", "ft", "oz", "mil", "kgf"))


def _goal(design: Design, aim: Aim | None, x: FloatArray, shape: tuple[int, ...]) -> tuple[FloatArray | None, str]:
    """The goal over the plane, unless it is one of the axes."""
    if aim is None or design.scene.goal is None:
        return None, ""
    response = design.scene.goal.response
    powers = aim.form.powers
    if powers is not None and (np.count_nonzero(powers.exponents) == 1 or design.scene.absorbers):
        return None, ""
    values = over(aim.model, aim.form, x, False)
    values = 1.0 - values if aim.complement else values
    unit = response.unit or best_unit(float(np.median(values[np.isfinite(values)])), response.dimension)
    better = "more" if design.scene.goal.sense == MAXIMISE else "less"
    label = f"equal {response.response.replace('_', ' ')}{f' [{unit}]' if unit else ''}, {better} is better"
    if unit == "dB":
        return None, ""
    return (values * to_unit(1.0, unit, response.dimension)).reshape(shape), label


def _excess(limit: Limit, x: FloatArray) -> FloatArray:
    """Positive where a limit is broken, logarithmic so that contours are straight lines of a power law."""
    values = over(limit.model, limit.form, x, limit.side == "at_least")
    with np.errstate(divide="ignore"):
        size = np.clip(np.log(np.maximum(values, 1e-300) / max(limit.bound, 1e-300)), -50.0, 50.0)
        if limit.side == "at_most":
            return np.asarray(size, dtype=float)
        if limit.side == "at_least":
            return np.asarray(-size, dtype=float)
        upper: FloatArray = np.log(limit.upper / np.maximum(values, 1e-300))
    return np.asarray(np.minimum(size, upper), dtype=float)
