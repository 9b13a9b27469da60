"""`vibopt new`: a commented problem file to fill in."""

from __future__ import annotations

from pathlib import Path

import click

from vibopt.cli.options import Once, as_json, force
from vibopt.cli.output import say, say_json
from vibopt.errors import InputError, way_out
from vibopt.files.writing import checked_target, write_file

KINDS = {"balance": "balance.toml"}
"""Kinds of file, and the file written where none is named."""


@click.command(cls=Once)
@click.argument("kind", metavar="balance")
@click.option("-o", "--output", metavar="FILE", help='File to write; "-" for standard output. Without it balance.toml.')
@force
@as_json
def new(kind: str, output: str | None, force: bool, as_json: bool) -> int:
    """Write a commented two-plane balancing job, with numbers in it, to be filled in.

    A file that is there already is not touched without --force.
    """
    if kind not in KINDS:
        raise InputError(f'there is no file of the kind "{kind}".{way_out(kind, KINDS)}')
    text = _TEMPLATES.joinpath(f"{kind}.toml").read_text(encoding="utf-8")
    if output == "-":
        say_json({"status": "ok", "text": text}) if as_json else say(text)
        return 0
    target = checked_target(output or KINDS[kind], (".toml",), force=True)
    if target.exists() and not force:
        raise InputError(f"{target} is there already and stays as it is. Name another file with -o, or add --force.")
    write_file(target, text.encode())
    if as_json:
        say_json({"status": "ok", "written": [str(target)]})
    else:
        say(f"Written: {target}\nFill it in, then: vibopt solve {target}")
    return 0


_TEMPLATES = Path(__file__).with_name("templates")
