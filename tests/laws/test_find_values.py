"""find_all of a value: thousands of sampled values agree with the set, and its ends lie on a bound."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.forms.whirling import WhirlThreshold
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)
MODULUS, SPAN, MASS = 200e9, 0.8, 30.0
PATH = "links.shaft.beam.diameter"


def power(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda e: float(10.0**e))


def document(zeta: float, limits: dict[str, Any], **words: Any) -> dict[str, Any]:
    beam = {"kind": "simply_supported", "length": "0.8 m", "modulus": "200 GPa"}
    return {
        "title": "diameters",
        "bodies": {"disc": {"mass": "30 kg"}},
        "links": {
            "shaft": {
                "between": ["disc", "ground"],
                "beam": {**beam, "diameter": {"from": "5 mm", "to": "200 mm"}},
                "damping_ratio": zeta,
            }
        },
        "excitations": {
            "e": {"kind": "unbalance", "on": "disc", "unbalance": "3 kg mm", "speed": words.pop("speed", "3000 rpm")}
        },
        "limits": limits,
        "goal": {"find_all": PATH},
        **words,
    }


def sampled(zeta: float, diameters: Any) -> tuple[Any, Any, Any]:
    """Whirl [m], stress [Pa] and natural frequency [rad/s] at 3000 rpm."""
    second = np.pi * diameters**4 / 64.0
    k, w = 48.0 * MODULUS * second / SPAN**3, 100.0 * np.pi
    far = 3e-3 * w**2 / np.hypot(k - MASS * w**2, 2.0 * zeta * np.sqrt(k * MASS) * w)
    return far, k * far * SPAN * diameters / (8.0 * second), np.sqrt(k / MASS)


@given(zeta=power(-4, -0.5), whirl=power(-5, -2), stress=power(5.5, 8.5), margin=st.floats(0.01, 0.6))
@few
def test_sampled_values_agree_with_the_set(zeta: float, whirl: float, stress: float, margin: float) -> None:
    rate = 100.0 * np.pi
    band = (1.0 - margin) * rate, (1.0 + margin) * rate
    limits = {
        "whirl": {"response": "displacement", "of": "disc", "at_most": f"{whirl!r} m"},
        "stress": {"response": "bending_stress", "of": "shaft", "at_most": f"{stress!r} Pa"},
        "apart": {"response": "natural_frequency", "outside": f"{band[0]!r}..{band[1]!r} rad/s"},
    }
    design = solve(from_dict(document(zeta, limits)))
    assert design.status == ("met" if design.found else "infeasible")
    diameters = np.geomspace(5e-3, 0.2, 20_001)
    far, bent, own = sampled(zeta, diameters)
    good = (far <= whirl) & (bent <= stress) & ((own <= band[0]) | (own >= band[1]))
    inside, ends = np.zeros(len(good), dtype=bool), [end.value for pair in design.found or () for end in pair]
    for low, high in design.found or ():
        inside |= (diameters >= low.value) & (diameters <= high.value)
    assert all(any(abs(one - end) <= 1e-9 * one for end in ends) for one in diameters[good != inside])
    for end in set(ends) - {5e-3, 0.2}:
        far, bent, own = sampled(zeta, end)
        edges = [far / whirl, bent / stress, own / band[0], own / band[1]]
        assert min(abs(one - 1.0) for one in edges) < 1e-7


def test_a_limit_that_just_holds_at_one_value_leaves_that_value() -> None:
    """Two limits on the same whirl that leave a millionth of a diameter between them, on either side of a resonance."""
    far = sampled(0.02, np.array([0.06, 0.06 * (1.0 + 1e-6)]))[0]
    limits = {
        "most": {"response": "displacement", "of": "disc", "at_most": f"{float(far.max())!r} m"},
        "least": {"response": "displacement", "of": "disc", "at_least": f"{float(far.min())!r} m"},
    }
    found = solve(from_dict(document(0.02, limits))).found or ()
    assert any(low.value <= 0.06 * (1.0 + 1e-6) and high.value >= 0.06 * (1.0 - 1e-9) for low, high in found)
    assert sum(high.value - low.value for low, high in found) < 1e-6


def test_a_resonance_is_found_of_what_a_damper_alone_holds() -> None:
    """Two masses that a damper d locks together are as one: k - m w^2 + i w (c + (m_b w)^2 / d) is force over bound."""
    document = {
        "title": "locked",
        "bodies": {"a": {"mass": {"from": "50 kg", "to": "150 kg"}}, "b": {"mass": "10 kg"}},
        "links": {
            "base": {"between": ["a", "ground"], "stiffness": "1 MN/m", "damping": "0.01 N s/m"},
            "lock": {"between": ["a", "b"], "stiffness": "100 N/m", "damping": "100 MN s/m"},
        },
        "excitations": {"f": {"kind": "force", "on": "a", "amplitude": "10 N", "speed": "96.1 rad/s"}},
        "limits": {"x": {"response": "displacement", "of": "a", "at_most": "300 mm"}},
        "goal": {"find_all": "bodies.a.mass"},
    }
    (first, second) = solve(from_dict(document)).found or ()
    beside = np.sqrt((10.0 / 0.3) ** 2 - (96.1 * (0.01 + 961.0**2 / 1e8)) ** 2)
    for end, way in ((first[1], -1.0), (second[0], 1.0)):
        assert end.value == pytest.approx((1e6 + way * beside) / 96.1**2 - 10.0, rel=1e-9)


SHAFT = 7850.0 * np.pi / 4.0 * 0.3**2 * 0.4


def stiff_rotor(damping: float, masses: tuple[float, float], limit: dict[str, Any]) -> dict[str, Any]:
    """One disc on a shaft that hardly bends, in two bearings of 10 MN/m across and 11 MN/m along."""
    film = {"k_yy": "10 MN/m", "k_zz": "11 MN/m", "c_yy": f"{damping!r} N s/m", "c_zz": f"{damping!r} N s/m"}
    mass = {"from": f"{masses[0]!r} kg", "to": f"{masses[1]!r} kg"}
    return {
        "title": "stiff",
        "rotors": {
            "shaft": {
                "modulus": "207 GPa",
                "density": "7850 kg/m3",
                "sections": [{"length": "400 mm", "diameter": "300 mm"}],
                "stations": {"left": "0 mm", "right": "400 mm"},
                "discs": [{"name": "disc", "at": "200 mm", "mass": mass}],
            }
        },
        "bearings": {f"{end}_film": {"between": [end, "ground"], **film} for end in ("left", "right")},
        "excitations": {"u": {"kind": "unbalance", "on": "disc", "unbalance": "1 kg mm", "speed": "1500 rpm"}},
        "limits": {"limit": limit},
        "goal": {"find_all": "rotors.shaft.discs.1.mass"},
    }


def test_both_resonances_of_a_disc_in_bearings_that_differ_are_found() -> None:
    """Each is wide by 2 sqrt((U w^2 / bound)^2 - (2 c w)^2) / w^2 of mass, about 2 k / w^2 less half a percent."""
    limit = {"response": "displacement", "of": "disc", "at_most": "20 mm"}
    found = solve(from_dict(stiff_rotor(2.0, (300.0, 1500.0), limit))).found or ()
    w = 50.0 * np.pi
    wide = 2.0 * np.sqrt((1e-3 * w**2 / 0.02) ** 2 - (4.0 * w) ** 2) / w**2
    ends = [end.value for pair in found for end in pair]
    assert (ends[0], ends[-1], len(ends)) == (300.0, 1500.0, 6)
    for k, (below, above) in zip((1e7, 1.1e7), (ends[1:3], ends[3:5]), strict=True):
        assert above - below == pytest.approx(wide, rel=1e-2)
        assert 0.5 * (below + above) + SHAFT == pytest.approx(2.0 * k / w**2, rel=1e-3)


@pytest.mark.slow
def test_a_sharp_peak_in_a_narrow_band_is_found() -> None:
    """A peak lies in it for a part of the masses as wide as 6 / 1500; its factor is about 27 there."""
    limit = {"response": "amplification_factor", "of": "disc", "over": "1497..1500 rpm", "at_most": 10}
    found = solve(from_dict(stiff_rotor(2000.0, (560.0, 640.0), limit))).found or ()
    masses = [1e7 * 2.0 / w**2 + 4000.0**2 / 4e7 for w in (np.pi * 50.0, np.pi * 1497.0 / 30.0)]
    assert len(found) == 2
    gap = found[0][1].value, found[1][0].value
    assert gap[1] - gap[0] == pytest.approx(masses[1] - masses[0], rel=1e-2)
    assert gap[0] + SHAFT == pytest.approx(masses[0], rel=2e-3)


def test_a_threshold_of_whirl_is_not_asked_where_the_mass_rules_all_out(monkeypatch: pytest.MonkeyPatch) -> None:
    rotor = stiff_rotor(2000.0, (300.0, 1500.0), {"response": "total_mass", "at_most": "400 kg"})
    rotor["bearings"]["left_film"] |= {"k_yz": "1 MN/m", "k_zy": "-1 MN/m"}
    rotor["limits"]["stable"] = {"response": "stability_threshold", "at_least": "1500 rpm"}
    asked, value = [], WhirlThreshold.value

    def counted(form: WhirlThreshold, model: Any, x: Any) -> float:
        asked.append(x)
        return value(form, model, x)

    monkeypatch.setattr(WhirlThreshold, "value", counted)
    assert solve(from_dict(rotor)).status == "infeasible"
    assert len(asked) < 20  # of 144 looks and more


def test_values_of_a_structure_in_time_are_found() -> None:
    """Half a sine: undamped, the greatest displacement over the static one is known; here of two values of it."""
    document = {
        "title": "pulse",
        "bodies": {"box": {"mass": "1 kg"}},
        "links": {"k": {"between": ["box", "ground"], "stiffness": {"from": "1 N/m", "to": "1000 N/m"}}},
        "excitations": {
            "p": {"kind": "pulse", "on": "box", "shape": "rectangle", "amplitude": "1 N", "duration": "50 s"}
        },
        "limits": {"x": {"response": "peak_displacement", "of": "box", "at_most": "20 mm", }},
        "goal": {"find_all": "links.k.stiffness"},
    }  # fmt: skip
    design = solve(from_dict(document))
    ((low, high),) = design.found or ()
    assert low.value == pytest.approx(100.0, rel=1e-9)  # a long step moves it by twice the static displacement
    assert high.value == 1000.0
    assert [one.ended_by for one in design.details["ends"][0]] == ["x", ""]


def test_both_sides_of_a_limit_end_an_interval() -> None:
    """A shaft below its resonance: the stiffer it is, the less it whirls."""
    whirl = {"response": "displacement", "of": "disc", "at_most": "0.2 mm", "at_least": "0.11 mm"}
    design = solve(from_dict(document(0.02, {"whirl": whirl})))
    assert design.status == "met"
    for two in design.details["ends"]:
        for end in two:
            assert end.ended_by == "whirl" or end.value.value in (5e-3, 0.2)
            far = sampled(0.02, end.value.value)[0]
            assert not end.ended_by or min(abs(far / 2e-4 - 1.0), abs(far / 1.1e-4 - 1.0)) < 1e-7


REFUSED = {
    "another variable": (
        {"bodies": {"disc": {"mass": {"from": "1 kg", "to": "9 kg"}}}},
        "goal.find_all looks for values of links.shaft.beam.diameter of a given machine, but bodies.disc.mass is to be "
        "chosen. Write it as a fact.",
    ),
    "a tolerance": (
        {"bodies": {"disc": {"mass": {"value": "30 kg", "tolerance": "5 %"}}}},
        "goal.find_all looks for values of links.shaft.beam.diameter of a given machine, but bodies.disc.mass has a "
        "tolerance. Remove it, or ask for the best within it.",
    ),
    "no limits": (
        {"limits": {}},
        "goal.find_all needs at least one [limits.NAME] that tells good values from bad ones.",
    ),
    "no such value": (
        {"goal": {"find_all": "links.shaft.beam.length"}},
        'goal.find_all = "links.shaft.beam.length" names no speed and no value to be chosen of this scene. Did you '
        'mean "links.shaft.beam.diameter"?',
    ),
}


@pytest.mark.parametrize(("changes", "words"), REFUSED.values(), ids=REFUSED)
def test_what_has_no_set_is_refused(changes: dict[str, Any], words: str) -> None:
    limits = {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}}
    assert refused(from_dict, {**document(0.05, limits), **changes}).messages == (f"scene: {words}",)


OPEN = {
    "no upper end": ({"from": "5 mm"}, "has no upper end. Add to: find_all looks through a range."),
    "a list": (
        {"one_of": ["5 mm", "8 mm"]},
        "is a list, but find_all looks for intervals. `vibopt sweep` answers each value of it.",
    ),
}


@pytest.mark.parametrize(("given_", "words"), OPEN.values(), ids=OPEN)
def test_a_value_without_a_range_is_refused(given_: dict[str, Any], words: str) -> None:
    made = document(0.05, {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}})
    made["links"]["shaft"]["beam"]["diameter"] = given_
    assert refused(from_dict, made).messages == (f"scene: {PATH} {words}",)


def test_a_value_that_is_set_is_measured(tmp_path: Any) -> None:
    from vibopt.jobs import with_changes

    limits = {"whirl": {"response": "displacement", "of": "disc", "at_most": "1 mm"}}
    design: Design = solve(with_changes(from_dict(document(0.05, limits)), {PATH: "40 mm"}))
    assert design.limits["whirl"].value.value == pytest.approx(sampled(0.05, 0.04)[0], rel=1e-12)
