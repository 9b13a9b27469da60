"""`vibopt plot` and `vibopt report`: the answer as a picture, and as a page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.cli.answer_cache import Asked
from vibopt.cli.options import Once, as_json, changes, file, force, fresh, limited, method, read_job, rounding
from vibopt.cli.output import say, say_json
from vibopt.errors import InputError
from vibopt.files.writing import checked_target, format_of, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.jobs import Job
    from vibopt.scene.scene import Design

FORMATS = (".svg", ".png", ".pdf")
PAGES = (".html", ".htm")
_ABSORBERS, _ALL = "absorbers.", "all"


class _Plot(Once):
    """`--map` may stand alone or before the name of an absorber."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, list(_map_of(args)))


def _map_of(args: list[str]) -> Iterator[str]:
    left = iter(args)
    for one in left:
        if one != "--map":
            yield one
            continue
        after = next(left, None)
        named = after is not None and after.startswith(_ABSORBERS)
        yield f"--map={after}" if named else f"--map={_ALL}"
        if after is not None and not named:
            yield from _map_of([after])


@click.command(cls=_Plot)
@file
@click.option("-o", "--output", metavar="FILE", required=True, help="Picture to write: .svg, .png or .pdf.")
@click.option(
    "--map",
    "as_map",
    metavar="[absorbers.NAME]",
    help="Draw the plane of the two design variables instead, or of tuning and damping of one absorber.",
)
@click.option("--sketch", is_flag=True, help="Draw the machine instead: what stands on what, what shakes it.")
@click.option(
    "--spectrum", is_flag=True, help="Draw the shock spectrum of what comes once instead, and the machine in it."
)
@click.option("--campbell", is_flag=True, help="Draw the Campbell diagram of rotors: whirls against the spin.")
@method
@limited
@changes
@fresh
@force
@as_json
def plot(
    file: str,
    output: str,
    as_map: str | None,
    sketch: bool,
    spectrum: bool,
    campbell: bool,
    method: str | None,
    changes: tuple[str, ...],
    fresh: bool,
    force: bool,
    as_json: bool,
) -> int:
    """Draw the responses of the answer against speed, with forbidden zones and worst points; or the machine.

    With absorbers also without them, and the stroke of each and the natural frequencies.

    Of a balancing job: where each weight goes, readings before and after, bars of what is left.

    Exit code: that of the answer.
    """
    from vibopt.cli.solve_command import answered
    from vibopt.report.figures import saved

    if sketch and as_map is not None:
        raise InputError("--sketch draws the machine and --map two of its numbers: leave one of them out.")
    if spectrum and (sketch or as_map is not None):
        raise InputError("--spectrum draws the load and --sketch or --map the machine: leave one of them out.")
    if campbell and (sketch or spectrum or as_map is not None):
        raise InputError("--campbell draws whirls against the spin: leave --sketch, --spectrum and --map out.")
    job = read_job(file, changes)
    target = checked_target(output, FORMATS, force=force)
    asked = "campbell" if campbell else "spectrum" if spectrum else "sketch" if sketch else ""
    as_map = _can_be_drawn(job, asked, as_map)
    answer = answered(Asked(file, job, changes, method), fresh=fresh)
    figure = _asked_for(answer, asked) if asked else _drawn(answer, as_map)
    write_file(target, saved(figure, format_of(target, FORMATS)))
    return _done(answer, target, as_json)


_OF_MACHINES = {
    "sketch": "--sketch draws machines; here the plot has the shaft in it. Leave --sketch out.",
    "spectrum": "--spectrum is of a load that comes once on a machine. Leave --spectrum out.",
    "campbell": "--campbell is of rotors that are modelled, [rotors.NAME]. Leave it out.",
}
"""Pictures that are asked for by name, and what is said where there is no machine."""


def _can_be_drawn(job: Job, picture: str, as_map: str | None) -> str | None:
    """The absorber of which a map is asked for, "" for a map of the whole; refused before anything is solved."""
    from vibopt.jobs import is_scene, noun_of

    if is_scene(job):
        from vibopt.report.design_plane import axes_asked

        if picture == "campbell" and not job.rotors:
            raise InputError(f"{job.name}: {_OF_MACHINES[picture]}")
        return None if as_map is None else axes_asked(job, "" if as_map == _ALL else as_map.removeprefix(_ABSORBERS))
    if picture:
        raise InputError(f"{job.name}: {_OF_MACHINES[picture]}")
    if as_map is not None:
        raise InputError(
            f"{job.name}: a map has two numbers of a machine as its axes, and weights of {noun_of(job)} have "
            "each a size and an angle, as the plot shows them. Leave --map out."
        )
    return None


def _asked_for(answer: Answer[Any], picture: str) -> Figure:
    """The machine, what a load does to any mount, or the whirls of rotors against the spin."""
    from vibopt.report.figures import response_figure

    if picture == "spectrum":
        from vibopt.report.spectrum_views import spectrum_asked

        return response_figure(spectrum_asked(answer), answer.title)
    if picture == "campbell":
        from vibopt.report.campbell import campbell_of
        from vibopt.report.figures.campbell_diagram import campbell_figure

        return campbell_figure(campbell_of(answer), answer.title)
    from vibopt.report.space_views import machine_figure

    figure = machine_figure(answer, answer.title)
    if figure is None:
        lone = "there is nothing but single bodies, or too many"
        why = lone if answer.x else "no places are known without a design"
        raise InputError(f"{answer.name}: there is no sketch: {why}.")
    return figure


def _drawn(answer: Answer[Any], as_map: str | None) -> Figure:
    from vibopt.jobs import is_scene

    if is_scene(answer.job):
        return _picture(answer, as_map)
    from vibopt.balancing.figures import figure_of

    figure = figure_of(answer)
    if figure is None:
        raise InputError(f"{answer.name}: there is nothing to draw: there is no plan ({answer.status}).")
    return figure


def _picture(design: Design, as_map: str | None) -> Figure:
    from vibopt.report.curves import panels
    from vibopt.report.design_plane import plane
    from vibopt.report.figures import below, plane_figure, response_figure

    name = design.scene.name
    if as_map is not None:
        drawn = plane(design, as_map)
        if drawn is None:
            raise InputError(f"{name}: a map of {as_map} needs a design, and there is none ({design.status}).")
        return plane_figure(drawn)
    found, under = panels(design), below(design)
    if found or under:
        return response_figure(found, design.scene.title, under)
    drawn = plane(design)
    if drawn is not None:
        return plane_figure(drawn)
    if design.found is not None and design.scene.variables:
        (variable,) = design.scene.variables
        ends = "..".join(Entry(end, variable.dimension, variable.unit).shown for end in (variable.low, variable.high))
        raise InputError(
            f"{name}: find_all answers with values of {variable.path}, and curves are of one machine. Draw its limits "
            f'over them: vibopt sweep {name} --vary {variable.path}="{ends}" --figure sweep.svg'
        )
    without = bool(design.scene.variables) and not design.x
    why = f"there is no design ({design.status})" if without else "nothing depends on a speed"
    if any(row.unsteady for row in (*design.limits.values(), *design.measures.values())):
        why = "a whirl grows without end, and nothing that is asked has a steady motion"
    raise InputError(f"{name}: there is nothing to draw: {why}.")


@click.command(cls=Once)
@file
@click.option("-o", "--output", metavar="FILE", required=True, help="Page to write: .html or .pdf.")
@click.option(
    "--sheet",
    is_flag=True,
    help="One printed page to sign: machine, mounts and loads, natural frequencies, every limit; or what to fit.",
)
@click.option("--paper", type=click.Choice(("A4", "letter"), case_sensitive=False), default="A4", help="Paper (A4).")
@method
@limited
@changes
@rounding
@fresh
@force
@as_json
def report(
    file: str,
    output: str,
    sheet: bool,
    paper: str,
    method: str | None,
    changes: tuple[str, ...],
    rounding: tuple[str, ...],
    fresh: bool,
    force: bool,
    as_json: bool,
) -> int:
    """Write the answer as a page that can be printed and signed (one HTML file, nothing outside it; or a PDF).

    With --sheet it is one page to sign: a machine on its mounts, or what to do with a rotor, a shaft or an
    engine, with room for what is then measured; with --round its values are those on the drawing.

    Exit code: that of the answer.
    """
    from vibopt.cli.solve_command import answered

    if rounding and not sheet:
        raise InputError("--round goes with --sheet: the report has the exact values. Add --sheet, or leave it out.")
    job = read_job(file, changes)
    target = checked_target(output, (*PAGES, ".pdf"), force=force)
    program = _browser(job, target, sheet)
    asked = Asked(file, job, changes, method)
    if sheet:
        answer = _for_a_sheet(asked, rounding, fresh=fresh)
        page = _sheet(asked, answer, program, target, paper)
    else:
        answer = answered(asked, fresh=fresh, prices=True)
        page = _paged(_page(answer, changes, paper), program, target)
    write_file(target, page)
    return _done(answer, target, as_json)


def _browser(job: Job, target: Path, sheet: bool) -> str:
    """What prints a PDF, "" of a page of HTML; what cannot be printed is refused before anything is solved."""
    from vibopt.jobs import is_scene
    from vibopt.report.sheet import asks_for_one_design, browser

    if sheet and is_scene(job):
        asks_for_one_design(job)
    return browser(str(target)) if target.suffix.lower() == ".pdf" else ""


def _for_a_sheet(asked: Asked, rounding: tuple[str, ...], *, fresh: bool) -> Answer[Any]:
    """What is signed: with the values of the drawing where they are rounded."""
    from vibopt.answer.answer import EMPTY
    from vibopt.cli.solve_command import answered

    answer = answered(asked, fresh=fresh)
    if answer.status in EMPTY:
        answer = answered(asked, fresh=fresh, prices=answer)
    if rounding and answer.status not in EMPTY:
        from vibopt.study.rounded_plan import drawn

        answer = drawn(asked.job, answer, rounding).design
    return answer


def _paged(page: str, program: str, target: Path) -> bytes:
    from vibopt.report.sheet import pdf

    return pdf(page, program, str(target)) if program else page.encode()


def _sheet(asked: Asked, answer: Answer[Any], program: str, target: Path, paper: str) -> bytes:
    """The sheet of a machine on its mounts, or what to do with a rotor, a shaft or an engine for the shop floor."""
    from vibopt.answer.answer_page import html as page_of
    from vibopt.jobs import is_scene
    from vibopt.report.sheet import digests_of, html, printed

    digests = digests_of(asked.file, answer.job)
    if not is_scene(answer.job):
        page = page_of(answer, changes=asked.changes, digests=digests, sheet=True, paper=paper)
        return _paged(page, program, target)
    if program:
        return printed(answer, program, str(target), digests=digests, changes=asked.changes, paper=paper)
    return html(answer, digests=digests, changes=asked.changes, paper=paper).encode()


def _page(answer: Answer[Any], changes: tuple[str, ...], paper: str) -> str:
    from vibopt.answer.answer_page import html
    from vibopt.jobs import is_scene

    if not is_scene(answer.job):
        return html(answer, changes=changes, paper=paper)
    from vibopt.study.absorbers import study_absorbers

    studied = study_absorbers(answer)
    return html(answer, changes=changes, also=None if studied is None else studied.blocks, paper=paper)


def _done(answer: Answer[Any], target: Path, as_json: bool) -> int:
    """Say what was written, and what it says."""
    from vibopt.answer.text import verdict

    if as_json:
        say_json({**answer.to_json(), "written": [str(target)]})
    else:
        say(f"{verdict(answer)}\nWritten: {target}")
    return answer.exit_code
