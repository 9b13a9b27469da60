"""`vibopt help` and `vibopt manual`: every topic fits the terminal, words are found, links lead somewhere."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from vibopt.cli.help_command import whole_book
from vibopt.cli.main import main
from vibopt.cli.main import vibopt as verbs
from vibopt.manual.page import page_of
from vibopt.manual.search import words_of
from vibopt.manual.terminal import rendered
from vibopt.manual.topic import Topic

BOOK = whole_book(verbs)


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["help", *words]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", BOOK.topics)
def test_every_topic_is_shown_in_eighty_columns(name: str) -> None:
    lines = rendered(BOOK.topics[name].shown, 80).splitlines()
    assert lines[0] == BOOK.topics[name].title[:80] or lines[0] in BOOK.topics[name].title
    assert max(map(len, lines)) <= 80
    assert "<!--" not in "".join(lines)
    assert not re.search(r"(?<!`)``(?!`)", "\n".join(lines))


def test_the_list_of_topics_names_all_and_fits(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys)
    assert set(BOOK.topics) <= set(re.findall(r"[\w-]+", text))
    assert max(map(len, text.splitlines())) <= 80


def test_a_topic_is_found_by_its_name_in_any_spelling(capsys: pytest.CaptureFixture[str]) -> None:
    page = rendered(BOOK.topics["transmitted_force"].shown, 80)
    for words in (["transmitted_force"], ["Transmitted", "force"], ["transmitted-force"], ["transmitted force"]):
        assert said(capsys, *words) == f"{page}\n"
    assert said(capsys, "link") == f"{rendered(BOOK.topics['links'].shown, 80)}\n"


def test_an_unknown_topic_names_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", "transmited_forc"]) == 2
    assert capsys.readouterr().err == (
        'the manual has nothing on "transmited_forc". Did you mean "transmitted_force"? vibopt help lists all.\n'
    )


def test_help_speaks_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", "links", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["topic"] == "links"
    assert told["text"] == BOOK.topics["links"].shown
    assert main(["help", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["topics"]
    assert [name for names in listed.values() for name in names] == list(BOOK.topics)


@pytest.mark.parametrize("name", BOOK.topics)
def test_every_title_finds_its_topic(name: str) -> None:
    found, _ = BOOK.find(name)
    assert found is BOOK.topics[name]


def test_names_are_searched_whole_and_in_parts() -> None:
    assert words_of("The natural_frequency of two fans: start-up!") == [
        "natural_frequency", "natural", "frequency", "two", "fan", "start_up", "start", "up",
    ]  # fmt: skip


class Links(HTMLParser):
    """Names of places, and where links lead."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []
        self.targets: set[str] = set()
        self.outside: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in ("h1", "h2", "h3"):
            self.names.append(given.get("id") or "")
        if tag == "a":
            self.targets.add(given["href"] or "")
        fetched = [given.get(key) or "" for key in ("src", "srcset", "data")]
        self.outside += [one for one in fetched if one and not one.startswith("data:image/svg+xml;base64,")]
        if tag == "link":
            self.outside.append("link")


@pytest.fixture(scope="module")
def page() -> str:
    return page_of(BOOK)


def test_every_link_of_the_page_leads_to_a_place_of_it(page: str) -> None:
    links = Links()
    links.feed(page)
    inner = {target for target in links.targets if not target.startswith("https://")}
    assert inner <= {f"#{name}" for name in links.names}
    assert set(BOOK.topics) <= set(links.names)
    assert len(set(links.names)) == len(links.names), "two places have one name"


def test_the_page_needs_no_network(page: str) -> None:
    links = Links()
    links.feed(page)
    assert not links.outside
    assert "@import" not in page
    assert "url(" not in page


def test_links_lead_to_their_places_in_the_terminal_too() -> None:
    text = "See [absorbers](absorbers.md#keys), [the guide](absorbers.md) and `[links.NAME]`(3)."
    assert rendered(text, 80) == "See absorbers, the guide (`vibopt help absorbers`) and `[links.NAME]`(3)."


def test_pictures_are_words_and_wide_comments_stand_above_in_the_terminal() -> None:
    assert rendered("![A map of limits](map.svg)", 80) == "(Picture: A map of limits)"
    block = """```toml
[links.NAME]
stiffness = "2 MN/m"               # dynamic, of one single mount, whatever the number of them that stand side by side,
                                   # or a choice
count = 4
```"""
    assert [line.strip() for line in rendered(block, 60).splitlines()] == [
        "[links.NAME]",
        "# dynamic, of one single mount, whatever the number of",
        "# them that stand side by side, or a choice",
        'stiffness = "2 MN/m"',
        "count = 4",
    ]


def test_the_page_is_written_and_no_other_file_is_written_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "manual.html"
    for _ in range(2):
        assert main(["manual", "-o", str(target)]) == 0
        assert capsys.readouterr().out == f"Written: {target}\n"
    target.write_text("mine", encoding="utf-8")
    assert main(["manual", "-o", str(target)]) == 2
    assert target.read_text(encoding="utf-8") == "mine"
    assert main(["manual", "-o", str(target), "--force"]) == 0
    assert main(["manual", "-o", str(tmp_path / "manual.pdf")]) == 2


def test_sections_are_cut_at_headings_but_not_in_code() -> None:
    topic = Topic(
        "any", "group", "# A title\n\nText.\n\n## More\n<!-- words: hidden -->\n\n```toml\n# no heading\n```\n"
    )
    assert [(one.heading, one.words) for one in topic.sections] == [("A title", ""), ("More", "hidden")]
    assert "hidden" not in topic.shown
    assert topic.line == "A title"
    assert Topic("any", "group", "# any\n\n```toml\n[a]\n```\n\nSome words. More.").line == "Some words"
