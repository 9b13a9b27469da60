"""`vibopt new`: a problem file to fill in, or to go on from."""

from __future__ import annotations

from pathlib import Path

import click

from vibopt.cli.options import Once, as_json, force
from vibopt.cli.output import say, say_json
from vibopt.document.ross_file import ross_document
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError, way_out
from vibopt.files.writing import checked_target, write_file
from vibopt.scene.read import from_dict

KINDS = {"balance": "balance.toml", "rotor": "rotor.toml"}
"""Kinds of file, and the file written where none is named."""


@click.command(cls=Once)
@click.argument("kind", metavar="balance|rotor")
@click.option("--ross", metavar="FILE", help="Of a rotor: the file that ROSS saved it in, .toml or .json.")
@click.option("-o", "--output", metavar="FILE", help='File to write; "-" for standard output. Without it KIND.toml.')
@force
@as_json
def new(kind: str, ross: str | None, output: str | None, force: bool, as_json: bool) -> int:
    """Write a commented two-plane balancing job, with numbers in it, to be filled in; or a rotor that ROSS saved.

    A file that is there already is not touched without --force.
    """
    if kind not in KINDS:
        raise InputError(f'there is no file of the kind "{kind}".{way_out(kind, KINDS)}')
    text = _text(kind, ross)
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


def _text(kind: str, ross: str | None) -> str:
    if kind == "balance":
        if ross is not None:
            raise InputError("--ross is of a rotor: vibopt new rotor --ross saved.toml")
        return _TEMPLATES.joinpath("balance.toml").read_text(encoding="utf-8")
    if ross is None:
        raise InputError("a rotor is written from one that ROSS saved. Name it: vibopt new rotor --ross saved.toml")
    document = ross_document(ross)
    from_dict(document, name=Path(ross).name)  # what a rotor cannot have is said now
    return f"{_OF_ROSS.format(Path(ross).name)}\n{document_toml(document)}"


_OF_ROSS = """\
# From {}, which ROSS saved. ROSS saves no unbalance, and no speeds but those of tables of bearings: change those below.
# Diameters, masses, stiffness and damping may be chosen: diameter = {{ from = "40 mm", to = "60 mm" }}.
"""
_TEMPLATES = Path(__file__).with_name("templates")
