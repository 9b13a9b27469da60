"""`vibopt schema`: the problem file as JSON schema."""

from __future__ import annotations

import click

from vibopt.cli import completing
from vibopt.cli.options import Once, as_json
from vibopt.cli.output import say_json


@click.command(cls=Once)
@click.argument("kind", metavar="[KIND]", required=False, default="scene", shell_complete=completing.kinds)
@as_json
def schema(kind: str, as_json: bool) -> int:
    """Print the JSON schema of the problem file or of answers, for editors and for other programs.

    KIND is scene (the default), rotor, known or engine: the last three are balancing jobs; or answer, for what
    `solve --json` prints of any of them.
    """
    from vibopt.manual.schema import schema_of

    say_json(schema_of(kind))
    return 0
