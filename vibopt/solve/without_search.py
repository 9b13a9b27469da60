"""What needs no search: goals that ranges, limits or the machine let be no better, and what has no end."""

from __future__ import annotations

from dataclasses import replace

from vibopt.forms import Form
from vibopt.forms.reduce import unmoved
from vibopt.program.pose import are_whole
from vibopt.program.program import Aim, Asked, Limit, Program
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import names_for
from vibopt.scene.open_places import numbers_of
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found

_GAP = 1e-6
"""Part of the bound by which the goal may be away from it, as from any bound that is proven."""
_BOUNDS = ("at_most", "at_least", "outside", "unit")


def at_own_bound(scene: Scene, program: Program, found: Found) -> Found:
    """The answer, proven where its ranges, or a limit to the same response, keep its goal from being any better."""
    aim = program.aim
    if found.status != "feasible" or found.x is None or aim is None or scene.goal is None:
        return found
    goal = Judge(program).goal(found.x).value
    if program.is_best(goal):
        claim = "proven: the ranges alone permit no better goal, and this design meets every limit"
        return replace(found, status="optimal", claim=claim, bound=goal)
    asked, value = _without_bounds(scene.goal.response), aim.sense * goal
    side = "at_least" if aim.sense > 0 else "at_most"
    for limit in program.limits:
        response = scene.limits.get(limit.name)
        if response is None or limit.side != side or _without_bounds(response) != asked:
            continue
        if abs(value - limit.bound) <= _GAP * abs(limit.bound):
            claim = f"proven: the goal is at the bound that {limit.name} sets to it; {found.claim}"
            return replace(found, status="optimal", claim=claim, bound=aim.sense * limit.bound)
    return found


def _without_bounds(response: Response) -> tuple[object, ...]:
    """What is asked, and where."""
    return tuple(one for one in numbers_of(response) if one[0] not in _BOUNDS)


OUTRIGHT = ("limit at standstill", "limit on what nothing moves")
"""Methods of such answers, beside which no limit could be loosened."""
_UNMOVED = "no load moves what the goal counts, whatever the design"


def lost_limit(program: Program) -> Limit | None:
    """The first limit that no design can keep: little is asked of what has no end at standstill, or much of nothing."""
    for limit in program.limits:
        if limit.side == "at_most" and _endless(limit.form):
            return limit
        if limit.side == "at_least" and limit.bound > 0.0 and _unmoved(program, limit):
            return limit
    return None


def why_lost(limit: Limit) -> str:
    """Why no design keeps such a limit, as half a sentence."""
    if _endless(limit.form):
        return f"{limit.name} has no end at standstill, whatever the design"
    return f"{limit.name} wants some of what no load moves, whatever the design"


def no_design(limit: Limit) -> Found:
    """The answer where `lost_limit` names a limit."""
    if _endless(limit.form):
        claim = f'proven by the orders of the speed: at standstill "{limit.name}" has no end, whatever the design'
    else:
        claim = f'proven by what the loads move: "{limit.name}" counts nothing of it, whatever the design'
    return Found("infeasible", None, claim, OUTRIGHT[not _endless(limit.form)])


def moot_goal(program: Program) -> str:
    """What makes one design as good as another by the goal, in words; nothing where one may be better."""
    aims = program.aim.pieces if program.aim is not None else ()
    if any(_endless(aim.form) for aim in aims):
        return "the goal has no end at standstill, whatever the design"
    return _UNMOVED if aims and all(_unmoved(program, aim) for aim in aims) else ""


def as_goal(found: Found, told: str, aim: Aim) -> Found:
    """The answer to a program without such a goal, in words of it; what is measured in time or of noise is shown."""
    if found.status not in ("optimal", "feasible"):
        return found
    if told == _UNMOVED:
        zero = all(piece.form.harmonic is not None for piece in aim.pieces)  # which is measured against what cancels
        return replace(found, status="optimal", claim=f"proven: {told}, and every limit holds", bound=0.0, zero=zero)
    if aim.sense < 0.0:
        return replace(found, status="unbounded", claim=f"every limit holds, and {told}")
    return replace(found, status="feasible", claim=f"every limit holds; {told}")


def words(scene: Scene, limit: Limit) -> str:
    """Why, and the way out."""
    if not _endless(limit.form):
        return (
            f"{limit.name} asks for at least some of a motion that no load moves on this machine. Ask it of another "
            "place or direction, or add the load that moves it."
        )
    response = scene.limits[limit.name]
    assert isinstance(response, HarmonicResponse)
    assert limit.form.harmonic is not None
    name = next(one for one in names_for(scene, response) if one in limit.form.harmonic.endless)
    return (
        f"{limit.name} looks at standstill, where {why(scene, name)}. Begin its range above standstill, or hold the "
        "machine to the ground."
    )


def why(scene: Scene, excitation: str) -> str:
    """Why a response to an excitation has no end at standstill, as half a sentence."""
    one = scene.excitations[excitation]
    if one.family == "bases":
        return f"the motion of {one.on} that {excitation} says by its rate has no end"
    return f"no spring holds what {excitation} pushes, and it drifts away"


def _unmoved(program: Program, asked: Asked) -> bool:
    """Whether nothing moves what is asked; of whole models, whose freedoms are all to be looked at, it is not known."""
    left = asked.model.n_free >= program.model.n_free  # what needs some of the freedoms is moved
    return left and not are_whole() and unmoved(asked.model, asked.form)


def _endless(form: Form) -> bool:
    return form.harmonic is not None and bool(form.harmonic.endless)
