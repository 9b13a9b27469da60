"""`vibopt solve`: the answer with its evidence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from vibopt.cli.options import as_json, changes, file, method, read_scene
from vibopt.cli.output import colour, complain, say, say_json, width

if TYPE_CHECKING:
    from vibopt.design.design import Design
    from vibopt.scene.scene import Scene

UNPROVEN = 5


@click.command()
@file
@method
@changes
@click.option("--no-prices", is_flag=True, help="Do not find out what loosening each active limit buys.")
@click.option("--require-proof", is_flag=True, help="Exit code 5 unless the answer is proven.")
@as_json
def solve(
    file: str, method: str | None, changes: tuple[str, ...], no_prices: bool, require_proof: bool, as_json: bool
) -> int:
    """Find the best design of a problem file, check every limit by another road, and say what is proven.

    Exit code: 0 optimal, feasible or met; 7 violated; 3 infeasible; 4 unbounded; 5 unproven; 6 check_failed.
    """
    from vibopt.design.table import text_of

    design = answer(read_scene(file, changes), method)
    if not no_prices:
        design = with_prices(design)
    if as_json:
        say_json(design)
    else:
        say(text_of(design, width=width(), colour=colour()))
    if require_proof and not design.proven and design.exit_code == 0:
        if not as_json:
            complain(f"{design.status} is not proven, and --require-proof was asked for.")
        return UNPROVEN
    return design.exit_code


def answer(scene: Scene, method: str | None = None) -> Design:
    """Solve, with a bar on standard error if it takes long."""
    from vibopt.cli.progress import Bar
    from vibopt.solve import solve as solve_scene

    with Bar() as bar:
        return solve_scene(scene, method=method, progress=bar)


def with_prices(design: Design) -> Design:
    """The same answer with what loosening each active limit buys."""
    from vibopt.study.prices import priced

    return priced(design)
