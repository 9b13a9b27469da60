"""The manual as one page that stands alone: contents, search in plain JavaScript, light and dark."""

from __future__ import annotations

import re
from base64 import b64encode
from collections import Counter
from pathlib import Path
from typing import Any

from vibopt.files import marks
from vibopt.manual.book import Book
from vibopt.manual.search import IDLE
from vibopt.manual.topic import Topic, slug

_HERE = Path(__file__).parent
_LINK = re.compile(r"(?P<topic>[\w-]*)(?:\.md)?(?:#(?P<place>[\w-]+))?$")


def page_of(book: Book) -> str:
    """The whole manual as HTML."""
    from jinja2 import Environment, FileSystemLoader
    from markupsafe import Markup

    template = Environment(loader=FileSystemLoader(_HERE), autoescape=True).get_template("page.html.j2")
    groups = {
        group: [{"name": topic.name, "title": topic.title, "body": Markup(body_of(topic))} for topic in topics]
        for group, topics in book.groups.items()
    }
    return template.render(groups=groups, generator=Markup(marks.GENERATOR), idle=sorted(IDLE))


def body_of(topic: Topic) -> str:
    """One topic as HTML: headings have names, links lead within the page, wide tables scroll by themselves."""
    from markdown_it import MarkdownIt

    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = parser.parse(topic.shown)
    names: Counter[str] = Counter()
    sections = list(topic.sections)
    for k, token in enumerate(tokens):
        if token.type == "heading_open":
            name = topic.name if token.tag == "h1" else f"{topic.name}--{slug(tokens[k + 1].content)}"
            names[name] += 1
            token.attrSet("id", name if names[name] == 1 else f"{name}-{names[name]}")
            if words := sections.pop(0).words:
                token.attrSet("data-words", words)
        for inner in token.children or ():
            _mend(inner, topic)
    made: str = parser.renderer.render(tokens, parser.options, {})
    return made.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")


def address(target: str, topic: str) -> str:
    """Where a link of a guide leads within the page: "absorbers.md#maps" as "#absorbers--maps"."""
    match = _LINK.match(target)
    if not match or "://" in target:
        return target
    name = match["topic"] or topic
    return f"#{name}--{match['place']}" if match["place"] else f"#{name}"


def _mend(token: Any, topic: Topic) -> None:
    """A link of one guide to another; a picture, which is put in as it is drawn."""
    if token.type == "link_open":
        token.attrSet("href", address(str(token.attrGet("href")), topic.name))
    elif token.type == "image":
        drawn = (_HERE / "guides" / str(token.attrGet("src"))).read_bytes()
        token.attrSet("src", f"data:image/svg+xml;base64,{b64encode(drawn).decode()}")
