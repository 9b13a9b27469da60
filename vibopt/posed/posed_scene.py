"""A scene as a program in the open: what keeps it from being one program is said in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vibopt.document.toml_reading import changed
from vibopt.errors import InputError, counted
from vibopt.posed import conic
from vibopt.posed.convex import EXACT, Convex, not_convex
from vibopt.posed.nonlinear import ENDS
from vibopt.posed.posed import PROVEN, Posed, refused
from vibopt.posed.smooth import Exchange, not_smooth
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.places import bound_parts, empty, joints
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design, Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve
from vibopt.solve.without_search import lost_limit, moot_goal, why_lost
from vibopt.units import si_unit


def posed_scene(scene: Scene) -> Posed:
    """The programs of a scene."""
    why = _not_one_program(scene)
    if why:
        return refused(scene.name, why)
    program = closed(pose(scene))
    rough = not_one(program)
    return Posed(
        scene.name, rough or not_convex(program), rough or not_smooth(program), lambda: _at_its_answer(Convex(program)),
        lambda: Exchange(program).posed(), lambda values: _measured(scene, values),
    )  # fmt: skip


def _measured(scene: Scene, values: Mapping[str, float]) -> Design:
    """The machine with values [SI] for what was to be chosen, the goal among its measures no more."""
    left = [variable.path for variable in scene.variables if variable.path not in values]
    if left or len(values) > len(scene.variables):
        asked = ", ".join(variable.path for variable in scene.variables)
        raise InputError(f"{scene.name}: a design has a value for each of {asked}, and nothing else.")
    texts = {
        variable.path: f"{float(values[variable.path])!r} {si_unit(variable.dimension)}".strip()
        for variable in scene.variables
    }
    document = changed(scene.document, texts)
    return solve(from_dict({key: one for key, one in document.items() if key != "goal"}, name=scene.name))


def _at_its_answer(stated: Convex) -> Any:
    """The problem in SI units, with the speeds that are worst at its answer."""
    stated.solve()
    return Convex(stated.program, speeds=stated.speeds, si=True).problem


def _not_one_program(scene: Scene) -> str:
    if scene.find_all is not None:
        return "a complete set of speeds is asked for, not a best design"
    if not scene.variables:
        return "nothing is to be chosen: it is an analysis"
    if scene.goal is not None and scene.goal.response.of_limits:
        return "the most room in the limits is a row of programs, each with tighter ones. Let vibopt solve it"
    if light := joints(scene):
        return f"{empty(scene)[light[0]]} has no mass, and programs take every body to have one. Let vibopt solve it"
    for path in [*open_positions(scene), *open_places(scene)]:
        return f"{path} leaves places open, and each has a program of its own. Name one place"
    for part in bound_parts(scene):
        return f"{part.path} chooses one of {counted(len(part.names), 'parts')}, which is a list and no range"
    found = uncertain(scene)
    if found:
        return (
            f"{found[0].path} has a tolerance, and the worst machines within it are found one after another. Write "
            'tolerance = "0 %" for the machine as said'
        )
    return ""


def not_one(program: Program) -> str:
    """What keeps a program from being stated at all, in words."""
    for tie in program.ties:
        return f"{tie.path} chooses one of {counted(len(tie.names), 'parts')}, which is a list and no range"
    for axis in program.axes:
        if axis.values is not None and len(axis.values) > 1:
            return f"{axis.path} is chosen from {len(axis.values)} values, which is a list and no range"
    limit = lost_limit(program)
    if limit is not None:
        return why_lost(limit)
    return moot_goal(program)


class Ipopt:
    """The smooth program in CasADi by IPOPT from the best of a few starts, peaks by exchange."""

    name = "ipopt"
    summary = "the smooth program in CasADi by IPOPT, peaks by exchange over their worst speeds"

    def refuses(self, program: Program) -> str | None:
        """What is not smooth, or a choice from a list."""
        return not_one(program) or not_smooth(program) or None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """A local optimum, which keeps every limit at its exact peaks."""
        exchange = Exchange(program)
        y, missed = exchange.run()
        speeds = sum(len(speed) for speed in exchange.samples.speeds.values())
        details = {"exchanges": exchange.rounds, "speeds": speeds}
        if y is None:
            claim = f"IPOPT ends where a limit is missed by {missed:.1e} of its bound ({exchange.words})"
            return Found("unproven", None, claim, self.name, details=details)
        end = "a local optimum by IPOPT" if exchange.words in ENDS else "IPOPT stops on the way"
        claim = f"{end} ({exchange.words}), its peaks exact after {counted(exchange.rounds, 'exchange')} of speeds"
        return Found("feasible", exchange.x(y), claim, self.name, details=details)


class Cvxpy:
    """The convex program in cvxpy by Clarabel, with our own bound; force limits over ranges by exchange."""

    name = "cvxpy"
    summary = "the convex program in cvxpy by Clarabel, with our own dual bound"

    def refuses(self, program: Program) -> str | None:
        """What is not convex, or a choice from a list."""
        return not_one(program) or not_convex(program) or None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """The best design, as far as the gap by our own bound goes."""
        stated = Convex(program)
        run, missed = stated.solve()
        details = {"exchanges": stated.rounds, "speeds": sum(len(speed) for speed in stated.speeds.values())}
        if run.status.startswith("infeasible") and conic.least_missed(stated.problem) > EXACT:
            claim = "proven by our own dual bound of the convex program in cvxpy: some limit is missed by every design"
            return Found("infeasible", None, claim, self.name, details=details)
        if not run.claims or missed > EXACT:
            word = f"missed by {missed:.1e} of a bound" if run.claims else run.status
            claim = f"cvxpy finds no design (Clarabel: {word}), which is not proven here"
            return Found("unproven", None, claim, self.name, details=details)
        x = stated.design()
        value = stated.value(x)
        gap = max(value - run.bound, 0.0) / max(abs(value), 1e-9)
        status = "optimal" if gap <= PROVEN else "feasible"
        claim = f"the convex program in cvxpy, gap {gap:.1e} by our own dual bound"
        return Found(status, x, claim, self.name, details=details)


METHODS = {"cvxpy": Cvxpy, "ipopt": Ipopt}
