"""Words that several verbs share: the file, --set, --json, --method."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar

import click

from vibopt.cli import completing
from vibopt.errors import InputError, way_out

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.scene.scene import Scene

Verb = TypeVar("Verb", bound=Callable[..., Any])


class Once(click.Command):
    """A verb whose options are said once, unless they may be repeated: of two the first would be lost."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        order = self.make_parser(ctx).parse_args(args=list(args))[2] if not ctx.resilient_parsing else []
        for one in order:
            if isinstance(one, click.Option) and not (one.multiple or one.is_flag) and order.count(one) > 1:
                raise click.UsageError(f"{one.opts[-1]} is given twice. Give it once.", ctx)
        return super().parse_args(ctx, args)


class Named(click.Group):
    """Commands of a group, of which one that is not there is answered with near ones."""

    noun = "chart"

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        known = self.list_commands(ctx)
        if args[0] not in known and not args[0].startswith("-") and not ctx.resilient_parsing:
            ctx.fail(f'there is no {self.noun} "{args[0]}".{way_out(args[0], known)}')
        return super().resolve_command(ctx, args)


file = click.argument("file", metavar="FILE", shell_complete=completing.problem_files)
files = click.argument("files", metavar="FILE...", nargs=-1, required=True, shell_complete=completing.problem_files)
as_json = click.option("--json", "as_json", is_flag=True, help="Answer in JSON on standard output.")
method = click.option(
    "--method",
    metavar="NAME",
    shell_complete=completing.methods,
    help="Answer by this method instead of the best one for the scene.",
)


def _limited(ctx: click.Context, _: click.Parameter, seconds: float | None) -> None:
    from vibopt.work import each_answer_within

    if seconds is not None and not isfinite(seconds):
        raise click.BadParameter(f"{seconds} is no number of seconds. Write --time-limit 5, or leave it out.")

    ctx.with_resource(each_answer_within(seconds))


limited = click.option(
    "--time-limit",
    metavar="SECONDS",
    type=click.FloatRange(min=0.0, min_open=True),
    expose_value=False,
    callback=_limited,
    help="End every search of an answer after so long; the claim says so. Without it no clock decides anything.",
)
fidelity = click.option(
    "--fidelity",
    type=click.Choice(["least", "full"]),
    default="least",
    help="full: leave no freedom out, needed or not, to check that what is left out by itself changes nothing.",
)
changes = click.option(
    "--set",
    "changes",
    metavar="PATH=VALUE",
    multiple=True,
    shell_complete=completing.changes,
    help='Replace a value of the file, as in --set limits.start_up.at_most="8 mm"; may be repeated.',
)


def _roundable(ctx: click.Context, _: click.Parameter, given: tuple[str, ...]) -> tuple[str, ...]:
    """What is asked, which is refused before anything is solved where it can be no rounding."""
    if given and not ctx.resilient_parsing:
        from vibopt.study.grids import check_asked

        check_asked(given)
    return given


rounding = click.option(
    "--round",
    "rounding",
    metavar="DIGITS",
    multiple=True,
    callback=_roundable,
    help="Round the chosen values as on the drawing, and measure anew: --round 3, or --round links.mount.stiffness="
    '"50 kN/m" for steps; may be repeated.',
)
scenario = click.option("--scenario", metavar="NAME", help="With the changes of [scenarios.NAME] of the file.")
workers = click.option(
    "--workers",
    type=click.IntRange(1, 64),
    default=1,
    metavar="N",
    help="Processes at a time; the answers do not depend on it.",
)
cluster = click.option(
    "--cluster",
    metavar="ADDRESS",
    help="Have the workers of a scheduler of Dask answer, tcp://HOST:8786; the answers do not depend on it.",
)
force = click.option("--force", is_flag=True, help="Write over a file that vibopt did not write.")
fresh = click.option("--fresh", is_flag=True, help="Solve again, whatever the last answer to the same content was.")
anew = click.option("--fresh", is_flag=True, expose_value=False, help="Solve again: this command always does.")
keep_design = click.option("--keep-design", is_flag=True, help="The design is bought: measure it, choose nothing anew.")


def split_change(given: str) -> tuple[str, str]:
    """Path and value text of one --set.

    Raises
    ------
    InputError
        There is no "=", no path or no value.
    """
    path, sign, value = given.partition("=")
    if not (sign and path.strip() and value.strip()):
        raise InputError(f'--set {given}: is no PATH=VALUE. Write --set limits.start_up.at_most="8 mm".')
    return path.strip(), value.strip()


def value_of(text: str) -> Any:
    """The value as TOML would have it: a number, a list, a table; anything else is a text."""
    from vibopt.document.toml_reading import toml_of

    try:
        return toml_of(f"value = {text}")["value"] if "\n" not in text else text
    except (ValueError, RecursionError):
        return text


def changes_of(given: Sequence[str]) -> dict[str, Any]:
    """Values by path of all --set; InputError where a path is there twice."""
    found: dict[str, Any] = {}
    for path, text in map(split_change, given):
        if path in found:
            raise InputError(f"--set {path} is given twice. Give it once.")
        found[path] = value_of(text)
    return found


def with_scenario(file: str, name: str | None, given: tuple[str, ...]) -> tuple[str, ...]:
    """The changes of a scenario of the file, then those of --set, which win; InputError where it has no such one."""
    if name is None:
        return given
    from vibopt.jobs import scenarios_of

    job = read_job(file)
    known = scenarios_of(job)
    if name not in known:
        none = " It has none: write [scenarios.NAME]." if not known else way_out(name, list(known))
        raise InputError(f'{job.name}: there is no scenario "{name}".{none}')
    said = changes_of(given)
    return (*(f"{path}={_as_typed(one)}" for path, one in known[name].items() if path not in said), *given)


def _as_typed(value: Any) -> str:
    """A value as it is typed behind --set."""
    from json import dumps

    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_as_typed(one)}' for key, one in value.items())} }}"
    if isinstance(value, str) and type(value_of(value)) is str:
        return value
    return dumps(value)


def read_job(file: str, given: Sequence[str] = ()) -> Job:
    """What a file asks, with its changes."""
    from vibopt.jobs import open_job

    return open_job(file, changes_of(given))


def read_scene(file: str, verb: str, instead: str) -> Scene:
    """The scene of a file; a balancing job is refused in the name of the verb."""
    from vibopt.jobs import scene_only

    return scene_only(read_job(file), verb, instead)
