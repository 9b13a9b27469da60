"""The rules of the house: who may import whom, docstrings, and clean runs of ruff and mypy."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TypeGuard

import pytest
from hypothesis import settings

ROOT = Path(__file__).parent.parent
MODULES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
    for file in sorted((ROOT / "vibopt").rglob("*.py"))
}

FLOORS = (
    ("arguments", "errors", "records"),
    ("arrays", "bracketing", "work"),
    ("cones", "files", "frontier", "signals", "units"),
    ("document",),
    ("values",),
    ("answer",),
    ("mechanics",),
    ("forms",),
    ("devices", "excitations", "responses"),
    ("scene",),
    ("program",),
    ("verify",),
    ("report",),
    ("balancing", "solve"),
    ("posed",),
    ("jobs",),
    ("study",),
    ("charts",),
    ("manual",),
    ("cli",),
)
"""From the ground up: an area imports itself and what lies on lower floors."""
FLOOR = {area: floor for floor, areas in enumerate(FLOORS) for area in areas}

BY_NAME = {
    "vibopt": "",
    "vibopt.answer.stored": "",
    "vibopt.answer.tabular": "",
    "vibopt.answer.views": "",
    "vibopt.charts.shock_cases": "",
    "vibopt.cli.main": "vibopt.cli.{}_command",
    "vibopt.solve.by_name": "vibopt.solve.{}",
    "vibopt.solve.rivals.hsbalance": "",
    "vibopt.solve.rivals.population": "",
    "vibopt.study.cluster": "",
    "vibopt.study.loaded": "vibopt.{}",
    "vibopt.values.kinds": "",
}
"""Who opens modules by texts, and what a text of it stands for; "" where it is a whole name, or comes from others: the
package is above all and registers the views of each kind of job, and kinds say the package of their places."""
ELSEWHERE = (("vibopt.study.workers", "vibopt.study.loaded"), ("vibopt.study.cluster", "vibopt.study.cluster"))
"""What another process opens: workers are forked from one that has loaded all that an answer needs, and a worker of a
scheduler opens this very module."""
KINDS = ("Kinds", "Later", "loaded")
"""What opens "module.Class" of a package that is said before."""

CLOCKS = (
    "perf_counter",
    "perf_counter_ns",
    "monotonic",
    "monotonic_ns",
    "process_time",
    "thread_time",
    "max_wall_time",
)
AROUND_CLOCKS = ("vibopt.work", "vibopt.solve.solve", "vibopt.charts", "vibopt.cli.progress")
"""Who may read a clock: the user's time limit, times that are shown, and charts, which are there to measure."""

HOMES = {
    "clarabel": ("vibopt.cones",),
    "casadi": ("vibopt.program.casadi_nlp", "vibopt.posed"),
    "cvxpy": ("vibopt.posed", "vibopt.solve.rivals"),
    "hsbalance": ("vibopt.solve.rivals",),
    "distributed": ("vibopt.study.cluster",),
    "matplotlib": (
        "vibopt.report.figures",
        "vibopt.charts.chart_figures",
        "vibopt.charts.accuracy_figure",
        "vibopt.balancing.figures",
    ),
}
"""Large libraries, and where alone they may be loaded."""


@cache
def _nodes(module: str) -> tuple[ast.AST, ...]:
    """All that a module says; looked through once, for all rules."""
    return tuple(ast.walk(_parsed(module)))


def _imports(module: str, *, types: bool = True) -> Iterator[tuple[int, str]]:
    """Line and full name of every import, also inside functions; without `types` not those for annotations only."""
    hidden = [
        range(node.lineno, (node.end_lineno or node.lineno) + 1)
        for node in _nodes(module)
        if not types and isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
    ]
    for node in _nodes(module):
        if not isinstance(node, ast.Import | ast.ImportFrom) or any(node.lineno in lines for lines in hidden):
            continue
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
            continue
        assert not node.level, f"line {node.lineno}: write the full name instead of a relative import"
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            yield node.lineno, inner if inner in MODULES else str(node.module)


def _texts(nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """Line and text of each constant, also in tables and f-strings."""
    for one in nodes:
        if isinstance(one, ast.Constant) and isinstance(one.value, str):
            yield one.lineno, one.value


def _places(text: str) -> Iterator[str]:
    """A dotted text, and without its last part, as "module.Class" is."""
    yield text
    yield text.rpartition(".")[0]


def _named(module: str) -> Iterator[tuple[int, str]]:
    """Line and full name of each module that a module opens by a text."""
    packages, every = set(), _nodes(module)
    for node in filter(_opens_kinds, every):
        package, *rest = node.args
        packages.add(getattr(package, "value", ""))
        home = str(package.value) if isinstance(package, ast.Constant) else module
        for line, text in (found for one in rest for found in _texts(_whole(one, every))):
            yield from ((line, name) for one in _places(text) if (name := f"{home}.{one}") in MODULES)
    for line, text in _texts(every):
        if text in MODULES and "." in text and text not in packages and (module, text) not in ELSEWHERE:
            yield line, text
    if how := BY_NAME.get(module):
        yield from ((line, name) for line, text in _texts(every) if (name := how.format(text)) in MODULES)


def _opens_kinds(node: ast.AST) -> TypeGuard[ast.Call]:
    """Whether that is Kinds("package", ...), Kinds[Device]("package", ...) or their like."""
    if not isinstance(node, ast.Call):
        return False
    func = node.func.value if isinstance(node.func, ast.Subscript) else node.func
    return getattr(func, "id", "") in KINDS and len(node.args) > 1


def _whole(node: ast.AST, every: tuple[ast.AST, ...]) -> Iterable[ast.AST]:
    """What a text is made of: of a name in a loop all that the module has."""
    return ast.walk(node) if isinstance(node, ast.Constant | ast.Dict) else every


def _under(module: str, homes: tuple[str, ...]) -> bool:
    return any(module == home or module.startswith(f"{home}.") for home in homes)


def _area(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def _wrong(module: str, imported: str) -> bool:
    """Whether an import within the package runs upward or sideways."""
    area, other = _area(module), _area(imported)
    if area not in FLOOR:  # the package itself and __main__ stand above everything
        return False
    return area != other and FLOOR.get(other, len(FLOORS)) >= FLOOR[area]


@cache
def _parsed(module: str) -> ast.Module:
    return ast.parse(MODULES[module].read_text(encoding="utf-8"))


@cache
def _loads(module: str) -> tuple[tuple[int, str], ...]:
    """Line and module of what is imported when it is run, by its name in a text too, not for types alone."""
    return (*_imports(module, types=False), *_named(module))


@pytest.mark.parametrize("module", MODULES)
def test_imports_point_downward(module: str) -> None:
    wrong = [
        f"line {line}: {imported}"
        for line, imported in sorted({*_imports(module), *_loads(module)})
        if _under(imported, ("vibopt",)) and _wrong(module, imported)
    ]
    assert not wrong, f"{module} imports what does not lie below it"


def test_modules_are_opened_by_name_where_that_is_known() -> None:
    """What opens them is seen, and so are the texts: in tables, behind a package, and with all of a name."""
    opens = {
        module for module in MODULES for node in _nodes(module)
        if {getattr(node, "id", ""), getattr(node, "attr", "")} & {"import_module", "__import__"}
    }  # fmt: skip
    assert opens == set(BY_NAME)
    assert all(text in dict(_texts(_nodes(module))).values() for module, text in ELSEWHERE)
    assert {"vibopt.report.machine_views", "vibopt.balancing.plan_views"} <= {name for _, name in _loads("vibopt")}
    assert "vibopt.solve.global_search" in {name for _, name in _loads("vibopt.solve.by_name")}
    assert "vibopt.devices.inertia" in {name for _, name in _loads("vibopt.devices.body")}
    assert "vibopt.excitations.run_up" in {name for _, name in _loads("vibopt.excitations.directed")}
    assert "vibopt.responses.margin" in {name for _, name in _loads("vibopt.responses")}
    assert "vibopt.cli.picture_command" in {name for _, name in _loads("vibopt.cli.main")}


def _circles(needs: dict[str, set[str]]) -> list[str]:
    """Modules that need themselves by a detour."""

    def reached(module: str) -> set[str]:
        seen: set[str] = set()
        waiting = list(needs[module])
        while waiting:
            here = waiting.pop()
            if here not in seen:
                seen.add(here)
                waiting += needs[here]
        return seen

    return [module for module in needs if module in reached(module)]


def test_no_module_needs_itself_by_a_detour() -> None:
    """Inside an area too, imports inside functions and by name counted."""
    needs = {module: {other for _, other in _loads(module) if other in MODULES} for module in MODULES}
    assert _circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == ["a", "b", "c"]
    assert not _circles(needs)


def test_the_map_for_contributors_is_that_of_the_floors() -> None:
    """Every area stands in the map once, none above what it imports."""
    rows = re.findall(r"^\| (`.*`) \|", (ROOT / "vibopt" / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.MULTILINE)
    shown = [re.findall(r"`(\w+)`", row) for row in rows]
    assert sorted(area for row in shown for area in row) == sorted(FLOOR)
    floors = [FLOOR[area] for row in shown for area in row]
    assert floors == sorted(floors)


def test_every_area_has_its_floor() -> None:
    areas = {_area(module) for module in MODULES}
    assert areas - {"", "__main__"} == set(FLOOR)


@pytest.mark.parametrize("module", MODULES)
def test_records_are_our_own(module: str) -> None:
    """Those of the standard library make at each start what nobody may use."""
    wrong = [
        f"line {node.lineno}"
        for node in _nodes(module)
        if isinstance(node, ast.ImportFrom) and node.module == "dataclasses" and module != "vibopt.records"
        if any(one.name == "dataclass" for one in node.names)
    ]
    assert not wrong, f"{module}: import dataclass from vibopt.records"


@pytest.mark.parametrize("library", HOMES)
def test_large_libraries_stay_at_home(library: str) -> None:
    wrong = [
        f"{module} line {line}"
        for module in MODULES
        if not _under(module, HOMES[library])
        for line, imported in _loads(module)
        if _under(imported, (library,))
    ]
    assert not wrong, f"{library} is imported outside {', '.join(HOMES[library])}"


def test_no_file_name_stands_twice() -> None:
    """Whoever opens a file by its name finds the one that is meant."""
    names = Counter(file.name for file in MODULES.values() if file.name != "__init__.py")
    assert [name for name, count in names.items() if count > 1] == []


FORMS_BY_NAME = {
    "vibopt.report.histories": 1,  # draws a peak in time
    "vibopt.solve.catalogue.why": 3,  # words of mounts that are lifted or carry too much
    "vibopt.solve.closed_program": 1,  # its weight and its stiffness are numbers of its own
    "vibopt.solve.rivals.convex_sampled": 2,  # a rival, stated by hand
}
"""How often a module may tell forms apart, and why; everything else asks the form (`vibopt/forms/form.py`)."""


@cache
def _forms() -> set[str]:
    """Names of all kinds of forms, and of what they are made from."""
    from vibopt.forms import FORMS, Form

    return {one.__name__ for kind in (*FORMS.values(), Form) for one in kind.__mro__ if one is not object}


@pytest.mark.parametrize("module", MODULES)
def test_a_method_asks_the_form(module: str) -> None:
    """What it needs of one kind is said beside that kind."""
    names = _forms()
    told = [
        f"line {node.lineno}"
        for node in _nodes(module)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("isinstance", "issubclass")
        if {one.id for one in ast.walk(node.args[1]) if isinstance(one, ast.Name)} & names
    ]
    assert len(told) == FORMS_BY_NAME.get(module, 0), f"{module} tells forms apart: {', '.join(told)}"


@pytest.mark.parametrize("module", MODULES)
def test_no_clock_decides(module: str) -> None:
    """Clocks are read where time is shown, and for the user's own limit; solvers of others get no time limit."""
    if _under(module, AROUND_CLOCKS):
        return
    every = _nodes(module)
    attributes = [node for node in every if isinstance(node, ast.Attribute)]
    reads = [node.attr for node in attributes if node.attr in CLOCKS]
    settings = [node.attr for node in attributes if node.attr == "time_limit" and isinstance(node.ctx, ast.Store)]
    words = [
        node.arg
        for node in every
        if isinstance(node, ast.keyword)
        and node.arg in ("time_limit", "timeout")
        and module != "vibopt.report.sheet.printing"
        if not isinstance(node.value, ast.Name)
    ]
    wall = [text for _, text in _texts(every) if text.endswith("max_wall_time")]
    assert not [*reads, *settings, *words, *wall], f"{module} lets a clock decide"


def test_no_test_reads_a_clock_and_no_example_has_a_deadline() -> None:
    """But one that sets the clocks; and what is timed for its own sake in tests/bench."""
    files = [file for file in (ROOT / "tests").rglob("*.py") if file.parent.name != "bench"]
    reading = {
        file.name
        for file in files
        if any(word in (text := file.read_text(encoding="utf-8")) for word in CLOCKS)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute) and node.attr in CLOCKS
    }
    assert reading <= {"test_work.py", "test_reproducible.py"}
    assert settings().deadline is None


@pytest.mark.parametrize("module", MODULES)
def test_docstrings(module: str) -> None:
    """Modules, public classes, and public functions of more than one statement say what they are for."""
    tree = _parsed(module)
    assert not tree.body or ast.get_docstring(tree), f"{module} has no docstring"
    silent = [
        node.name
        for node in tree.body
        if isinstance(node, ast.ClassDef | ast.FunctionDef)
        if not node.name.startswith("_") and not ast.get_docstring(node)
        if isinstance(node, ast.ClassDef) or len(node.body) > 1
    ]
    assert not silent, f"{module} has public names without a docstring"


@pytest.mark.parametrize(
    "command", [("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy",)], ids=" ".join
)
def test_tool_finds_nothing(command: tuple[str, ...]) -> None:
    if find_spec(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed; pip install vibopt[test] brings it")
    run = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
    found = [line[:300] for line in (run.stdout + run.stderr).splitlines() if ": note:" not in line]
    assert run.returncode == 0, "\n".join(found[-40:])
