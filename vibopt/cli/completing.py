"""What may stand next on a command line, asked by the shell: files, paths within the file, methods, kinds."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click

from vibopt.errors import VibOptError

Items = list[str]
_SHELLS = ("bash", "zsh", "fish")


def begin(words: Iterable[str], incomplete: str) -> Items:
    """Those of the words that begin so."""
    return [word for word in words if word.startswith(incomplete)]


def problem_files(ctx: click.Context, param: click.Parameter, incomplete: str) -> Items:
    """Problem files and folders that begin so."""
    folder, _, front = incomplete.rpartition("/")
    base = Path(f"{folder}/" if incomplete.startswith("/") or folder else ".").expanduser()
    try:
        found = sorted(path for path in base.iterdir() if path.name.startswith(front) and not path.name.startswith("."))
    except OSError:
        return []
    before = f"{folder}/" if "/" in incomplete else ""
    return [f"{before}{path.name}" for path in found if path.suffix == ".toml" or path.is_dir()]


def _paths(ctx: click.Context, *, chosen: bool) -> Iterable[str]:
    """Paths of the facts of the file on the line, and of what may be chosen."""
    from vibopt.jobs import facts, is_scene, open_job

    words = [ctx.params.get("file"), *(ctx.params.get("files") or ()), *ctx.args]  # behind an open option all is there
    named = [str(word) for word in words if str(word).endswith(".toml")]
    try:
        job = open_job(named[0] if named else "")
    except VibOptError:
        return
    yield from (fact.path for fact in facts(job))
    if chosen and is_scene(job):
        yield from (variable.path for variable in job.variables)


def changes(ctx: click.Context, param: click.Parameter, incomplete: str) -> Items:
    """What --set and --vary may name, up to the sign of equality."""
    return begin((f"{path}=" for path in _paths(ctx, chosen=True)), incomplete)


def methods(ctx: click.Context, param: click.Parameter, incomplete: str) -> Items:
    """Methods by name."""
    from vibopt.jobs import POSED
    from vibopt.solve.by_name import METHODS

    return begin((*METHODS, *POSED), incomplete)


def kinds(ctx: click.Context, param: click.Parameter, incomplete: str) -> Items:
    """Kinds of schema."""
    return begin(("scene", "rotor", "known", "engine", "answer"), incomplete)


def shells(ctx: click.Context, param: click.Parameter, incomplete: str) -> Items:
    """Shells that can be told."""
    return begin(_SHELLS, incomplete)
