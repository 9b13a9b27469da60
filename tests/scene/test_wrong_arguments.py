"""What public verbs are given by mistake is refused by the name of the argument, in a sentence."""

from __future__ import annotations

import inspect
import pickle
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.arguments import KINDS

PROBLEMS = Path(__file__).parents[2] / "problems"
PRESS = PROBLEMS / "isolation" / "rao_9_34.toml"
ROTOR = PROBLEMS / "balancing" / "rao_9_14_b_capped.toml"
verbs: Any = vo
VERBS = [name for name in sorted(vo._HOME_OF) if isinstance(getattr(vo, name), FunctionType)]
WRONG: tuple[Any, ...] = (3, None, "missing", b"x", [], {}, [3], {3: 4}, {"a": 1}, 1.5, True, object(), len)
OWN = ("Bound", "Measure", "Pool", "many.Answered", "Any", "Sequence[Point]")
"""Kinds that a verb tells apart itself, or that are for the command line."""


def parameters(name: str) -> dict[str, inspect.Parameter]:
    return dict(inspect.signature(getattr(vo, name)).parameters)


@pytest.mark.parametrize("name", VERBS)
def test_every_parameter_has_a_kind_that_is_looked_at(name: str) -> None:
    kinds = {str(one.annotation).removesuffix(" | None") for one in parameters(name).values()}
    assert {kind for kind in kinds if not kind.startswith(OWN)} <= set(KINDS)


@pytest.mark.parametrize("name", [name for name in VERBS if name not in ("choose", "find_all", "one_of")])
def test_what_is_no_argument_is_refused_in_a_sentence(name: str) -> None:
    for given in WRONG:
        with pytest.raises((TypeError, vo.InputError)) as said:
            getattr(vo, name)(given, *[given] * (len(needed(name)) - 1))
        assert str(said.value).endswith("."), given


def needed(name: str) -> list[str]:
    return [key for key, one in parameters(name).items() if one.default is inspect.Parameter.empty]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda job: verbs.sweep(3, "a", "1..2"), "int is no job. Take one from vibopt.read, or make a scene."),
        (lambda job: verbs.sweep(job, 3), 'vibopt.sweep(vary=...): int is no path, and no ranges by their paths. Write '
         '"bodies.press.mass", or {"bodies.press.mass": "290..310 kg"}.'),
        (lambda job: verbs.sweep(job, "bodies.press.mass", "1..2 kg", 2.5),
         "vibopt.sweep(points=...): float is no whole number."),
        (lambda job: verbs.sweep(job, "bodies.press.mass", "290..310 kg", 2, sample="random"),
         '--sample random: is no way to draw points. Write "sobol" or "latin".'),
        (lambda job: verbs.read(3), 'vibopt.read(path=...): int is no name of a file. Write "press.toml".'),
        (lambda job: verbs.with_changes(job, ["a"]), "vibopt.with_changes(changes=...): list is no values by their "
         'paths. Write {"bodies.press.mass": "310 kg"}.'),
        (lambda job: verbs.whatif(job, {}, rounding="3"), "vibopt.whatif(rounding=...): str is no list of texts. Write "
         '["one", "other"].'),
        (lambda job: verbs.compare([job, job]), "vibopt.compare(jobs=...): list is no jobs by their names. Write "
         '{"A": vibopt.read("a.toml"), "B": other}.'),
        (lambda job: verbs.explain(job, thorough="yes"),
         "vibopt.explain(thorough=...): str is neither True nor False."),
        (lambda job: verbs.solve(job, time_limit=-1.0),
         "time_limit = -1.0 is no number of seconds above zero. Write time_limit=5."),
        (lambda job: verbs.prices(job, found=job),
         "vibopt.prices(found=...): Scene is no answer. Take one from vibopt.solve."),
        (lambda job: verbs.shock_spectrum(vo.read(ROTOR)), "vibopt.shock_spectrum(scene=...): KnownJob is no scene. "
         "Take one from vibopt.read of a machine, or make one with vibopt.Machine."),
        (lambda job: verbs.Machine("a").device(3, "b"), '"3" is no family of devices. Known: bodies, bases, '
         "structures, rotors, absorbers, links, bearings, inerters, points, mounts."),
        (lambda job: verbs.Limit(3), 'Limit(3): this is no table. Write machine.displacement(of="press") <= "2 mm".'),
    ],
)  # fmt: skip
def test_the_argument_and_the_way_out_are_named(call: Any, message: str) -> None:
    with pytest.raises((TypeError, vo.InputError)) as said:
        call(vo.read(PRESS))
    assert str(said.value) == message


def test_what_is_as_good_as_the_kind_is_taken() -> None:
    spectrum = vo.shock_spectrum(
        vo.read(PROBLEMS / "shock" / "rao_9_49.toml"), damping=np.array([0.1]), frequencies=(1, 2)
    )
    assert spectrum.ratios.tolist() == [0.1]
    assert vo.from_text(vo.to_toml(vo.read(PRESS))).document == vo.read(str(PRESS)).document
    assert pickle.loads(pickle.dumps(vo.solve)) is vo.solve
    assert (vo.solve.__name__, vo.solve.__module__, vo.solve.__doc__ is not None) == ("solve", "vibopt", True)


@pytest.mark.parametrize("name", VERBS)
def test_a_call_that_does_not_fit_is_told_by_the_name_that_was_called(name: str) -> None:
    if needed(name) and name != "one_of":
        with pytest.raises(TypeError, match=rf"^vibopt\.{name}\(\) missing"):
            getattr(vo, name)()


def test_an_argument_that_there_is_not_is_told_by_the_name_that_was_called() -> None:
    with pytest.raises(TypeError, match=r"^vibopt\.solve\(\) got an unexpected keyword argument 'metod'"):
        verbs.solve(vo.read(ROTOR), metod="cvxpy")
