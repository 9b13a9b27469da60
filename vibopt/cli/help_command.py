"""`vibopt help` and `vibopt manual`: one manual in the terminal and as a page."""

from __future__ import annotations

from functools import cache, partial

import click

from vibopt.cli import completing
from vibopt.cli.options import Once, as_json, force
from vibopt.cli.output import colour, say, say_json, width
from vibopt.manual.book import Book, the_book
from vibopt.manual.markdown_rows import rows_of
from vibopt.manual.topic import Section, Topic

COMMANDS = "Commands"


def _topics(ctx: click.Context, param: click.Parameter, incomplete: str) -> completing.Items:
    return completing.begin(whole_book(_verbs(ctx)).topics, incomplete)


def _verbs(ctx: click.Context) -> click.Group:
    """All verbs, of which one is asked."""
    root = ctx.find_root().command
    assert isinstance(root, click.Group)
    return root


@click.command("help", cls=Once)
@click.argument("words", metavar="[TOPIC or words]", nargs=-1, shell_complete=_topics)
@as_json
def help_(words: tuple[str, ...], as_json: bool) -> int:
    """Show a topic of the manual, or search it.

    Without words all topics are listed. With the name of a topic, a table, a response or a verb that page is shown;
    with any other words the place that answers them best, and others that have them.
    """
    from vibopt.manual.terminal import contents, others, rendered

    book = whole_book(_verbs(click.get_current_context()))
    if not words:
        listed = {group: [topic.name for topic in topics] for group, topics in book.groups.items()}
        say_json({"status": "ok", "topics": listed}) if as_json else say(contents(book, width()))
        return 0
    found, more = book.find(" ".join(words))
    text = found.shown if isinstance(found, Topic) else found.text
    if as_json:
        say_json({"status": "ok", "topic": _topic(found), "text": text, "also": [_place(section) for section in more]})
        return 0
    say(rendered(text, width(), colour()))
    if isinstance(found, Section) and found.level > 1:
        say(f"\nFrom: vibopt help {found.topic}")
    if more:
        say(f"\n{others(more, width())}")
    return 0


@click.command(cls=Once)
@click.option("-o", "--output", metavar="FILE", default="manual.html", help="File to write; manual.html without it.")
@force
@as_json
def manual(output: str, force: bool, as_json: bool) -> int:
    """Write the whole manual as one page with contents and search, which needs no network."""
    from vibopt.files.writing import checked_target, write_file
    from vibopt.manual.page import page_of

    target = checked_target(output, (".html",), force=force)
    write_file(target, page_of(whole_book(_verbs(click.get_current_context()))).encode())
    say_json({"status": "ok", "written": [str(target)]}) if as_json else say(f"Written: {target}")
    return 0


@cache
def whole_book(verbs: click.Group) -> Book:
    """The manual with a page for each verb, made from its options; `verbs` have their lines of help with them."""
    context = click.Context(verbs, info_name="vibopt", **verbs.context_settings)
    pages = []
    for verb, line in context.obj.items():
        pages.append(Topic(verb, COMMANDS, partial(_page, verb, verbs, context), line.rstrip(".")))
    topics = list(the_book().topics.values())
    after = max((k + 1 for k, topic in enumerate(topics) if topic.group in ("Begin", "Guides")), default=0)
    return Book([*topics[:after], *pages, *topics[after:]])


def _page(verb: str, group: click.Group, above: click.Context) -> str:
    """What a verb does, its words and its options."""
    command = group.get_command(above, verb)
    assert command is not None
    context = click.Context(command, info_name=verb, parent=above)
    usage = " ".join(command.collect_usage_pieces(context))
    options = [param.get_help_record(context) for param in command.get_params(context)]
    table = rows_of(("option", ""), [(f"`{names}`", text) for names, text in filter(None, options)])
    text = "\n\n".join(" ".join(part.split()) for part in (command.help or "").split("\n\n"))
    return "\n\n".join([f"# {verb}", text, f"```text\nvibopt {verb} {usage}\n```", table])


def _topic(found: Topic | Section) -> str:
    return found.name if isinstance(found, Topic) else found.topic


def _place(section: Section) -> dict[str, str]:
    return {"topic": section.topic, "heading": section.heading}
