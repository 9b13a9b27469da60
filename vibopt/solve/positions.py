"""Places of mounts in a range: positions are searched, and for each of them the rest is solved as it stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.answer.entry import Chosen, Entry
from vibopt.arrays import FloatArray
from vibopt.document.mistakes import Mistakes
from vibopt.errors import counted
from vibopt.records import dataclass
from vibopt.scene.check_scene import check
from vibopt.scene.open_places import open_places, open_positions, positioned, settled
from vibopt.scene.scene import MINIMISE, Design, Scene, Variable
from vibopt.solve.best_places import with_goal
from vibopt.solve.method import Progress
from vibopt.solve.positions_search import Score, Search
from vibopt.verify.checked import checked_limits
from vibopt.work import Budget

Answer = Callable[[Scene, Sequence[float] | None], Design]
MOST = 3000
"""Most positions that are solved."""
_FOUND = ("optimal", "feasible")
_HOPELESS = 1e12


def best_position(scene: Scene, answer: Answer, progress: Progress | None = None) -> Design:
    """The best answer that a search over the positions finds.

    Parameters
    ----------
    scene
        A scene with coordinates or shifts of mounts left open, and a goal.
    answer
        Answers a scene with all positions given, beginning near a design of a scene much like it.
    progress
        Called with the number of positions and the part of them that is used.

    Notes
    -----
    Never "optimal": the positions are searched.  Never "infeasible": where nothing is found, nothing is proven.
    """
    asked = _Positions(scene, answer)

    def tell(count: int) -> None:
        if progress is not None:
            progress(counted(count, "positions"), count / MOST)

    search = Search(asked.score, len(asked.variables), Budget(MOST, "positions"), tell)
    u = search.run()
    made = asked.at(u)
    best = asked.answered(made)
    if asked.begin is not None:  # with all starts, not only those near another position's answer
        best = min(best, asked.solved(made, None), key=asked.rated)
    return _concluded(asked, best, u, search)


@dataclass
class _Positions:
    """Positions as points of the unit box, and the answers there; `begin` is the design to begin from."""

    scene: Scene
    answer: Answer
    begin: Sequence[float] | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.variables = list(open_positions(self.scene).values())

    def values(self, u: FloatArray) -> list[float]:
        """Coordinates [m]; the ends are those of the file, to the last digit."""
        return [
            variable.low
            if t == 0.0
            else variable.high
            if t == 1.0
            else variable.low + float(t) * (variable.high - variable.low)
            for variable, t in zip(self.variables, u, strict=True)
        ]

    def at(self, u: FloatArray) -> Scene:
        """The scene with these positions."""
        return positioned(self.scene, self.values(u))

    def score(self, u: FloatArray) -> Score:
        """Of a point of the unit box."""
        made = self.at(u)
        if not sound(made):
            return 1, _HOPELESS
        design = self.answered(replace(made, measures={}))
        if design.status in _FOUND and design.x:
            self.begin = design.x
        return self.rated(design)

    def answered(self, made: Scene) -> Design:
        """The answer at these positions, from the last design on."""
        return self.solved(made, self.begin)

    def solved(self, made: Scene, begin: Sequence[float] | None) -> Design:
        """The answer at these positions; the time it takes is added up."""
        design = with_goal(self.answer(made, begin))
        for stage, spent in design.timings.items():
            self.seconds[stage] = self.seconds.get(stage, 0.0) + spent
        return design

    def rated(self, design: Design) -> Score:
        """The goal, or by how much limits are missed."""
        goal = self.scene.goal
        assert goal is not None
        if design.status == "unbounded":
            return 0, -np.inf
        if design.status in _FOUND and design.goal is not None:
            value = design.goal[1].value
            if np.isfinite(value):
                return 0, value if goal.sense == MINIMISE else -value
        return 1, _missed(design)


def sound(made: Scene) -> bool:
    """Whether the scene with these positions is one that could stand in a file."""
    if any(len(set(table.sites)) < table.count for table in made.mounts.values()):
        return False
    mistakes = Mistakes(made.name)
    for one in [scene for _, scene in settled(made)] if open_places(made) else [made]:
        check(one, mistakes, set())
    return not mistakes.found


def _missed(design: Design) -> float:
    """By how much limits are missed, of a design half way in all ranges where there is none at this position."""
    rows = design.limits
    if not rows and not open_places(design.scene):
        rows = checked_limits(design.scene, {variable.path: _half_way(variable) for variable in design.scene.variables})
    by = [min(max(-row.margin, 0.0), _HOPELESS) for row in rows.values()]
    return float(sum(by)) if by else _HOPELESS


def _half_way(variable: Variable) -> float:
    if variable.values is not None:
        return variable.values[len(variable.values) // 2]
    high = variable.high if np.isfinite(variable.high) else max(1e6 * variable.low, 1.0)
    return float(np.sqrt(variable.low * high))


def _concluded(asked: _Positions, best: Design, u: FloatArray, search: Search) -> Design:
    """What is known of the best position, with the positions among the variables."""
    many = counted(len(search.seen), "positions")
    short = f", cut short after {many}" if search.cut else ""
    scene = replace(best.scene, asked=asked.scene)
    details = {**best.details, "positions": {"solved": len(search.seen), "cut_short": search.cut}}
    best = replace(best, job=scene, details=details, timings=asked.seconds)
    if best.status == "unbounded":
        return replace(best, claim=f"at {_spoken(asked, u)}: {best.claim}")
    if asked.rated(best)[0] or best.status not in _FOUND:
        claim = f"none of {many} that were solved keeps every limit; nothing is proven of the others{short}"
        status = "check_failed" if best.status == "check_failed" else "unproven"
        why = f"nearest at {_spoken(asked, u)}: {best.claim}"
        nothing = replace(best, status=status, claim=claim, reason=why, goal=None, variables={}, places={})
        return replace(nothing, x=(), limits={}, measures={})
    proven = "proven best" if best.status == "optimal" else "not proven to be best"
    rest = f"; the rest of the design is {proven} for these positions ({best.claim})" if scene.variables else ""
    claim = f"the best of {many} that were solved; that no better position exists is not proven{short}{rest}"
    values = asked.values(u)
    chosen = {variable.path: _chosen(variable, value) for variable, value in zip(asked.variables, values, strict=True)}
    return replace(best, status="feasible", claim=claim, variables={**chosen, **best.variables})


def _chosen(variable: Variable, value: float) -> Chosen:
    at = "from" if value == variable.low else "to" if value == variable.high else ""
    return Chosen(Entry(value, "length", variable.unit), at)


def _spoken(asked: _Positions, u: FloatArray) -> str:
    pairs = zip(asked.variables, asked.values(u), strict=True)
    return ", ".join(f"{variable.path} = {_chosen(variable, value).value.shown}" for variable, value in pairs)
