"""Entry point: finds the verb, and turns whatever goes wrong into a message and an exit code."""

from __future__ import annotations

import atexit
import errno
import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING

import click

from vibopt.cli.options import Named
from vibopt.cli.output import (
    UnwritableError,
    check_open,
    complain,
    fail,
    flush,
    keep_streams,
    kept_words,
    note_kept,
    say_json,
)
from vibopt.errors import InputError, VibOptError
from vibopt.files.reading import forget

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

INTERNAL, INPUT, INTERRUPTED = 1, 2, 130
_UNWRITABLE = (errno.ENOSPC, errno.EIO, errno.EBADF)
STATUS = {2: "input_error", 5: "unproven", 6: "check_failed"}

VERBS = {
    "check": ("check", "Say whether problem files have mistakes; nothing is solved."),
    "solve": ("solve", "Find the best design, and prove it."),
    "explain": ("explain", "Say why this model, why this method, and what each limit costs."),
    "whatif": ("whatif", "Change facts or limits, and see the old answer beside the new."),
    "compare": ("compare", "Set several variants beside each other, problem files or saved designs."),
    "sweep": ("sweep", "Vary one, two or three facts over ranges."),
    "tradeoff": ("tradeoff", "Weigh the goal against a limit: the designs of which none is better in both."),
    "window": ("window", "Say how far each variable may go, and by how much all may be off at once."),
    "plot": ("picture", "Draw the answer."),
    "report": ("picture", "Write the answer as one page that can be signed (HTML)."),
    "new": ("new", "Write a problem file to fill in."),
    "verify": ("verify", "Solve every file of a folder and compare with what it recorded."),
    "chart": ("chart", "Chart methods: speed against accuracy, stability, profiles, cost, fidelity of the model."),
    "schema": ("schema", "Print the JSON schema of the problem file."),
    "help": ("help", "Show a topic of the manual, or search it."),
    "manual": ("help", "Write the manual as one page (HTML)."),
    "completion": ("completion", "Print what teaches bash, zsh or fish to complete a command."),
}
"""Verb: (its file in `vibopt/cli`, without "_command", and its line of help)."""


_NEW_OBJECTS = 120_000
"""After how many new objects Python looks for some that refer to each other and to which nothing refers: a start and an
answer make 60,000 to 90,000, and have none."""

_BUILT_IN = ("help",)
"""Verbs whose functions would hide one of Python."""


class Verbs(Named):
    """Loads the file of a verb when the verb is called; the help needs none of them."""

    noun = "verb"

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            return None
        home = import_module(f"vibopt.cli.{VERBS[cmd_name][0]}_command")
        command: click.Command = getattr(home, f"{cmd_name}_" if cmd_name in _BUILT_IN else cmd_name)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Verbs with their lines of help, without loading any; options behind a dash."""
        if incomplete.startswith("-"):
            return [one for one in super().shell_complete(ctx, incomplete) if one.value.startswith("-")]
        from click.shell_completion import CompletionItem

        return [CompletionItem(name, help=line) for name, (_, line) in VERBS.items() if name.startswith(incomplete)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Verbs"):
            formatter.write_dl([(name, line) for name, (_, line) in VERBS.items()])


def _version(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked and not ctx.resilient_parsing:
        from importlib.metadata import PackageNotFoundError, version

        try:
            click.echo(f"vibopt {version('vibopt')}")
        except PackageNotFoundError:
            click.echo("vibopt, not installed")
        ctx.exit()


@click.group(
    cls=Verbs,
    subcommand_metavar="VERB ...",
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": 100,
        "obj": {verb: line for verb, (_, line) in VERBS.items()},
    },
)
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_version, help="Say the version.")
def vibopt() -> None:
    """Vibration control by optimisation with proof.

    A problem is one TOML file: a machine on its mounts, or a rotor or an engine to balance.
    Every verb takes --json; exit codes are those of the answer's status. vibopt help lists the manual.
    """


def main(words: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    words
        What stands behind "vibopt" on the command line; None takes it from there.

    Returns
    -------
    int
        Exit code; `INTERNAL` too where standard output is closed or takes nothing more.
    """
    given = list(sys.argv[1:] if words is None else words)
    if words is None:
        atexit.register(gc.freeze)  # what all ends with is not looked through for circles once more: a sixth of a solve
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looked for in all that is installed
    gc.set_threshold(_NEW_OBJECTS)
    forget()
    note_kept("")
    keep_streams()
    try:
        check_open()
        code = _run(given, "--json" in given)
        flush()
    except UnwritableError as error:
        complain(str(error))
        return INTERNAL
    return code


def _run(given: list[str], as_json: bool) -> int:
    """The command, whatever goes wrong in it turned into words."""
    try:
        return int(vibopt.main(args=given, prog_name="vibopt", standalone_mode=False) or 0)
    except UnwritableError:
        raise
    except SystemExit:  # click ends so where the reader of its help has gone away
        return 0
    except (click.Abort, KeyboardInterrupt):
        return _stopped(as_json)
    except click.UsageError as error:
        return _usage(error, as_json)
    except VibOptError as error:
        return _mistakes(error, as_json)
    except OSError as error:
        if error.errno in _UNWRITABLE and error.filename is None:  # the help, which click writes
            raise UnwritableError(str(error.strerror)) from None
        return _fault(error, as_json)
    except Exception as error:
        return _fault(error, as_json)


def _stopped(as_json: bool) -> int:
    """The user has stopped it: what is left of the work, and where."""
    return fail(INTERRUPTED, "interrupted", f"Stopped. {kept_words()}", as_json=as_json)


def _usage(error: click.UsageError, as_json: bool) -> int:
    """A wrong command line; click knows what was meant."""
    if as_json:
        say_json({"status": "input_error", "messages": [error.format_message()]})
    elif isinstance(error, getattr(click.exceptions, "NoArgsIsHelpError", ())):  # click 8.2 and later
        complain(error.format_message())
    else:
        usage = f"{error.ctx.get_usage()}\n" if error.ctx is not None else ""
        way = f"\nTry: {error.ctx.command_path} --help" if error.ctx is not None else ""
        complain(f"{usage}{error.format_message()}{way}")
    return INPUT


def _mistakes(error: VibOptError, as_json: bool) -> int:
    """Mistakes of the user's, all of them."""
    messages = error.messages if isinstance(error, InputError) else [str(error)]
    return fail(error.exit_code, STATUS.get(error.exit_code, "internal_error"), *messages, as_json=as_json)


def _fault(error: Exception, as_json: bool) -> int:
    """A fault of ours: one sentence, and the traceback for those who ask for it."""
    if os.environ.get("VIBOPT_DEBUG") == "1":
        raise error
    text = " ".join(f"{type(error).__name__}: {error}".split()).rstrip(":. ")
    message = f"vibopt failed inside: {text}. This is a fault of vibopt, not of your file."
    return fail(INTERNAL, "internal_error", message, as_json=as_json)
