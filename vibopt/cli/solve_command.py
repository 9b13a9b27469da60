"""`vibopt solve`: the answer with its evidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.answer.answer import EMPTY, UNPROVEN, Answer
from vibopt.answer.text import text_of
from vibopt.cli.answer_cache import Asked
from vibopt.cli.options import (
    Once,
    anew,
    as_json,
    changes,
    fidelity,
    file,
    force,
    limited,
    method,
    read_job,
    rounding,
    scenario,
    with_scenario,
)
from vibopt.cli.output import colour, complain, note_kept, say, say_json, show, told, width
from vibopt.errors import InputError
from vibopt.work import metered, seconds_of_each_answer

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.jobs import Job
    from vibopt.study.fewest_planes import FewestPlanes
    from vibopt.study.for_all import OneForAll
    from vibopt.study.nearby import Rounded

PROBLEMS = (".toml",)


@click.command(cls=Once)
@file
@method
@limited
@anew
@fidelity
@changes
@scenario
@click.option("--all-scenarios", is_flag=True, help="One design that keeps every limit in every scenario of the file.")
@click.option("--fewest-planes", is_flag=True, help="Weigh as few planes of a measured rotor as keep its limits.")
@rounding
@click.option("--save", metavar="FILE", help="Write the design as a problem file of its own (.toml).")
@force
@click.option(
    "--save-coefficients",
    metavar="FILE",
    help="Write what each weight of a measured rotor does (.toml); the next job reads it as influence = FILE. Of a "
    "rotor of discs a whole balancing job, by its model.",
)
@click.option(
    "--no-prices",
    is_flag=True,
    help="Do not find out what loosening each active limit buys, nor the nearest design where none is found.",
)
@click.option("--require-proof", is_flag=True, help="Exit code 5 unless the answer is proven.")
@as_json
def solve(
    file: str,
    method: str | None,
    fidelity: str,
    changes: tuple[str, ...],
    scenario: str | None,
    all_scenarios: bool,
    fewest_planes: bool,
    rounding: tuple[str, ...],
    save: str | None,
    save_coefficients: str | None,
    force: bool,
    no_prices: bool,
    require_proof: bool,
    as_json: bool,
) -> int:
    """Find the best design of a problem file, check every limit by another road, and say what is proven.

    With --round the values are those on the drawing: measured anew, and what rounding costs.  With --save
    the design is a problem file of its own.

    Exit code: 0 optimal, feasible or met; 7 violated; 3 infeasible; 4 unbounded; 5 unproven; 6 check_failed.
    """
    if all_scenarios:
        others = scenario, method, fidelity == "full", save_coefficients, fewest_planes, no_prices, force and not save
        if any(others) or rounding:
            alone = "--all-scenarios goes with --set, --save, --time-limit, --json and --require-proof alone."
            raise InputError(f"{alone} Leave the other options out.")
        target = None if save is None else _target(save, None, force=force)
        return _for_all(read_job(file, changes), target, changes, as_json=as_json, require_proof=require_proof)
    from vibopt.jobs import is_scene

    changes = with_scenario(file, scenario, changes)
    job = read_job(file, changes)
    few = _fewest(job) if fewest_planes else None
    if few is not None:
        changes = (*changes, *(f"{path}=true" for path in few.changes))
        job = read_job(file, changes)
    _whole_where_asked(file, job, fidelity)
    target = None if save is None else _target(save, save_coefficients, force=force)
    modelled = save_coefficients if is_scene(job) and job.rotors else None
    learnt = {} if modelled is not None else _coefficients(job, save_coefficients, force=force)
    asked = Asked(file, job, changes, method, fidelity == "full")
    answer = answered(asked, fresh=True)
    drawn = _rounded(answer, job, rounding) if rounding else None
    answer = drawn.design if drawn is not None else _priced(asked, answer, no_prices=no_prices)
    if few is not None:
        answer = replace(answer, notes=(few.words, *answer.notes))
    if modelled is not None:
        learnt = _modelled(answer, modelled, force=force)
    refused = "" if target is None else _save(partial(_text, answer, job, drawn, target, changes), target)
    _write(learnt)
    written = [str(one) for one in (*((target,) if target is not None and not refused else ()), *learnt)]
    if as_json:
        more: dict[str, Any] = {"written": written} if written or refused else {}
        say_json({**answer.to_json(), **more, **({"messages": [refused]} if refused else {})})
    else:
        say(text_of(answer, width=width(), colour=colour(), file=file, changes=changes))
        _say(drawn, written, refused)
    if require_proof and not answer.proven and answer.exit_code == 0:
        if not as_json:
            complain(f"{answer.status} is not proven, and --require-proof was asked for.")
        return UNPROVEN
    return answer.exit_code


def _priced(asked: Asked, answer: Answer[Any], *, no_prices: bool) -> Answer[Any]:
    """The answer with what loosening a limit buys, or with the words that nothing was looked for."""
    if not no_prices:
        return answered(asked, fresh=True, prices=answer)
    if answer.status not in EMPTY or answer.nearest is not None:
        return answer
    words = "The nearest design was not looked for, nor what each limit could be alone: leave --no-prices out."
    return replace(answer, notes=(*answer.notes, words))


def _write(texts: dict[Path, str]) -> None:
    for place, text in texts.items():
        from vibopt.files.writing import write_file

        write_file(place, text.encode())


def _whole_where_asked(file: str, job: Job, fidelity: str) -> None:
    """Leave no freedom out until the command ends, where that is asked for."""
    from vibopt.jobs import is_scene, noun_of
    from vibopt.program.pose import whole_models

    if fidelity == "full":
        if not is_scene(job):
            raise InputError(
                f"{file}: --fidelity full is of machines, whose models leave freedoms out that nothing needs; "
                f"{noun_of(job)} has none. Leave it out."
            )
        click.get_current_context().with_resource(whole_models())


def _for_all(job: Job, target: Path | None, changes: tuple[str, ...], *, as_json: bool, require_proof: bool) -> int:
    """One design for all scenarios."""
    from vibopt.answer.answer import EXIT_CODES
    from vibopt.cli.progress import Bar
    from vibopt.study.scenarios import one_for_all

    with Bar() as bar:
        found = one_for_all(job, progress=bar)
    written, refused = None, ""
    if target is not None:
        from vibopt.study.saved import saved_for_all

        refused = _save(partial(saved_for_all, found, target, changes=changes), target)
        written = [] if refused else [str(target)]
    told(found, _tell_all, as_json=as_json, status=found.status, written=written, messages=[refused] if refused else [])
    code = EXIT_CODES[found.status]
    return UNPROVEN if require_proof and code == 0 and found.status != "optimal" else code


def _tell_all(found: OneForAll, console: Console) -> None:
    """Verdict, what is chosen, and every limit in every scenario."""
    from vibopt.answer.text import grid, paragraph, section

    console.print(found.job.title, style="bold")
    console.print(found.verdict)
    paragraph(console, f"{found.claim}. {found.reason}".rstrip(), 0)
    if found.variables:
        console.print(grid([(path, variable.shown) for path, variable in found.variables.items()]))
    names = list(dict.fromkeys(key for rows in found.limits.values() for key in rows))
    rows = [
        (name, *(f"{checked.value.shown} {checked.state}".strip() if (checked := held.get(name)) else "-"
                 for held in found.limits.values()))
        for name in names
    ]  # fmt: skip
    if rows:
        section(console, "Limits", grid(rows, ("", *found.limits)))


def _rounded(answer: Answer[Any], job: Job, rounding: tuple[str, ...]) -> Rounded | None:
    """The rounded design; None where there is no answer to be rounded, which the answer says itself."""
    from vibopt.cli.progress import Bar
    from vibopt.study.rounded_plan import drawn

    if answer.status in EMPTY:
        return None
    with Bar() as bar:
        bar("rounding", 0.0)
        return drawn(job, answer, rounding)


def _target(save: str, beside: str | None, *, force: bool) -> Path:
    """The place of the design, which that of coefficients would write over where they are one."""
    from vibopt.files.writing import checked_target, is_stream

    target = checked_target(save, PROBLEMS, force=force)
    if beside is not None and target.resolve() == Path(beside).resolve() and not is_stream(target):
        raise InputError(f"{save} is to hold the design and the coefficients: name two files.")
    return target


def _text(answer: Answer[Any], job: Job, drawn: Rounded | None, target: Path, changes: tuple[str, ...]) -> str:
    """The design as a file; InputError where there is none."""
    from vibopt.study.saved import saved_text

    return saved_text(job, answer, target, fixed=drawn.kept if drawn is not None else None, changes=changes)


def _save(design: Callable[[], str], target: Path) -> str:
    """Write the design; why not, where there is none."""
    try:
        text = design()
    except InputError as error:
        return str(error)
    from vibopt.files.writing import write_file

    write_file(target, text.encode())
    return ""


def _coefficients(job: Job, save: str | None, *, force: bool) -> dict[Path, str]:
    """The file of coefficients that is asked for, and its text."""
    if save is None:
        return {}
    from vibopt.balancing import is_rotor
    from vibopt.jobs import noun_of

    if not is_rotor(job):
        raise InputError(
            f"{job.name}: {noun_of(job)} has no influence coefficients: they are learnt from the runs of a measured "
            "rotor. Leave --save-coefficients out."
        )
    from vibopt.balancing.coefficients import coefficients_document

    words = f"Influence coefficients of {job.name}, saved by vibopt: read them as influence in the next job."
    return _learnt(words, coefficients_document(job), save, force=force)


def _modelled(design: Any, save: str, *, force: bool) -> dict[Path, str]:
    """The balancing job of a rotor of discs, and its text."""
    from vibopt.report.modelled_balancing import balancing_document

    words = f"What weights on the discs of {design.scene.name} do, by its model: a balancing job, made by vibopt."
    return _learnt(words, balancing_document(design), save, force=force)


def _learnt(words: str, document: Mapping[str, Any], save: str, *, force: bool) -> dict[Path, str]:
    """A document under its words as the text of a file."""
    from vibopt.document.toml_writing import document_toml
    from vibopt.files.marks import with_check
    from vibopt.files.writing import checked_target

    return {checked_target(save, PROBLEMS, force=force): with_check(f"# {words}\n\n{document_toml(document)}")}


def _say(drawn: Rounded | None, written: list[str], refused: str) -> None:
    """What was rounded and written."""
    if drawn is not None:
        show(lambda console: _rounding(drawn, console))
    for one in written:
        say(f"Written: {one}")
    if refused:
        complain(refused)


def _fewest(job: Job) -> FewestPlanes:
    """The fewest planes that keep every limit, with a bar on standard error if it takes long."""
    from vibopt.cli.progress import Bar
    from vibopt.study.fewest_planes import fewest_planes

    with Bar() as bar:
        return fewest_planes(job, bar)


def _rounding(drawn: Rounded, console: Console) -> None:
    """Exact values beside those on the drawing, and the goal of both."""
    from vibopt.answer.text import grid, section

    rows = [
        (path.removesuffix(".value"), value.exact.shown, value.rounded.shown) for path, value in drawn.values.items()
    ]
    exact, now = drawn.exact.goal, drawn.design.goal
    if exact is not None and now is not None:
        rows.append((f"goal: {exact[0]}", exact[1].shown, now[1].shown))
    section(console, "Rounding", grid(rows, ("", "Exact", "Rounded")))


def answered(asked: Asked, *, fresh: bool, prices: Answer[Any] | bool = False) -> Answer[Any]:
    """The answer to a file: the last one to the same content, or solved anew and kept.

    Parameters
    ----------
    asked
        The file as it was read.
    fresh
        Solve, whatever is kept.
    prices
        Whether what loosening each limit buys is wanted too, or where there is no design the nearest; or the answer to
        which it is to be added.
    """
    from vibopt.cli.answer_cache import keep, kept

    stage = "answer" if prices is False else "prices"
    timed = seconds_of_each_answer() is not None  # what a clock may end is not kept
    last = kept(asked, stage) if not fresh and not timed else None
    if last is not None:
        return last
    before = [] if timed else asked.stamps()
    with metered() as meter:
        if stage == "answer":
            answer = _answer(asked)
        else:
            answer = _beside(answered(asked, fresh=fresh) if isinstance(prices, bool) else prices)
    keep(asked, stage, answer, before, meter.done)
    return answer


def _answer(asked: Asked) -> Answer[Any]:
    """Solve, with a bar on standard error if it takes long."""
    from vibopt.cli.progress import Bar
    from vibopt.jobs import answer

    note_kept("Nothing was written: with --time-limit SECONDS a search ends by itself, with the best it has found.")
    with Bar() as bar:
        found = answer(asked.job, method=asked.method, progress=bar)
    note_kept("")
    return found


def _beside(answer: Answer[Any]) -> Answer[Any]:
    """The answer with what its limits cost, or with the design that comes nearest."""
    from vibopt.cli.progress import Bar
    from vibopt.jobs import is_scene

    with Bar() as bar:
        if answer.status in EMPTY and is_scene(answer.job):
            from vibopt.study.nearest import with_nearest

            bar("the design that comes nearest", 0.0)
            answer = with_nearest(answer)
        if answer.goal is not None:
            from vibopt.study.prices import priced

            bar("what loosening a limit buys", 0.0)
            answer = priced(answer)
    return answer
