"""The fewest planes that keep the limits: by rotors whose answer is known, and by hand over all planes alone."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from refusals import refused
from vibopt.cli.main import main
from vibopt.document.mistakes import Mistakes
from vibopt.jobs import answer, of_document, open_job, with_changes
from vibopt.report.modelled_balancing import balancing_document
from vibopt.scene.read import from_dict
from vibopt.study.fewest_planes import fewest_planes

FILE = "problems/balancing/foiles_min_max.toml"
PLANES, SENSORS = ("p0", "p1", "p2", "p3"), ("s0", "s1", "s2", "s3", "s4")


def phasor(value: complex, unit: str) -> str:
    return f"{float(abs(value))!r} {unit} @ {float(np.degrees(np.angle(value)))!r} deg"


def rotor(effects: np.ndarray[Any, Any], found: np.ndarray[Any, Any], at_most: float) -> Any:
    """As found (n_sensors,) [um], effects of 1 g in each plane (n_sensors, n_planes) [um/g]."""
    document = {
        "title": "rotor",
        "conventions": {"phase": "lead", "readings": "phase", "angles": "with rotation", "detector": "pk",
                        "zero": "key"},
        "planes": {name: {"radius": "100 mm"} for name in PLANES},
        "runs": [{"name": "as found", "speed": "3000 rpm",
                  "readings": {name: phasor(one, "um") for name, one in zip(SENSORS, found, strict=True)}}],
        "influence": [{"sensor": sensor, "plane": plane, "value": phasor(effects[i, j], "um/g")}
                      for i, sensor in enumerate(SENSORS) for j, plane in enumerate(PLANES)],
        "limits": {"left": {"response": "residual", "at_most": f"{at_most!r} um"}},
        "goal": {"minimise": "residual", "combine": "worst"},
    }  # fmt: skip
    return of_document(document, Mistakes("rotor.toml", None))


def drawn(seed: int) -> tuple[np.ndarray[Any, Any], np.random.Generator]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(5, 4)) + 1j * rng.normal(size=(5, 4)), rng


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_unbalance_in_two_planes_needs_these_two(seed: int) -> None:
    """Whatever else is near: five readings follow from no other two planes."""
    effects, rng = drawn(seed)
    guilty = sorted(rng.choice(4, 2, replace=False).tolist())
    found = effects[:, guilty] @ (rng.normal(size=2) + 1j * rng.normal(size=2))
    few = fewest_planes(rotor(effects, found, 1e-6 * float(np.abs(found).max())))
    assert few.planes == tuple(PLANES[one] for one in guilty)
    assert set(few.planes) | set(few.untouched) == set(PLANES)
    assert "; 4 sets of fewer planes cannot keep the limits, proven of each; of the 6 sets of as many" in few.words


@pytest.mark.parametrize("seed", [4, 5])
def test_one_plane_is_enough_from_the_least_that_it_leaves_alone(seed: int) -> None:
    """The least worst of each plane alone by a search by hand; a limit just above the least of all names that plane."""
    effects, rng = drawn(seed)
    found = 3.0 * (rng.normal(size=5) + 1j * rng.normal(size=5))

    def alone(plane: int) -> float:
        def worst(u: np.ndarray[Any, Any]) -> float:
            return float(np.abs(found + effects[:, plane] * complex(*u)).max())

        begun = -np.linalg.lstsq(effects[:, [plane]], found, rcond=None)[0][0]
        options = {"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000}
        return float(minimize(worst, [begun.real, begun.imag], method="Nelder-Mead", options=options).fun)

    least = [alone(plane) for plane in range(4)]
    best = int(np.argmin(least))
    assert fewest_planes(rotor(effects, found, 1.0001 * least[best])).planes == (PLANES[best],)
    assert len(fewest_planes(rotor(effects, found, 0.9999 * least[best])).planes) > 1


def test_the_answer_is_that_of_the_file_with_the_others_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    limit = '[limits.left]\nresponse = "residual"\nat_most = "100 um"\n\n[goal]'
    file = tmp_path / "rotor.toml"
    file.write_text(Path(FILE).read_text(encoding="utf-8").replace("[goal]", limit), encoding="utf-8")
    assert main(["solve", str(file), "--fewest-planes"]) == 0
    said = capsys.readouterr().out
    assert "Fewest planes: plane_1, plane_2, plane_4 of 4 planes; 10 sets of fewer" in " ".join(said.split())
    assert "--set planes.plane_3.keep=true" in said
    job = open_job(str(file))
    kept = answer(with_changes(job, fewest_planes(job).changes))
    assert kept.goal is not None
    assert kept.goal[1].shown in said


REFUSED = {
    "as found": (1.1, "as found the rotor keeps every limit: no plane needs a weight. Leave --fewest-planes out to see "
                 "what weights gain."),
    "none": (1e-9, "no planes keep every limit, not all of them. Leave --fewest-planes out: the answer says which "
             "limits cannot hold together."),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_where_no_planes_or_none_at_all_are_enough_it_is_said(case: str) -> None:
    effects, rng = drawn(7)
    found = rng.normal(size=5) + 1j * rng.normal(size=5)
    part, words = REFUSED[case]
    said = refused(fewest_planes, rotor(effects, found, part * float(np.abs(found).max()))).messages
    assert list(said) == [f"rotor.toml: {words}"]


def test_what_has_no_limit_or_no_planes_is_refused() -> None:
    assert list(refused(fewest_planes, open_job(FILE)).messages) == [
        "foiles_min_max.toml: without a limit on what is left no plane is needed. Add [limits.NAME] with response = "
        '"residual" and at_most.'
    ]
    assert list(refused(fewest_planes, open_job("problems/isolation/rao_9_34.toml")).messages) == [
        "rao_9_34.toml: --fewest-planes is of the planes of a rotor or a shaft. Leave it out."
    ]
    assert list(refused(fewest_planes, open_job("problems/balancing/rao_9_14_b_capped.toml")).messages) == [
        "rao_9_14_b_capped.toml: without a limit on what is left no plane is needed. Add [limits.NAME] with response = "
        '"static_unbalance" and at_most.'
    ]


SHAFT = """title = "Shaft with three planes"
[shaft]
bearings = { A = "0 mm", B = "900 mm" }
speed = "1450 rpm"
[masses.blade]
mass = "60 g"
radius = "120 mm"
angle = "30 deg"
at = "300 mm"
[masses.hub]
mass = "25 g"
radius = "70 mm"
angle = "160 deg"
at = "550 mm"
[planes.left]
at = "100 mm"
radius = "110 mm"
[planes.middle]
at = "350 mm"
radius = "110 mm"
[planes.right]
at = "800 mm"
radius = "110 mm"
[limits.bearing]
response = "bearing_reaction"
at_most = "BOUND N"
[goal]
minimise = "correction"
[conventions]
angles = "with rotation"
"""


@pytest.mark.parametrize(("bound", "planes"), [(60.0, 1), (5.0, 2)])
def test_a_shaft_gets_weights_in_as_few_planes_as_keep_its_limits(bound: float, planes: int) -> None:
    """By moments about each bearing: a weight in one plane leaves at least so much at one of them."""
    found = fewest_planes(of_document(tomllib.loads(SHAFT.replace("BOUND", f"{bound:g}")), Mistakes("shaft.toml")))
    speed2, places = (1450.0 * np.pi / 30.0) ** 2, {"left": 0.1, "middle": 0.35, "right": 0.8}
    known = [(60e-3 * 0.12, 30.0, 0.3), (25e-3 * 0.07, 160.0, 0.55)]
    moments = [sum(z * np.exp(1j * np.radians(a)) * (at - about) for z, a, at in known) for about in (0.9, 0.0)]
    loads = np.array([-moments[0], moments[1]]) / 0.9 * speed2

    def alone(at: float) -> float:
        levers = np.array([0.9 - at, at]) / 0.9
        ends = np.array([-loads[k] / levers[k] for k in range(2)])  # the best lies between what frees either bearing
        turns = ends[0] + np.linspace(0.0, 1.0, 20_001) * (ends[1] - ends[0])
        return float(np.abs(loads[:, None] + levers[:, None] * turns).max(axis=0).min())

    least = {name: alone(at) for name, at in places.items()}
    assert (min(least.values()) <= bound) == (planes == 1)
    assert len(found.planes) == planes
    if planes == 1:
        assert least[found.planes[0]] <= bound * (1.0 + 1e-6)
    else:
        assert found.words.endswith(
            "3 sets of fewer planes cannot keep the limits, proven of each; of the 3 sets of as "
            "many the one with the best goal."
        )


def test_a_modelled_turbine_whirls_little_up_to_overspeed_with_weights_on_the_fewest_discs() -> None:
    """The weights are put back onto the model itself, at every speed from rest on."""
    document = tomllib.loads(Path("problems/shafts/three_disc_turbine.toml").read_text(encoding="utf-8"))
    document = {key: table for key, table in document.items() if key not in ("measures", "expected")}
    unbalances = {"first": 9e-4 * np.exp(1.7j), "second": 1.6e-3 * np.exp(0.4j), "third": 7e-4 * np.exp(-2.0j)}
    limits = {name: {"response": "displacement", "of": name, "at_most": "0.005 mm"} for name in unbalances}

    def run(discs: dict[str, complex]) -> Any:
        (first, begun), *others = discs.items()
        also = [
            {"on": name, "unbalance": f"{abs(one):.17g} kg m", "angle": f"{np.degrees(np.angle(one / begun)):.17g} deg"}
            for name, one in others
        ]
        shaken = {"kind": "unbalance", "on": first, "unbalance": f"{abs(begun):.17g} kg m", "also": also}
        excitations = {"imbalance": {**shaken, "speed": "0..6000 rpm"}}
        return answer(from_dict({**document, "limits": limits, "excitations": excitations}))

    before = run(unbalances)
    assert before.status == "violated"
    job = of_document(balancing_document(before), Mistakes("balance.toml", None))
    few = fewest_planes(job)
    assert len(few.planes) == 2
    assert "3 sets of fewer planes cannot keep the limits, proven of each" in few.words
    plan = answer(with_changes(job, few.changes)).plan.entries()
    turned = np.exp(1j * np.angle(unbalances["first"]))  # the job counts angles from the first unbalance
    weighed = {
        name: one
        + (plan[f"planes.{name}.unbalance"].value * np.exp(1j * plan[f"planes.{name}.angle"].value) * turned
           if name in few.planes else 0.0)
        for name, one in unbalances.items()
    }  # fmt: skip
    assert run(weighed).status == "met"


@pytest.mark.parametrize("seed", [6, 7])
def test_planes_of_a_pair_take_weights_both_or_neither(seed: int) -> None:
    """What a couple in p0 and p2 has spoilt is mended by the two; what p1 has, by p1, and the pair stays untouched."""
    effects, rng = drawn(seed)
    unbalance = complex(*rng.normal(size=2))
    for found, planes in (
        (unbalance * (effects[:, 0] - effects[:, 2]), ("p0", "p2")),
        (unbalance * effects[:, 1], ("p1",)),
        (unbalance * (effects[:, 0] - effects[:, 2] + effects[:, 3]), ("p0", "p2", "p3")),
    ):
        job = rotor(effects, found, 1e-6 * float(np.abs(found).max()))
        document = {**job.document, "pairs": {"c": {"planes": ["p0", "p2"], "kind": "couple"}}}
        assert fewest_planes(of_document(document, Mistakes("rotor.toml", None))).planes == planes
