"""`vibopt explain`: the reasons behind an answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from vibopt.cli.options import Once, anew, as_json, changes, file, limited, method, read_job, workers
from vibopt.cli.output import told

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.study.explain import Explanation


@click.command(cls=Once)
@file
@method
@limited
@anew
@changes
@click.option("--thorough", is_flag=True, help="Compute all that can be said, whatever the work.")
@workers
@as_json
def explain(
    file: str, method: str | None, changes: tuple[str, ...], thorough: bool, workers: int, as_json: bool
) -> int:
    """Say why this model and this method, which limits are active, and what each costs.

    Exit code: that of the answer.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.explain import explain as explained
    from vibopt.study.sweep import pool_of

    job = read_job(file, changes)
    with Bar() as bar, pool_of(workers) as pool:
        result = explained(job, method=method, progress=bar, thorough=thorough, pool=pool)
    told(result, _tell, as_json=as_json, status=result.answer.status)
    return result.answer.exit_code


def _tell(result: Explanation, console: Console) -> None:
    from vibopt.answer.text import claim, grid, paragraph, section, show, verdict
    from vibopt.answer.views import views_of

    answer = result.answer
    console.print(answer.title, style="bold")
    console.print(verdict(answer))
    for text in (claim(answer), answer.reason):
        if text:
            paragraph(console, text)
    section(console, "Model", grid([(said.name, said.words) for said in result.model], whole=(0,)))
    methods = [(method.name, f"{method.verb}: {method.why}") for method in result.methods]
    section(console, "Method", grid(methods, whole=(0,)))
    if result.limits:
        section(console, "Limits", grid([(limit.name, limit.words) for limit in result.limits], whole=(0,)))
    if result.prices is not None and result.prices.now is not None and result.prices.rows:
        paragraph(console, f"{result.prices.first} What each fact buys: vibopt whatif FILE.")
    if result.absorbers is not None:
        for title, rows in result.absorbers.blocks:
            section(console, title, grid(rows, whole=(0,)))
    if answer.conflict is not None and not answer.reason:
        section(console, "Cannot hold together", ", ".join(answer.conflict.limits))
    for block in views_of(answer).nearest_blocks(answer):
        show(block, console)
    if answer.notes:
        section(console, "Notes", grid([(note,) for note in answer.notes]))
    work = [(key, str(value)) for key, value in answer.details.items() if isinstance(value, int)]
    if work:
        section(console, "Work done", grid(work, whole=(0,)))
