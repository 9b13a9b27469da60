"""Places and ends left open: the scene is answered once for each combination of them, and the best answer is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from vibopt.answer.entry import Word
from vibopt.errors import counted
from vibopt.scene.layouts import layouts
from vibopt.scene.open_places import combinations, groups, has_open_ends, open_places
from vibopt.scene.scene import MINIMISE, Design, Scene
from vibopt.solve.method import Progress

Answer = Callable[[Scene], Design]
_PROVEN = ("optimal", "infeasible")
_UNPROVEN = {"optimal": "feasible", "infeasible": "unproven"}
"""What is left of these where a layout is not answered."""


def best_place(scene: Scene, answer: Answer, progress: Progress | None = None) -> Design:
    """The best answer over all places.

    Parameters
    ----------
    scene
        A scene with at least one place left open, and a goal.
    answer
        Answers a scene with all places settled.
    progress
        Called with the places and the part that is done.

    Notes
    -----
    "optimal" and "infeasible" only where that is proven of every place, none is refused, and nothing is better without
    the parts that some layouts leave without anything to carry.
    """
    possible = layouts(scene)
    variants, refused = possible.built, possible.refused
    found: list[tuple[Mapping[str, str], Design]] = []
    for index, (words, one) in enumerate(variants):
        if progress is not None:
            progress(f"on {_spoken(words)}", index / len(variants))
        found.append((words, with_goal(answer(one))))
    words, best = min(found, key=lambda pair: _rank(pair[1]))  # the first of equals
    designs = [design for _, design in found]
    status, claim = _verdict(best, designs, "layout" if has_open_ends(scene) else "place")
    claim += _exchanged(scene) + _left_out(combinations(scene) - len(variants) - len(refused))
    if possible.bare:
        status, more = _beside(best, [(names, with_goal(answer(one))) for names, one in possible.bare], status)
        claim += more
    if refused:
        status = _UNPROVEN.get(status, status)
        claim += _unanswered(refused)
    rows = [_row(one, design) for one, design in found]
    seconds = {stage: sum(design.timings.get(stage, 0.0) for design in designs) for stage in best.timings}
    settled_places = {path: Word(words[path], names) for path, names in open_places(scene).items()}
    has_answer = best.goal is not None or best.status == "unbounded"
    return replace(
        best,
        status=status,
        claim=claim,
        reason="" if has_answer else "; ".join(f"on {row['place']}: {row['claim']}" for row in rows),
        places=settled_places if has_answer else {},
        timings=seconds,
        details={**best.details, "places": rows},
    )


def _exchanged(scene: Scene) -> str:
    """What is said of identical absorbers; "" where there are none."""
    alike = [" and ".join(path.split(".")[1] for path in group) for group in groups(scene) if len(group) > 1]
    return f"; {', '.join(alike)} are identical: exchanged they count once" if alike else ""


def _left_out(many: int) -> str:
    return (
        f"; {counted(many, 'more layouts')} would be one of these in another order, or have joints that carry nothing"
        if many
        else ""
    )


def _beside(best: Design, bare: Sequence[tuple[tuple[str, ...], Design]], status: str) -> tuple[str, str]:
    """The status beside what the machine is without parts that carry nothing, and what is said of that."""
    names, least = min(bare, key=lambda pair: _rank(pair[1]))
    without = f"; without {', '.join(names)}"
    if _rank(least) < _rank(best):
        value = "every limit holds" if least.goal is None else f"the goal is {least.goal[1].shown}, which is better"
        return _UNPROVEN.get(status, status), f"{without} {value}: leave them out"
    if all(design.status in _PROVEN for _, design in bare):
        return status, f"{without} nothing is better"
    return _UNPROVEN.get(status, status), f"{without} it is not proven that nothing is better"


def _unanswered(refused: Sequence[tuple[Mapping[str, str], str]]) -> str:
    """Layouts that are refused, and the words to the first of them."""
    words, why = refused[0]
    return f"; {counted(len(refused), 'more layouts')} not answered ({_spoken(words)}): {why.removesuffix('.')}"


def with_goal(design: Design) -> Design:
    """Where nothing else is to be chosen, a place is as good as its goal, or breaks a limit."""
    if not design.scene.is_analysis or design.status == "check_failed":
        return design
    if design.status != "met":
        broken = [name for name, limit in design.limits.items() if not limit.met]
        return replace(design, status="infeasible", claim=f"breaks {', '.join(broken)}", goal=None)
    undecided = () if design.tolerances is None else design.tolerances.open
    best = all(one.startswith("measures.") for one in undecided)  # these do not choose the place
    claim = f"every limit holds; the worst machine is not proven for {', '.join(undecided)}"
    return replace(design, status="optimal" if best else "feasible", claim=claim if undecided else "every limit holds")


def _rank(design: Design) -> tuple[int, float]:
    """Less is better: an unbounded goal first, then the goal, then what is left open before what is not."""
    if design.status == "unbounded":
        return 0, 0.0
    goal = design.scene.goal
    if design.status in ("optimal", "feasible") and design.goal is not None and goal is not None:
        return 1, float(f"{design.goal[1].value:.9g}") * (1.0 if goal.sense == MINIMISE else -1.0)
    return (2 if design.status == "check_failed" else 3 if design.status == "unproven" else 4), 0.0


def _verdict(best: Design, designs: list[Design], noun: str) -> tuple[str, str]:
    many = len(designs)
    every = counted(many, f"{noun}s")
    proven = all(design.status in _PROVEN for design in designs)
    if best.status == "infeasible":
        return "infeasible", f"proven for each of {every}"
    if best.status == "optimal" and not proven:
        return "feasible", f"proven for this {noun}, but not that each of the other {many - 1} is worse"
    if best.status == "optimal":
        return "optimal", f"the best of {every}, each of them proven; {best.claim}"
    if best.status == "feasible":
        return "feasible", f"the best of {every}; {best.claim}"
    return best.status, best.claim


def _row(words: Mapping[str, str], design: Design) -> dict[str, Any]:
    return {
        "place": _spoken(words),
        "on": dict(words),
        "status": design.status,
        "goal": design.goal[1].shown if design.goal is not None else "",
        "value": design.goal[1].value if design.goal is not None else None,
        "claim": design.claim,
    }


def _spoken(words: Mapping[str, str]) -> str:
    """Places by their names alone, "floor1, floor3"; ends behind what has them."""
    return ", ".join(
        f"{path.split('.')[1]} {word}" if path.endswith(".between") else word for path, word in words.items()
    )
