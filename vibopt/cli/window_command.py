"""`vibopt window`: how far each variable may go, and a box of designs that all are permitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from vibopt.cli.options import Once, anew, as_json, changes, file, limited, read_job, scenario, with_scenario
from vibopt.cli.output import told

if TYPE_CHECKING:
    from vibopt.answer.console import Console
    from vibopt.study.permitted import Window
    from vibopt.study.spans import Span


@click.command(cls=Once)
@file
@limited
@anew
@changes
@scenario
@as_json
def window(file: str, changes: tuple[str, ...], scenario: str | None, as_json: bool) -> int:
    """Say how far each variable may go, and by how much all may be off at once around the best centre.

    The goal of the file does not matter, but for how far its own answer is from the limits.
    A file with tolerances is refused, as the box is one of tolerances itself: leave them out.
    """
    from vibopt.cli.progress import Bar
    from vibopt.study.window import window as permitted

    job = read_job(file, with_scenario(file, scenario, changes))
    with Bar() as bar:
        result = permitted(job, progress=bar)
    told(result, _list, as_json=as_json)
    return 0


def _list(result: Window, console: Console) -> None:
    from vibopt.answer.text import grid, paragraph
    from vibopt.study.permitted import percent

    alone = len(result.spans) == 1
    console.print(result.job.title, style="bold")
    rows = []
    for span in result.spans:
        box = " to ".join(end.shown for end in result.box(span.path))
        rows.append((span.path, _ends(span), box, result.centre[span.path].shown))
    ends = "Permitted" if len(result.spans) <= 2 else "Least and greatest"
    console.print(grid(rows, ("Variable", ends, "All at once", "Centre")))
    if result.part > 0.0:
        console.print()
        paragraph(console, f"{result.safe} around the centre is safe.", 0)
        how = "proven for every design within it" if result.proven else result.claim
        paragraph(console, f"Box: {how}.", 0)
    else:
        console.print("\nNo box was found: the permitted designs are too thin.")
    sound = all(span.proven for span in result.spans)
    proof = result.doubts or ("proven" if sound else "as far as was found; more may be permitted")
    if alone:
        what = f"Permitted: with exact ends, {proof}."
    else:
        proof = "no value outside is permitted, proven" if sound else proof
        lead, _, rest = result.said.partition(". ")
        what = f"{ends}: over all values of the others, {lead}; {proof}. {rest}."
    paragraph(console, what, 0)
    if result.around > 1e-4:
        console.print(f"Around the answer of the file ±{percent(result.around)} holds at the corners.")


def _ends(span: Span) -> str:
    parts = [f"{low.shown} to {high.shown}" for low, high in span.intervals]
    return "\n".join(parts) + (" and on" if span.opened else "")
