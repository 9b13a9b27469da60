"""`vibopt completion`: the lines that teach a shell to complete a command."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from vibopt.cli import completing
from vibopt.cli.options import Once, as_json
from vibopt.cli.output import say, say_json

_BASH = """\
%(complete_func)s() {
    local IFS=$'\\n' response type value before
    response=$(env COMP_WORDS="${COMP_WORDS[*]}" COMP_CWORD=$COMP_CWORD %(complete_var)s=bash_complete "$1")
    for completion in $response; do
        IFS=',' read -r type value <<< "$completion"
        case $type in
            dir) COMPREPLY=(); compopt -o dirnames ;;
            file) COMPREPLY=(); compopt -o default ;;
            plain) COMPREPLY+=("$value"); [[ $value == *= ]] && compopt -o nospace ;;
        esac
    done
    return 0
}
complete -o nosort -o default -o filenames -F %(complete_func)s %(prog_name)s
"""
"""As the one of click, but folders get their stroke, a path to be given a value gets no blank,
and where nothing else is known there are file names."""
_HOW = {
    "bash": 'vibopt completion bash > ~/.local/share/bash-completion/completions/vibopt, or eval "$(...)" in ~/.bashrc',
    "zsh": "vibopt completion zsh > a file _vibopt in a folder of $fpath",
    "fish": "vibopt completion fish > ~/.config/fish/completions/vibopt.fish",
}


@click.command(cls=Once)
@click.argument("shell", metavar="bash|zsh|fish", type=click.Choice(list(_HOW)), shell_complete=completing.shells)
@as_json
def completion(shell: str, as_json: bool) -> int:
    """Print what teaches a shell to complete verbs, options, problem files, paths of --set and --vary, and topics.

    For bash: eval "$(vibopt completion bash)" in ~/.bashrc, or the lines in a file of
    ~/.local/share/bash-completion/completions.
    """
    kind = get_completion_class(shell)
    assert kind is not None
    made = kind(click.get_current_context().find_root().command, {}, "vibopt", "_VIBOPT_COMPLETE")
    script = f"# {_HOW[shell]}\n" + (_BASH % made.source_vars() if shell == "bash" else made.source())
    say_json({"status": "ok", "script": script}) if as_json else say(script)
    return 0
