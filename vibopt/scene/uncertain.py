"""Numbers of a scene that may be off in the machine as built."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from vibopt.records import dataclass
from vibopt.scene.places import devices, once
from vibopt.scene.scene import Scene
from vibopt.values.fields import Choice, Fact, numbers_in
from vibopt.values.tolerance import span


@dataclass(frozen=True, slots=True)
class Uncertain:
    """A number or a part of a device: built as its value times a factor that `ends` bound.

    tolerance
        How far the factor is from one at most.

    printed
        Path of the variable that says the tolerance, where it differs from part to part of a catalogue; `tolerance`
        is then the greatest of them.
    """

    path: str
    tolerance: float
    printed: str = ""

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest factor: of measured deviations one side may be wider, and one may be missing."""
        return span(self.tolerance)


@once
def uncertain(scene: Scene) -> tuple[Uncertain, ...]:
    """Every number with a tolerance of its own, and those of tables with one; in the order of the file's families."""
    found: dict[str, Uncertain] = {}
    for family, name, table in devices(scene):
        base = f"{family}.{name}"
        own = {path: value.tolerance for path, value, _ in numbers_in(base, table) if value.tolerance > 0.0}
        wide = getattr(table, "tolerance", None) or 0.0
        said = dict(own)
        for part, key in table.parts().items() if wide else ():
            here = f"{base}.{key}"
            if not any(path == here or path.startswith(f"{here}.") for path in own):
                said[f"{base}.{part}"] = wide
        doubts = [Uncertain(path, tolerance) for path, tolerance in said.items()]
        doubts += _printed(base, table.printed)
        doubts += [Uncertain(f"{base}.{end}", span) for end, span in table.offsets().items()]
        for doubt in doubts:
            found |= {path: replace(doubt, path=path) for path in table.scattered(name, doubt.path)}
    return tuple(found.values())


def _printed(base: str, tolerance: Fact | Choice | None) -> list[Uncertain]:
    """The stiffness of a bought part, where its catalogue has tolerances."""
    path = f"{base}.stiffness"
    if isinstance(tolerance, Choice):
        return [Uncertain(path, tolerance.high, f"{base}.part.tolerance")]
    return [Uncertain(path, tolerance.value)] if tolerance is not None and tolerance.value > 0.0 else []


def as_printed(scene: Scene) -> tuple[str, ...]:
    """Devices whose tolerance stands in their catalogue alone: "links.feet"."""
    return tuple(f"{family}.{name}" for family, name, table in devices(scene) if _printed("", table.printed))


def uncertain_at(scene: Scene, chosen: Mapping[str, float]) -> tuple[Uncertain, ...]:
    """The same numbers with the tolerances of the parts that are chosen; `chosen` is the value of variables by path."""
    return tuple(replace(one, tolerance=chosen[one.printed]) if one.printed else one for one in uncertain(scene))


def likely(scene: Scene) -> bool:
    """Whether a limit asks for a probability."""
    return any(limit.with_probability is not None for limit in scene.limits.values())
