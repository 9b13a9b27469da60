"""What a guide shows, run as a reader would: its files are written, its commands called, its Python executed."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from vibopt.cli.main import main

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
_NAMED = re.compile(r"\b([\w-]+\.(?:toml|csv))\b")


@dataclass(frozen=True)
class Block:
    """A block of a guide, and the file that it is, where its name stands in the text before it or soon after."""

    language: str
    text: str
    file: str

    @property
    def is_whole(self) -> bool:
        """Whether it is a problem file from its title on, rather than a piece."""
        return self.language == "toml" and self.text.startswith('title = "')


def blocks_of(guide: str) -> list[Block]:
    found, end, known = [], 0, set()
    for match in _FENCE.finditer(guide):
        language, text = match[1], match[2]
        ending = {"toml": ".toml", "csv": ".csv", "text": ".csv"}.get(language, "")
        before, after = (
            _NAMED.findall(guide[end : match.start()]),
            _NAMED.findall(guide[match.end() : match.end() + 600]),
        )
        names = [one for one in [*reversed(before), *after] if ending and one.endswith(ending) and one not in known]
        name = names[0] if names and (text.startswith(('title = "', "run,", "part;"))) else ""
        known.add(name)
        found.append(Block(language, text, name))
        end = match.end()
    return found


def commands_of(block: Block) -> Iterator[tuple[list[str], str]]:
    """Words of each command behind "$ vibopt", and what it is to print."""
    for part in re.split(r"^\$ vibopt ", block.text, flags=re.M)[1:]:
        line, _, expected = part.partition("\n")
        yield shlex.split(line), expected


def output_of(words: list[str]) -> str:
    """What a command prints, errors with it."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        main(words)
    return said.getvalue()


def agrees(expected: str, said: str) -> bool:
    """Whether an output is as expected, where a line "..." stands for any lines, and "..." in one for any words."""
    pattern = ""
    for line in expected.splitlines():
        pattern += r"(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + r"\n"
    return re.fullmatch(pattern, "".join(f"{line.rstrip()}\n" for line in said.splitlines())) is not None


def run(guide: str, folder: Path) -> Iterator[tuple[str, str, str]]:
    """Every command with what it is to print and what it prints; files are written on the way."""
    names: dict[str, object] = {}
    for block in blocks_of(guide):
        if block.file:
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(compile(block.text, "guide", "exec"), names)
        elif block.language == "console":
            for words, expected in commands_of(block):
                yield " ".join(words), expected, output_of(words)
