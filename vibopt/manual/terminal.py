"""The manual in a terminal: topics no wider than it, and the list of them."""

from __future__ import annotations

import io
import re
import textwrap
from collections.abc import Sequence

from vibopt.manual.book import Book
from vibopt.manual.topic import Section, Topic

_LINK = re.compile(r"\[([^\]]+)\]\(([\w-]*)(?:\.md)?(#[\w-]+)?\)")
_PICTURE = re.compile(r"!\[([^\]]+)\]\([^)]+\)")
_CODE = re.compile(r"(?<!`)`((?:[^`\n]|\n(?!\n))+)`(?!`)")
_LONG = 20
"""Topics of a group from which on the contents give names alone."""


def rendered(markdown: str, width: int, colour: bool = False) -> str:
    """Markdown as lines of at most `width` columns; without colour code keeps its marks."""
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.markdown import Heading, Markdown

    class Left(Heading):
        """A heading at the left, where the eye begins to read."""

        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            self.text.justify = "left"
            self.text.stylize("bold")
            yield self.text

    class Plain(Markdown):
        elements = {**Markdown.elements, "heading_open": Left}  # noqa: RUF012 - as rich has it

    out = io.StringIO()
    console = Console(
        file=out, width=width, force_terminal=colour, color_system="standard" if colour else None, highlight=False
    )
    console.print(Plain(_readable(markdown, colour, width), hyperlinks=False, code_theme="ansi_dark"))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()).strip("\n")


def contents(book: Book, width: int) -> str:
    """All topics by group, those of small groups with their first sentence."""
    lines = ["Topics of the manual: vibopt help TOPIC, or any words: vibopt help 7 mm/s rms", ""]
    for group, topics in book.groups.items():
        lines.append(group)
        if len(topics) > _LONG and group != "Guides":
            lines += textwrap.wrap(
                ", ".join(topic.name for topic in topics), width - 2, initial_indent="  ", subsequent_indent="  "
            )
        else:
            lines += [_row(topic, width) for topic in topics]
        lines.append("")
    return "\n".join([*lines, "The whole as one page with contents and search: vibopt manual -o manual.html"])


def others(found: Sequence[Section], width: int) -> str:
    """Where else the words are."""
    names = dict.fromkeys(
        section.topic if section.level == 1 else f"{section.topic} ({section.heading})" for section in found
    )
    text = f"Also: {', '.join(names)}"
    return textwrap.fill(text, width, subsequent_indent="  ", break_long_words=False) if names else ""


def _row(topic: Topic, width: int) -> str:
    head = f"  {topic.name:<20} "
    return f"{head}{textwrap.shorten(topic.line, max(20, width - len(head)), placeholder=' ...')}".rstrip()


def _readable(markdown: str, colour: bool, width: int) -> str:
    """Links as the command that follows them; pictures as their words; comments above what they speak of."""
    parts = re.split(r"(^```.*?^```$)", markdown, flags=re.M | re.S)
    return "".join(_narrow(part, width - 2) if part.startswith("```") else _inline(part, colour) for part in parts)


def _narrow(fence: str, width: int) -> str:
    """A block of a problem file whose comments would not fit beside it, with them above."""
    lines = fence.splitlines()
    if not fence.startswith("```toml") or max(map(len, lines)) <= width:
        return fence
    made: list[str] = []
    for line in lines:
        code, sign, comment = line.partition("# ")
        if not sign:
            made.append(line)
        elif code.strip():
            made += [f"# {comment}", code.rstrip()]
        elif code and len(made) > 1:  # goes on with the comment of the line before
            made[-2] = f"{made[-2]} {comment}"
        else:
            made.append(line)
    wrapped = [textwrap.wrap(one, width, subsequent_indent="# ") if one.startswith("# ") else [one] for one in made]
    return "\n".join(part for some in wrapped for part in some)


def _inline(text: str, colour: bool) -> str:
    def link(found: re.Match[str]) -> str:
        name = found[2]
        return found[1] if not name or name in found[1].strip("`") else f"{found[1]} (`vibopt help {name}`)"

    bare = _LINK.sub(link, _PICTURE.sub(r"(Picture: \1)", text))
    return bare if colour else _CODE.sub(r"`` `\1` ``", bare)
