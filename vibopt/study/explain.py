"""Why this model, why this method, which limits are active and what each costs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Checked
from vibopt.answer.tabular import Tabular
from vibopt.errors import counted
from vibopt.jobs import answer, balanced, is_scene, method_of, reasons
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.program.told import percent
from vibopt.records import dataclass
from vibopt.report.machine_words import model_words
from vibopt.scene.scene import Design
from vibopt.scene.uncertain import likely
from vibopt.solve import solve
from vibopt.solve.by_name import METHODS, OWN
from vibopt.solve.global_search import provable
from vibopt.solve.method import Progress
from vibopt.solve.nlp import blind
from vibopt.solve.odds import DRAWN
from vibopt.solve.ranges import closed
from vibopt.study.absorbers import Absorbers, study_absorbers
from vibopt.study.nearest import with_nearest
from vibopt.study.price_words import range_words
from vibopt.study.prices import Prices, priced, prices_of_limits, with_prices

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing import BalancingJob
    from vibopt.jobs import Job
    from vibopt.study.workers import Pool


@dataclass(frozen=True, slots=True)
class Considered:
    """A method in the order in which vibopt asks them: whether it answered, and why or why not.

    able
        Whether it takes the question, which another answered.
    """

    name: str
    chosen: bool
    why: str
    able: bool = False

    @property
    def verb(self) -> str:
        """In a sentence about it."""
        return "answers" if self.chosen else "could" if self.able else "cannot"


@dataclass(frozen=True, slots=True)
class Said:
    """A name and what is to be said of it."""

    name: str
    words: str


@dataclass(frozen=True)
class Explanation(Tabular):
    """The answer with its reasons.

    answer
        With prices.
    model
        What of the model each question needs; the first entry speaks of the whole.
    methods
        Methods considered.
    limits
        What each limit does to the design.
    absorbers
        What to build, how exactly, and what happens without it; None where there are none.
    prices
        What each limit and cap buys or costs, both ways; None where there is none, or no goal to count in.
    """

    answer: Answer[Any]
    model: tuple[Said, ...]
    methods: tuple[Considered, ...]
    limits: tuple[Said, ...]
    absorbers: Absorbers | None = None
    prices: Prices | None = None

    def table(self) -> list[dict[str, Any]]:
        """A row for each reason: of the model, of each method considered, of each limit."""
        model = [{"of": "model", "name": said.name, "chosen": None, "words": said.words} for said in self.model]
        methods = [
            {"of": "method", "name": method.name, "chosen": method.chosen, "words": method.why}
            for method in self.methods
        ]
        limits = [{"of": "limit", "name": limit.name, "chosen": None, "words": limit.words} for limit in self.limits]
        return [*model, *methods, *limits]

    def as_said(self) -> dict[str, Any]:
        """The reasons, what else is known, and the answer."""
        said = {name: getattr(self, name) for name in ("model", "methods", "limits", "absorbers", "prices")}
        return {**{name: one for name, one in said.items() if one is not None}, "design": self.answer}

    def heading(self) -> tuple[str, ...]:
        """That of the answer."""
        return self.answer.heading()


def explain(
    job: Job,
    *,
    method: str | None = None,
    progress: Progress | None = None,
    thorough: bool = False,
    pool: Pool | None = None,
) -> Explanation:
    """Answer a job and say why the answer is what it is.

    Parameters
    ----------
    job
        A scene or a balancing job without mistakes.
    method
        Name of a method to force; None lets vibopt choose.
    progress
        Called with a stage and the part that is done.
    thorough
        Compute all that can be said, whatever the work.
    pool
        Those who answer what limits cost; the answers do not depend on them.
    """
    if not is_scene(job):
        return _balancing(job, method, thorough, pool)
    design = solve(job, method=method_of(job, method), progress=progress, thorough=thorough)
    design = with_nearest(design, thorough=thorough)
    design, every = _priced(design, thorough, pool)
    if likely(design.scene):
        note = "No price is told: a limit asks for a probability, and what a step buys of it is the luck of the draw."
        design = replace(design, notes=(*design.notes, note))
    program = pose(design.scene)
    return Explanation(
        design,
        tuple(_model(design, program)),
        tuple(_methods(design, program, method)),
        tuple(
            Said(name, f"{_limit(design, name)}{_ranged(every, limit.name)}") for name, limit in design.limits.items()
        ),
        study_absorbers(design, thorough=thorough),
        every,
    )


def _balancing(job: BalancingJob, method: str | None, thorough: bool, pool: Pool | None) -> Explanation:
    """What a balancing job is modelled by, the methods it could have, and what its limits cost."""
    found = balanced(job, thorough=thorough) if method is None else answer(job, method=method)
    found, every = _priced(found, thorough, pool)
    limits = tuple(Said(name, f"{_row(limit)}{_ranged(every, name)}") for name, limit in found.limits.items())
    caps = tuple(Said(path, f"ACTIVE, {price.words}{_ranged(every, path)}") for path, price in found.prices.items())
    model, methods = reasons(job, found)
    said, considered = tuple(Said(*one) for one in model), tuple(Considered(*one) for one in methods)
    if method is not None:
        considered = (Considered(method, True, f"asked for by --method {method}"),)
    return Explanation(found, said, considered, (*limits, *caps), None, every)


def _priced(answer: Answer[Any], thorough: bool, pool: Pool | None) -> tuple[Answer[Any], Prices | None]:
    """An answer with what limits and caps buy, and the table of it where there is one."""
    every = prices_of_limits(answer, thorough=thorough, pool=pool)
    return (priced(answer), None) if every is None else (with_prices(answer, every), every)


def _ranged(every: Prices | None, name: str) -> str:
    """How far the price of a limit, or a cap, goes on: behind what is said of it already."""
    rows = [] if every is None else [row for row in every.rows if name in (row.name, row.path.rpartition(".")[0])]
    known = [
        range_words(row.now, row.ways, gain=False)
        for row in rows
        if row.ranged and row.path.rpartition(".")[2] != "from"
    ]
    return "".join(f"; {words}" for words in known if words)


def _row(checked: Checked) -> str:
    """What a limit of a balancing job does to its answer."""
    if not checked.met:
        return "BROKEN"
    price = f", {checked.price.words}" if checked.price is not None and checked.price.words else ""
    return f"ACTIVE{price}" if checked.active else f"{checked.margin_shown or 'room'} to spare{price}"


def _model(design: Design, program: Program) -> list[Said]:
    """The whole, then each limit that needs less of it."""
    said = [Said("scene", model_words(design))]
    for limit in program.limits:
        if limit.form.powers is not None:
            said.append(Said(limit.name, "a property of the machine, needs no motion"))
        elif program.model.n_free > 1:
            count = limit.model.n_free
            said.append(Said(limit.name, f"needs {counted(count, 'degrees of freedom')}"))
    return list(dict.fromkeys(said))


def _methods(design: Design, program: Program, forced: str | None) -> list[Considered]:
    if design.scene.find_all is not None:
        return [Considered(design.method, True, "the ends of each interval are roots of response = bound")]
    if design.scene.is_analysis:
        return [Considered(design.method, True, "nothing to choose: each response is measured over its whole range")]
    if forced is not None:
        return [Considered(design.method, True, f"asked for by --method {forced}")]
    if design.method == "physical bound":
        return [Considered(design.method, True, "a balance of forces settles it, whatever the mount")]
    finite = replace(closed(program), several=design.tolerances is not None)
    if finite.ties and finite.ranged is not None:
        return [Considered(design.method, True, f"parts of a catalogue stand beside {finite.ranged.path}, a range")]
    if finite.ties:
        return [Considered("catalogue", True, "parts of a catalogue are chosen row by row, by this method alone")]
    considered = []
    for name in OWN:  # as vibopt asks them, the one that proves most first
        method = METHODS[name]()
        refusal = method.refuses(finite)
        if refusal is None and method.name == "branch_and_bound" and blind(finite) and design.method != method.name:
            loose = next(part for part in finite.parts if not part.form.sampleable(part.model))
            refusal = (
                f"few boxes leave {loose.name} open." if provable(finite) else f"{loose.name} {loose.form.no_bounds}."
            )
        answers = refusal is None and design.method in (method.name, DRAWN)
        if refusal is not None or answers:
            considered.append(Considered(method.name, answers, refusal or method.summary))
        else:
            considered.append(Considered(method.name, False, f"the answer is that of {design.method}.", able=True))
        if refusal is None:
            break
    if design.method == DRAWN:
        considered.append(Considered(DRAWN, True, "asks that method about the machines at the edge of each share"))
    elif not considered[-1].chosen:
        own = METHODS.get(design.method)
        considered.append(Considered(design.method, True, design.claim if own is None else own().summary))
    return considered


def _limit(design: Design, name: str) -> str:
    checked = design.limits[name]
    if design.found is not None:
        return "separates good speeds from bad ones"
    if not checked.met:
        return "BROKEN"
    odds = design.tolerances.odds.get(name) if design.tolerances is not None else None
    if odds is not None:
        least = odds.least if odds.counted else f"{odds.least} at least"
        return f"asked of {percent(odds.wanted)} of all machines; {least} keep it"
    if checked.active:
        return f"ACTIVE, {checked.price.words}" if checked.price is not None else "ACTIVE"
    spare = f"{checked.margin_shown or 'room'} to spare"
    stepped = any(variable.values is not None for variable in design.scene.variables)
    return spare if stepped else f"{spare}: does not hold the design back"
