"""Scene to Design: pose, choose a method, answer, certify by another road."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from vibopt.answer.answer import Answer, Tolerances, Used
from vibopt.answer.entry import Checked, Entry
from vibopt.arrays import FloatArray
from vibopt.forms.reduce import reason
from vibopt.mechanics.model import Model
from vibopt.program.pose import are_whole, on_needed, pose
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.report.machine_notes import notes_of
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.places import rubbing
from vibopt.scene.scene import Design, Scene
from vibopt.scene.space import members
from vibopt.scene.uncertain import likely, uncertain
from vibopt.solve.alike import in_order
from vibopt.solve.boundable import with_reason
from vibopt.solve.by_name import called
from vibopt.solve.dispatch import best_of
from vibopt.solve.method import Found, Method, Progress
from vibopt.solve.most_room import spread_out, with_most_room
from vibopt.solve.ranges import closed
from vibopt.solve.without_search import OUTRIGHT, at_own_bound
from vibopt.verify.checked import Built, chosen_of, disagreement, goal_row, unsteady
from vibopt.verify.rated import parts_of
from vibopt.verify.routes import cancels
from vibopt.work import answering, done, metered, worked

_PATIENCE = 10_000.0
"""Work [nominal ms] after which no further loosening is looked for: each is another answer."""

_ROAD = 5.0
"""Work of any answer beside its search [nominal ms]."""


def solve(
    scene: Scene,
    *,
    method: str | Method | None = None,
    progress: Progress | None = None,
    explain: bool = True,
    near: Sequence[float] | None = None,
    thorough: bool = False,
    brief: bool = False,
) -> Design:
    """Answer a scene.

    Parameters
    ----------
    scene
        A scene without mistakes, from `read` or the Python API.
    method
        A method to force, or its name; None lets vibopt choose.
    progress
        Called now and then with a stage and the part that is done (0 to 1).
    explain
        For an infeasible scene, look for the limits that clash and the loosening that helps.
    near
        A design of a scene much like this one [SI]: where several starts are all there is, the first and few others.
    thorough
        Look for loosenings whatever the work.
    brief
        Do not look for the words that say why there is no design.

    Returns
    -------
    Design
        Status, claim, values and evidence; every number was measured on the machine as built.

    Raises
    ------
    InputError
        The forced method does not exist, or does not take this scene.
    """
    called(method)  # a slip in a name is one even where nothing is chosen
    with answering() as limit, metered() as meter:
        worked(_ROAD)
        wish = _Wish(method, progress, explain, near, np.inf if thorough else _PATIENCE, brief)
        design = _solved(scene, wish)
    if limit is not None and not design.proven:  # a complete proof needs no more search
        design = replace(design, claim=limit.added_to(design.claim))
    return design if design.work == meter.done else replace(design, work=meter.done)


@dataclass(frozen=True, slots=True)
class _Wish:
    """How an answer is wished, as `solve` takes it; loosenings are looked for up to `patience` [nominal ms]."""

    method: str | Method | None
    progress: Progress | None
    explain: bool
    near: Sequence[float] | None
    patience: float
    brief: bool


def _solved(scene: Scene, wish: _Wish) -> Design:
    if open_positions(scene) or open_places(scene):
        return _where_best(scene, wish)
    clock = _Clock()
    program = pose(scene)
    if rubbing(scene):
        from vibopt.solve.loosen import beside

        wish = replace(wish, patience=beside(scene, wish.patience))
    clock.stage("pose")
    if scene.find_all is not None:
        return _permitted(scene, program, clock)
    if scene.is_analysis:
        return _analysis(scene, program, clock)
    if likely(scene):
        return _by_chance(scene, program, clock, wish)
    found, why = best_of(
        replace(program, room=()) if program.room else program, scene, wish.method, wish.progress, wish.near
    )
    reason_text = "" if wish.brief else why()
    found = at_own_bound(scene, program, in_order(scene, program, found))
    doubtful = uncertain(scene)
    found = with_most_room(closed(program), found, partial(_again, scene, wish))
    if not doubtful and wish.method is None:
        found = spread_out(closed(program), found)
    if not doubtful:
        found = with_reason(closed(program), found, _unasked(wish))
    clock.stage("solve")
    if program.ties and wish.explain and found.x is not None:
        from vibopt.solve.catalogue.why import free_optimum

        found = replace(
            found, details={**found.details, "free": free_optimum(program, found, thorough=wish.patience == np.inf)}
        )
        clock.stage("free values")
    if doubtful:
        return _over_tolerances(scene, program, found, reason_text, clock, wish)
    if found.x is None or found.status == "unbounded":
        design = _nothing(scene, program, found, reason_text, clock, wish)
        if program.ties and wish.explain and found.status == "infeasible" and found.method not in OUTRIGHT:
            design = _loosened(scene, design, found, closed(program), wish.patience)
        return design
    return _something(scene, program, found, clock)


def _again(scene: Scene, wish: _Wish, program: Program, near: FloatArray | None = None) -> Found:
    """The answer to another program of the same scene."""
    return best_of(program, scene, wish.method, None, wish.near if near is None else near.tolist())[0]


def _unasked(wish: _Wish) -> str:
    """Why boxes were not looked at beside the answer; empty where they were."""
    if wish.method is not None:
        return "a method that is asked for by its name answers alone"
    return "" if wish.near is None else "beside a design that is known to be near none is looked for"


def _where_best(scene: Scene, wish: _Wish) -> Design:
    """The best of the places that are open, each answered as a scene of its own; ranges outside, lists inside."""
    if open_positions(scene):
        from vibopt.solve.positions import best_position

        def at_position(one: Scene, begin: Sequence[float] | None) -> Design:
            near = wish.near if begin is None else begin
            return solve(one, method=wish.method, explain=False, near=near)

        return best_position(scene, at_position, wish.progress)
    from vibopt.solve.best_places import best_place

    def at_place(one: Scene) -> Design:
        return solve(one, method=wish.method, progress=wish.progress, explain=False, near=wish.near)

    return best_place(scene, at_place, wish.progress)


def _over_tolerances(
    scene: Scene,
    program: Program,
    nominal: Found,
    reason_text: str,
    clock: _Clock,
    wish: _Wish,
) -> Design:
    """The answer that holds for every machine within the tolerances, beside the one without them."""
    from vibopt.solve.deviations import goal_machine, limits_over, measures_over, side_by_side
    from vibopt.solve.robust import robust
    from vibopt.verify.as_built import differing

    best = robust(scene, nominal, wish.method, wish.progress)
    found = with_reason(closed(program), best.found, "it would be one of one machine, not of all within the tolerances")
    clock.stage("tolerances")
    if found.x is None:
        clash = wish.explain and nominal.status == "infeasible"
        design = _nothing(scene, program, found, best.reason or reason_text, clock, replace(wish, explain=clash))
        if wish.explain and found.status == "infeasible":
            asked = closed(program) if best.program is None and program.ties else best.program
            design = _loosened(scene, design, found, asked, wish.patience)
            clock.stage("conflict")
        return replace(design, tolerances=side_by_side(scene, nominal, best, {}))
    x = np.asarray(found.x)
    measures, over = measures_over(scene, x, best)
    if left := over.open[len(best.open) :]:
        found = replace(found, claim=f"{found.claim}; the worst found, not proven, for {', '.join(left)}")
    machine = goal_machine(scene, best.hits)
    both = side_by_side(scene, nominal, over, differing(scene, machine))
    return _on_worst(scene, program, found, clock, (limits_over(scene, x, best), measures), both, machine)


def _on_worst(
    scene: Scene,
    program: Program,
    found: Found,
    clock: _Clock,
    rows: tuple[dict[str, Checked], dict[str, Checked]],
    both: Tolerances,
    machine: dict[str, float],
) -> Design:
    """A design with its rows over the tolerances; the goal is that of the machine which is worst for it."""
    from vibopt.program.worst_case import around

    x = np.asarray(found.x)
    chosen = scene.named(x)
    off = replace(scene, off=machine)
    made = _answered(off, program, found, clock, rows, goal_row(off, chosen, None if machine else program.model))
    notes = (*made.notes, "Tolerances: curves show the machine as designed and the worst one, maps the first.")
    used = _used_of(program.model, max(program.used_dof, around(scene, x).used_dof))
    return replace(made, job=scene, notes=notes, tolerances=both, model=used)


def _by_chance(scene: Scene, program: Program, clock: _Clock, wish: _Wish) -> Design:
    """A design of which enough of all machines keep the limits with a probability."""
    from vibopt.solve.chance import by_chance

    def again(one: Scene) -> Design:
        return solve(one, method=wish.method, near=wish.near, explain=False, brief=True)

    sought = by_chance(scene, again, wish.method, wish.progress)
    clock.stage("machines drawn")
    if isinstance(sought, Answer):
        return sought
    if sought.found.x is None:
        design = _nothing(scene, program, sought.found, "", clock, replace(wish, explain=False))
        return replace(design, tolerances=sought.both)
    return _on_worst(scene, program, sought.found, clock, sought.rows, sought.both, sought.machine)


def _loosened(scene: Scene, design: Design, found: Found, clash: Program | None, patience: float) -> Design:
    """The design with the limits that clash (on the machines of `clash`), and what loosening one of them would do."""
    from vibopt.answer.clashes import Clashes
    from vibopt.solve.loosen import clashes_of, conflict_over_tolerances, with_conflict

    def again(one: Scene) -> Design:
        return solve(one, explain=False)

    known = design.conflict
    sets = Clashes(() if known is None else (known.limits, *known.others), known is None or known.complete, 0)
    sets = sets if known is None else replace(sets, doubtful=known.doubtful)
    sets = clashes_of(clash, most=patience) if clash is not None else sets
    return with_conflict(design, conflict_over_tolerances(scene, sets, found, again, most=patience))


class _Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now


def _used(program: Program) -> Used:
    return _used_of(program.model, program.used_dof)


def _used_of(model: Model, used: int) -> Used:
    """Degrees of freedom declared and used; what structures leave out has reasons of its own."""
    own = "no freedom was to be left out" if are_whole() and used == model.n_free else reason(model.n_free, used)
    why = "; ".join([*model.remarks, *([own] if own and used < model.n_free else [])]) if model.remarks else own
    return Used(model.n_free + model.left_out, used, why)


def _used_by(scene: Scene, program: Program) -> Used:
    asked = [
        each for response in (*scene.limits.values(), *scene.measures.values()) for each in members(scene, response)
    ]
    needs = [on_needed(scene, program.model, response) for response in asked]
    used = max((model.n_free for model, form in needs if form.powers is None), default=program.used_dof)
    return _used_of(program.model, max(used, program.used_dof))


def _measured_how(scene: Scene) -> str:
    sorts = {response.sort for response in (*scene.limits.values(), *scene.measures.values())}
    return "followed through time" if sorts == {"transient"} else "measured at every speed of each range"


def _analysis(scene: Scene, program: Program, clock: _Clock) -> Design:
    """Everything measured; a goal, where only places were open, on the machine that is worst for it."""
    robust, worst_of_goal = None, scene
    if uncertain(scene):
        from vibopt.solve.deviations import analysed, goal_machine, limits_over, measures_over
        from vibopt.solve.robust import judged

        measures, robust = measures_over(scene, np.zeros(0), judged(scene, np.zeros(0)))
        limits = limits_over(scene, np.zeros(0), robust)
        worst_of_goal = replace(scene, off=goal_machine(scene, robust.hits))
    else:
        built = Built(scene, {}, program.model)
        limits, measures = built.limits({}), built.measures({})
    clock.stage("measure")
    good = all(limit.met for limit in limits.values())
    broken = [name for name, limit in limits.items() if not limit.met]
    claim = "every limit holds" if good else f"broken: {', '.join(broken)}"
    if not limits:
        claim = "measured; there is no limit to judge"
    goal = goal_row(worst_of_goal, {})
    rows = limits, measures, {} if goal is None else {"goal": goal}
    doubt, grown = disagreement(*rows), unsteady(*rows)
    design = Design(
        job=scene,
        status="check_failed" if doubt != grown else "met" if good and not grown else "violated",
        claim=doubt or f"{claim} ({_measured_how(scene)})",
        goal=None if goal is None else (goal.name, goal.value),
        variables={},
        x=(),
        limits=limits,
        measures=measures,
        model=_used_by(scene, program),
        method="analysis",
        timings=clock.seconds,
        notes=notes_of(scene, {}),
    )
    if robust is None or doubt:
        return design
    from vibopt.solve.odds import with_odds

    over = analysed(design, robust)
    return with_odds(over) if likely(scene) else over


def _permitted(scene: Scene, program: Program, clock: _Clock) -> Design:
    """Every speed, or every value of the one variable, at which all limits hold."""
    from vibopt.solve.find_all import permitted_speeds
    from vibopt.solve.find_values import permitted_values

    answer = permitted_values(scene, program) if scene.variables else permitted_speeds(scene, program)
    clock.stage("solve")
    return replace(answer, model=_used(program), timings=clock.seconds)


def _something(scene: Scene, program: Program, found: Found, clock: _Clock) -> Design:
    assert found.x is not None
    chosen = scene.named(found.x)
    built = Built(scene, chosen, program.model)
    return _answered(scene, program, found, clock, (built.limits({}), built.measures({})), built.goal)


def _answered(
    scene: Scene,
    program: Program,
    found: Found,
    clock: _Clock,
    rows: tuple[dict[str, Checked], dict[str, Checked]],
    goal: Checked | None,
) -> Design:
    """A design with its rows; the goal is measured on the machine that `scene` speaks of."""
    assert found.x is not None
    chosen = scene.named(found.x)
    limits, measures = rows
    if goal is not None and scene.goal is not None and scene.goal.response.of_limits:
        limits = {key: replace(row, tight=goal.value.value) for key, row in limits.items()}
    broken = [name for name, limit in limits.items() if not limit.met]
    doubt = disagreement(limits, measures, {} if goal is None or found.zero else {goal.name: goal})
    if not doubt and goal is not None and found.zero and _is_more(scene, program, found.x, goal.value.value):
        doubt = f"the goal is told as zero, but on the built machine it is {goal.value.shown}"
    clock.stage("certify")
    status, claim = found.status, found.claim
    if broken or doubt:
        status = "check_failed"
        claim = doubt or f"{found.method} claims a design, but on the built machine it breaks {', '.join(broken)}"
    return Design(
        job=scene,
        status=status,
        claim=claim,
        goal=None if goal is None else (goal.name, _as_zero(scene, goal.value) if found.zero else goal.value),
        variables={v.path: chosen_of(v, chosen[v.path]) for v in scene.variables},
        x=tuple(float(v) for v in found.x),
        limits=limits,
        measures=measures,
        model=_used(program),
        method=found.method,
        timings=clock.seconds,
        notes=notes_of(scene, chosen),
        details=found.details,
        places=parts_of(scene, chosen),
        work=done(),
    )


def _is_more(scene: Scene, program: Program, x: FloatArray, measured: float) -> bool:
    """Whether what was measured of a goal [SI] is more than what is left of greater motions that cancel."""
    aim = program.aim
    left = 1.0 - measured if scene.goal is not None and scene.goal.response.complement else measured
    for piece in aim.pieces if aim is not None else ():
        form = piece.form.harmonic
        if form is not None and not cancels(piece.model, form, x, replace(piece.worst(x), value=left)):
            return True
    return False


def _as_zero(scene: Scene, shown: Entry) -> Entry:
    """A goal that is zero, or an isolation that leaves nothing: what rounding left of it is no number to be shown."""
    if scene.goal is not None and scene.goal.response.complement:
        return replace(shown, value=1.0)
    return replace(shown, value=0.0, text=f"0 {shown.shown.partition(' ')[2]}".strip())


def _nothing(scene: Scene, program: Program, found: Found, reason_text: str, clock: _Clock, wish: _Wish) -> Design:
    from vibopt.solve.advice import mass_words
    from vibopt.solve.impasse import conflict_of
    from vibopt.solve.loosen import with_conflict
    from vibopt.solve.physical import impossible

    def again(one: Scene, near: Sequence[float] | None = None) -> Design:
        return solve(one, explain=False, near=near)

    conflict = None
    if found.status == "infeasible" and wish.explain and not program.ties and found.method not in OUTRIGHT:
        many = bool(uncertain(scene))  # then its loosenings are looked for over the tolerances
        conflict = conflict_of(scene, program, found, again, most=wish.patience, names_only=many)
        bound = impossible(closed(program))
        advice = mass_words(scene, bound, again) if bound is not None else ""
        reason_text = " ".join(filter(None, (reason_text, advice)))
    clock.stage("conflict")
    design = Design(
        job=scene,
        status=found.status,
        claim=found.claim,
        goal=None,
        variables={},
        x=(),
        limits={},
        measures={},
        model=_used(program),
        method=found.method,
        timings=clock.seconds,
        reason=reason_text,
        notes=tuple(scene.notes),
        details=found.details,
    )
    return with_conflict(design, conflict)
