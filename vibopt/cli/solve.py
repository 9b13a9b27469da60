"""`vibopt solve`: the answer with its evidence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from vibopt.cli.options import as_json, changes, file, method, read_job
from vibopt.cli.output import colour, complain, say, say_json, width

if TYPE_CHECKING:
    from vibopt.jobs import Answer, Job

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
    job = read_job(file, changes)
    found = answer(job, method)
    if not no_prices:
        found = with_prices(found)
    if as_json:
        say_json(plain_answer(found))
    else:
        say(text_of(found, job))
    if require_proof and not found.proven and found.exit_code == 0:
        if not as_json:
            complain(f"{found.status} is not proven, and --require-proof was asked for.")
        return UNPROVEN
    return found.exit_code


def answer(job: Job, method: str | None = None) -> Answer:
    """Solve, with a bar on standard error if it takes long."""
    from vibopt.cli.progress import Bar
    from vibopt.jobs import answer as answer_of

    with Bar() as bar:
        return answer_of(job, method=method, progress=bar)


def text_of(found: Answer, job: Job) -> str:
    """The answer for this terminal."""
    from vibopt.jobs import is_design

    if is_design(found):
        from vibopt.design.table import text_of as design_text

        return design_text(found, width=width(), colour=colour())
    from vibopt.balancing.table import text_of as balancing_text

    return balancing_text(found, job, width=width(), colour=colour())


def plain_answer(found: Answer) -> Any:
    """The answer as plain data."""
    from vibopt.jobs import is_design

    if is_design(found):
        from vibopt.design.jsonable import as_json as design_json

        return design_json(found)
    return found.to_json()


def with_prices(found: Answer) -> Answer:
    """The same answer with what loosening each active limit buys; a balancing answer has its prices already."""
    from vibopt.jobs import is_design

    if not is_design(found):
        return found
    from vibopt.study.prices import priced

    return priced(found)
