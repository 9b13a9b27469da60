"""What becomes of a machine when an absorber loses its damper, is locked, or comes off; and one absorber less."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isfinite

from vibopt.answer.blocks import SIDES, spoken, value_at
from vibopt.answer.entry import Checked, Entry
from vibopt.errors import InputError
from vibopt.records import dataclass
from vibopt.report.absorber_parts import BUILD, Part, has_absorbers, parts_of
from vibopt.report.adjust import Adjusting, adjusting
from vibopt.report.machine_words import THOROUGH, goal_words
from vibopt.responses import HarmonicResponse, RandomResponse
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.places import place_of
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.study.altered import Document, locked, lost, plain_document, undamped
from vibopt.study.freeze import frozen
from vibopt.verify.as_built import machine_of

PATIENCE = 2_000.0
"""Work of an answer [nominal ms] beyond which it is not designed anew without a damper or without an absorber."""
GOAL = "the_goal"
_ASKED = ("natural_frequency", "damping_ratio", "decay_rate")
_POPPED = ("minimise", "maximise")

NO_DAMPER, LOCKED, LOST = "no_damper", "locked", "lost"
NO_DAMPER_ANEW, LESS = "no_damper_anew", "left_out"
NOT_ASKED = "not computed"
_HEADS = {
    NO_DAMPER: "without its damper",
    LOCKED: "locked",
    LOST: "lost",
    NO_DAMPER_ANEW: "designed anew without its damper",
    LESS: "designed anew without it",
}


@dataclass(frozen=True, slots=True)
class Consequence:
    """What one change of one absorber does.

    what
        "no_damper", "locked", "lost": the design as built, measured again.  "no_damper_anew", "left_out": the
        scene answered again.
    status
        Of the machine or of the new answer.
    breaks
        Limits that no longer hold.
    goal
        The goal then; None where it is not a response, or where nothing is left of it.
    words
        All of it as one sentence.
    """

    absorber: str
    what: str
    status: str
    breaks: tuple[Checked, ...]
    goal: Entry | None
    words: str

    @property
    def head(self) -> str:
        """What has been done, in words: "tmd locked"."""
        return f"{self.absorber} {_HEADS[self.what]}"


@dataclass(frozen=True, slots=True)
class Absorbers:
    """All that a study says of the absorbers of a design."""

    parts: tuple[Part, ...]
    adjusting: tuple[Adjusting, ...]
    consequences: tuple[Consequence, ...]

    @property
    def blocks(self) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
        """Titles and rows, as they are printed."""
        made = (
            (BUILD, tuple((part.name, part.words) for part in self.parts)),
            (
                "How far each spring may be off",
                tuple((adjusting.absorber, adjusting.words) for adjusting in self.adjusting),
            ),
            (
                "What if",
                tuple((consequence.head, consequence.words) for consequence in self.consequences if consequence.words),
            ),
        )
        return tuple((title, rows) for title, rows in made if rows)


def study_absorbers(design: Design, *, thorough: bool = False) -> Absorbers | None:
    """What to build, how exactly, and what happens without it; None without absorbers or without a design."""
    if not has_absorbers(design) or design.status in ("unbounded", "check_failed"):
        return None
    return Absorbers(parts_of(design), adjusting(design), consequences(design, thorough=thorough))


def consequences(design: Design, *, thorough: bool = False) -> tuple[Consequence, ...]:
    """For each absorber: its damper left out, the absorber locked, lost; and answers without one or the other.

    Where answers anew would be much work the row says so, unless `thorough`.
    """
    scene = design.scene
    machine = machine_of(scene, design.scene.named(design.x))
    document = _measured(design)
    if document is None:
        return ()
    found = []
    for name in scene.absorbers:
        joint = machine.joint(name)
        damped = joint.stiffness > 0.0 and (joint.damping > 0.0 or joint.loss_factor > 0.0)
        if damped:
            found.append(_as_built(design, NO_DAMPER, name, undamped(document, name)))
        if damped:
            found.append(_anew(design, NO_DAMPER_ANEW, name, undamped, thorough))
        found.append(_as_built(design, LOCKED, name, locked(document, scene, machine, name, _top(scene))))
        found.append(_as_built(design, LOST, name, lost(document, name)))
        if _rests(design, name):
            found.append(_anew(design, LESS, name, lost, thorough))
    return tuple(consequence for consequence in found if consequence is not None)


def _rests(design: Design, name: str) -> bool:
    """Whether its mass is the least allowed."""
    masses = (f"absorbers.{name}.{word}" for word in ("mass", "mass_ratio", "inertia"))
    return any(path in design.variables and design.variables[path].at_bound == "from" for path in masses)


def _measured(design: Design) -> Document | None:
    """The design as an analysis, with the goal as a measure where it says something about any machine.

    None where nothing is left to be measured.
    """
    scene = design.scene
    document, given = dict(scene.document), scene.document.get("goal")
    if scene.goal is not None and isinstance(given, dict) and _tells(scene):
        table = {key: one for key, one in given.items() if key not in _POPPED}
        goal = {GOAL: {"response": scene.goal.response.response, **table}}
        document["measures"] = {**document.get("measures", {}), **goal}
    try:
        return plain_document(frozen(replace(scene, off={}, document=document), design.x, with_goal=False).document)
    except InputError:
        return None


def _tells(scene: Scene) -> bool:
    """Whether the goal is a response of the machine, and not a number of the design."""
    assert scene.goal is not None
    response = scene.goal.response
    return isinstance(response, (HarmonicResponse, RandomResponse)) or response.response in _ASKED


def _top(scene: Scene) -> float:
    """The highest frequency that a limit or a measure looks at [rad/s]."""
    asked = [one for one in (*scene.limits.values(), *scene.measures.values()) if isinstance(one, HarmonicResponse)]
    ends = [band.high for one in asked for name in names_for(scene, one) for band in bands_for(scene, one, name)]
    return max((end for end in ends if isfinite(end)), default=1e3)


def _answered(
    document: Document, name: str, known: Mapping[str, float] | None = None, method: str | None = None
) -> Design | None:
    """The answer, begun where values are known for all variables; None where what is left is no scene."""
    try:
        scene = from_dict(document, name=name)
        begun = [known[variable.path] for variable in scene.variables if variable.path in known] if known else []
        near = begun if begun and len(begun) == len(scene.variables) else None
        return solve(scene, explain=False, near=near, method=method if scene.variables else None)
    except InputError:
        return None


def _as_built(design: Design, what: str, name: str, document: Document) -> Consequence | None:
    other = _answered(document, design.scene.name)
    if other is None:
        return None
    breaks = tuple(limit for limit in other.limits.values() if not limit.met)
    goal = other.measures.get(GOAL)
    said = [_broken(checked) for checked in breaks] or (["every limit holds"] if other.limits else [])
    if goal is not None and design.goal is not None:
        assert design.scene.goal is not None
        response = design.scene.goal.response
        read = spoken(response.response, place_of(response))
        said.insert(0, f"{read} {value_at(goal)} instead of {design.goal[1].shown}")
    return Consequence(name, what, other.status, breaks, goal.value if goal is not None else None, "; ".join(said))


def _broken(checked: Checked) -> str:
    """A broken limit: "comfort breaks: 0.9413 m/s2 pk at 1.998 Hz, at most 0.2 m/s2 pk"."""
    allowed = f"{SIDES.get(checked.side, checked.side)} {checked.limit.shown}" if checked.limit is not None else ""
    return f"breaks {checked.name}: {value_at(checked)}, {allowed}"


def _anew(
    design: Design, what: str, name: str, alter: Callable[[Document, str], Document], thorough: bool
) -> Consequence | None:
    """The scene answered again after a change."""
    if design.goal is None:
        return None
    if design.work > PATIENCE and not thorough:
        return Consequence(name, what, NOT_ASKED, (), None, f"not computed: much work. {THOROUGH} does.")
    known = design.scene.named(design.x) if what == NO_DAMPER_ANEW else None
    method = design.method if design.method == "nlp" else None
    other = _answered(alter(plain_document(design.scene.document), name), design.scene.name, known, method)
    if other is None:
        return None
    goal = other.goal[1] if other.goal is not None else None
    now = f" instead of {design.goal[1].shown}" if goal is not None and design.goal is not None else ""
    said = goal_words(other) + now if goal is not None else _verdicts(other)
    if other.status == "feasible":
        said += ", not proven to be the best"
    if what == LESS:
        said = f"its mass rests on the least that is allowed; without it: {said}"
    breaks = tuple(limit for limit in other.limits.values() if not limit.met)
    return Consequence(name, what, other.status, breaks, goal, said)


def _verdicts(other: Design) -> str:
    broken = "; ".join(_broken(limit) for limit in other.limits.values() if not limit.met)
    return {
        "infeasible": "no design meets all limits",
        "unproven": "no design was found, and none was proven impossible",
        "met": "every limit holds",
        "optimal": "every limit holds",
        "feasible": "every limit holds",
        "violated": broken,
    }.get(other.status, other.status)
