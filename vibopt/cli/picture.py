"""`vibopt plot` and `vibopt report`: the answer as a picture, and as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from vibopt.cli.options import as_json, changes, file, method, read_job
from vibopt.cli.output import checked_target, say, say_json, write_file
from vibopt.errors import InputError

if TYPE_CHECKING:
    from vibopt.design.design import Design
    from vibopt.jobs import Answer, Job

FORMATS = (".svg", ".png", ".pdf")
PAGES = (".html", ".htm")


@click.command()
@file
@click.option("-o", "--output", metavar="FILE", required=True, help="Picture to write: .svg, .png or .pdf.")
@click.option("--map", "as_map", is_flag=True, help="Draw the plane of the two design variables instead.")
@method
@changes
@as_json
def plot(file: str, output: str, as_map: bool, method: str | None, changes: tuple[str, ...], as_json: bool) -> int:
    """Draw the responses of the answer against speed, with forbidden zones and worst points.

    Of a balancing job: where each weight goes, readings before and after, bars of what is left.

    Exit code: that of the answer.
    """
    from vibopt.cli.solve import answer

    target = checked_target(output, FORMATS)
    job = read_job(file, changes)
    found = answer(job, method)
    write_file(target, _drawn(found, job, as_map, target.suffix[1:].lower()))
    return _done(found, target, as_json)


def _drawn(found: Answer, job: Job, as_map: bool, form: str) -> bytes:
    from vibopt.jobs import is_design

    if is_design(found):
        return _picture(found, as_map, form)
    if as_map:
        raise InputError(f"{job.name}: --map is not supported for balancing jobs yet. Leave it out.")
    from vibopt.balancing.figures import figure_of
    from vibopt.design.figures import saved

    figure = figure_of(found, job)
    if figure is None:
        raise InputError(f"{job.name}: there is nothing to draw: there is no plan ({found.status}).")
    return saved(figure, form)


def _picture(design: Design, as_map: bool, form: str) -> bytes:
    from vibopt.design.curves import panels
    from vibopt.design.figures import plane_figure, response_figure, saved
    from vibopt.design.plane import plane

    name = design.scene.name
    if as_map:
        drawn = plane(design)
        if drawn is None:
            raise InputError(f"{name}: a map needs exactly two variables that are not whole or listed.")
        return saved(plane_figure(drawn), form)
    found = panels(design)
    if found:
        return saved(response_figure(found, design.scene.title), form)
    drawn = plane(design)
    if drawn is not None:
        return saved(plane_figure(drawn), form)
    without = bool(design.scene.variables) and not design.x
    why = f"there is no design ({design.status})" if without else "nothing depends on a speed"
    raise InputError(f"{name}: there is nothing to draw: {why}.")


@click.command()
@file
@click.option("-o", "--output", metavar="FILE", required=True, help="Page to write (.html).")
@method
@changes
@as_json
def report(file: str, output: str, method: str | None, changes: tuple[str, ...], as_json: bool) -> int:
    """Write the answer as one page that can be printed and signed (one HTML file, nothing outside it).

    Exit code: that of the answer.
    """
    from vibopt.cli.solve import answer, with_prices

    target = checked_target(output, PAGES)
    job = read_job(file, changes)
    found = with_prices(answer(job, method))
    write_file(target, _page(found, job, changes).encode())
    return _done(found, target, as_json)


def _page(found: Answer, job: Job, changes: tuple[str, ...]) -> str:
    from vibopt.jobs import is_design

    if is_design(found):
        from vibopt.design.report import html

        return html(found, changes=changes)
    from vibopt.balancing.sheet import html as sheet

    return sheet(found, job, changes=changes)


def _done(found: Answer, target: Path, as_json: bool) -> int:
    """Say what was written, and what it says."""
    from vibopt.cli.solve import plain_answer

    if as_json:
        say_json({**plain_answer(found), "written": [str(target)]})
    else:
        say(f"{_verdict(found)}\nWritten: {target}")
    return found.exit_code


def _verdict(found: Answer) -> str:
    from vibopt.jobs import is_design

    if is_design(found):
        from vibopt.design.words import verdict

        return verdict(found)
    from vibopt.balancing.blocks import verdict as balancing_verdict

    return balancing_verdict(found)
