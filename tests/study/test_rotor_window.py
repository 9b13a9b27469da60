"""Windows of measured rotors: ends and discs against descents that know of no cone, and corners that break a limit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import vibopt as vo
from refusals import refused
from vibopt.balancing.contradictions import heard
from vibopt.cli.main import main

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
FAN = (PROBLEMS / "fan_verification_run.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
LIMIT = '[limits.rest]\nresponse = "residual"\nat_most = "{} mil pp"\n'


def fan(bound: float, more: str = "", text: str = FAN) -> str:
    return f"{text}{LIMIT.format(bound)}{more}"


def room(text: str) -> tuple[np.ndarray, np.ndarray]:
    """y0 and H over the limit, of a gram in each plane."""
    of = heard(vo.from_text(text))
    bound = of.job.residual_limits[0].at_most
    return of.identified.y0 / bound, of.identified.H * 0.15e-3 / bound


def descended(cost, bounds, starts) -> float:
    """The least cost of plans (re, im, ...) [g] with bounds(x) >= 0, from several starts."""
    found = np.inf
    for x in starts:
        end = minimize(cost, x, constraints=[{"type": "ineq", "fun": bounds}], method="SLSQP", options={"ftol": 1e-12})
        if np.min(bounds(end.x)) > -1e-6:
            found = min(found, float(end.fun))
    return found


@settings(max_examples=8, deadline=None)
@given(st.floats(1.0, 4.0), st.floats(10.0, 30.0))
def test_ends_and_the_greatest_part_are_those_of_descents(bound: float, cap: float) -> None:
    text = fan(bound).replace('to = "60 g"', f'to = "{cap!r} g"')
    window = vo.window(vo.from_text(text))
    y0, H = room(text)
    n = H.shape[1]
    best = np.linalg.lstsq(H, -y0, rcond=None)[0]
    dice = np.random.default_rng(3)
    plans = [best * (1.0 + 0.2 * (dice.standard_normal(n) + 1j * dice.standard_normal(n))) for _ in range(2)]
    starts = [np.concatenate([u.real, u.imag]) for u in [best, *plans]]

    def keeps(x: np.ndarray, part: float = 0.0) -> np.ndarray:
        u = x[:n] + 1j * x[n : 2 * n]
        left = np.abs(y0 + H @ u) + part * np.abs(H) @ np.abs(u)
        return np.concatenate([1.0 - left, 1.0 - (1.0 + part) * np.abs(u) / cap])

    for k, name in enumerate(("left", "right")):
        span = next(one for one in window.spans if one.path == f"planes.{name}.mass")
        ((low, high),) = span.intervals
        assert span.proven
        least = descended(lambda x, k=k: float(np.hypot(x[k], x[n + k])), keeps, starts)
        most = -descended(lambda x, k=k: -float(np.hypot(x[k], x[n + k])), keeps, starts)
        assert low.value * 1e3 == pytest.approx(least, rel=1e-4, abs=1e-3)
        assert high.value * 1e3 == pytest.approx(most, rel=1e-4)
    assert window.proven
    centre = [window.centre[f"planes.{name}.mass"].value * 1e3 for name in ("left", "right")]
    angles = [window.centre[f"planes.{name}.angle"].value for name in ("left", "right")]
    u = np.array(centre) * np.exp(-1j * np.array(angles))  # angles are counted against rotation
    assert borne(y0, H, cap, u) == pytest.approx(window.part, rel=1e-5)
    for start in [u, *plans]:
        x = np.concatenate([start.real, start.imag])
        end = minimize(lambda x: -borne(y0, H, cap, x[:n] + 1j * x[n:]), x, method="Nelder-Mead")
        assert -end.fun <= window.part * (1.0 + 1e-5)


def borne(y0: np.ndarray, H: np.ndarray, cap: float, u: np.ndarray) -> float:
    """By which part each weight may be off, by the triangle inequality, which is met in the worst direction."""
    rows = (1.0 - np.abs(y0 + H @ u)) / (np.abs(H) @ np.abs(u))
    return float(min(rows.min(), (cap / np.abs(u) - 1.0).min(), 0.5))


def test_within_the_discs_every_plan_is_permitted_and_beyond_them_a_corner_breaks_a_limit() -> None:
    job = vo.from_text(fan(2.0))
    window = vo.window(job)
    names, dice = ("left", "right"), np.random.default_rng(1)

    def solved(part: float, turns: np.ndarray) -> str:
        changes = {}
        for name, turn in zip(names, turns, strict=True):
            size, angle = (window.centre[f"planes.{name}.{key}"].value for key in ("mass", "angle"))
            u = size * np.exp(1j * angle) * (1.0 + part * np.exp(1j * turn))
            changes[f"planes.{name}.weight"] = f"{abs(u):.17g} kg @ {np.degrees(np.angle(u)) % 360.0:.17g} deg"
        return vo.solve(vo.with_changes(job, changes), explain=False).status

    turns = dice.uniform(0.0, 2.0 * np.pi, (12, 2))
    assert {solved(window.part, one) for one in turns} == {"met"}
    around = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    wide = [solved(1.05 * window.part, np.array([one, other])) for one in around for other in around]
    assert "violated" in wide
    assert window.around <= window.part
    for span in window.spans:
        ((low, high),) = span.intervals
        assert low.value <= window.centre[span.path].value <= high.value


def test_every_angle_is_permitted_where_no_weight_is_needed() -> None:
    window = vo.window(vo.from_text(fan(9.0)))
    spans = {span.path: span.intervals[0] for span in window.spans}
    for name in ("left", "right"):
        low, high = spans[f"planes.{name}.angle"]
        assert high.value - low.value == pytest.approx(2.0 * np.pi)
        assert spans[f"planes.{name}.mass"][0].value == pytest.approx(0.0, abs=1e-9)


def test_weights_that_are_decided_stay_and_those_beside_them_have_the_window_that_is_left() -> None:
    text = fan(3.0, '[limits.total]\nresponse = "correction"\ntotal = true\nat_most = "20 g"\n')
    right = '[planes.right]\nradius = "150 mm"\nweight = '
    decided = text.replace(f'{right}{{ from = "0 g", to = "60 g" }}', f'{right}"6 g @ 65 deg"')
    window = vo.window(vo.from_text(decided))
    assert [span.path for span in window.spans] == ["planes.left.mass", "planes.left.angle"]
    y0, H = room(text)
    y0, effect = y0 + H[:, 1] * 6.0 * np.exp(-1j * np.radians(65.0)), H[:, 0]
    sizes = np.linspace(0.0, 14.0, 1401)
    grid = sizes[:, None] * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 1441))[None, :]
    good = (np.abs(y0[:, None, None] + effect[:, None, None] * grid) <= 1.0).all(axis=0)
    inside = np.flatnonzero(good.any(axis=1))
    ((low, high),) = window.spans[0].intervals
    assert low.value * 1e3 == pytest.approx(sizes[inside[0]], abs=0.02)
    assert high.value * 1e3 == pytest.approx(sizes[inside[-1]], abs=0.02)


def test_the_window_of_a_rotor_is_said_word_for_word(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "fan.toml"
    file.write_text(fan(2.0), encoding="utf-8")
    assert main(["window", str(file)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    percent = said.partition(" % on both")[0].rpartition("±")[2]
    assert f"±{percent} % on both weights in any direction, alone ±{percent} % in size or ±" in said
    assert "deg, around the centre is safe. Box: proven for every design within it. Least and greatest" in said
    assert "Every value between them is permitted, with weights in the other planes that go with it." in said


INSTEAD = "vibopt sweep FILE --keep-design --vary PATH=RANGE shows what each may be."
OF = "job: window is for weights of any size and angle, and"


@pytest.mark.parametrize(("old", "new", "said"), [
    ('weight = { from = "0 g", to = "60 g" }\n\n[[runs]]', 'holes = 24\nshelf = ["5 g"]\n\n[[runs]]',
     f"{OF} planes.right has holes, a list, sectors or a split. {INSTEAD}"),
    (LIMIT.format(2.0), "", "job: window needs limits on what is left: without any every weight is permitted."),
    ('at_most = "2.0 mil pp"', 'at_most = "2.0 mil pp"\nwith_probability = "90 %"',
     f"{OF} a limit asks for a probability. {INSTEAD}"),
    ('to = "60 g"', 'to = "2 g"',
     "job: there is no permitted design (proven). vibopt explain says which limits clash."),
])  # fmt: skip
def test_what_has_no_window_is_refused_word_for_word(old: str, new: str, said: str) -> None:
    text = fan(2.0)
    assert old in text
    assert refused(vo.window, vo.from_text(text.replace(old, new))).messages == (said,)


@pytest.mark.parametrize(("kind", "side", "bound"), [("static", 1.0, 8.0), ("couple", -1.0, 9.0)])
def test_weights_of_a_pair_have_one_window_and_are_off_each_by_itself(kind: str, side: float, bound: float) -> None:
    """On a grid of the one number that both are; the left one, at a smaller radius, has the heavier weight."""
    text = fan(bound).replace('radius = "150 mm"', 'radius = "100 mm"', 1)
    window = vo.window(vo.from_text(f'{text}[pairs.both]\nplanes = ["left", "right"]\nkind = "{kind}"\n'))
    assert [span.path for span in window.spans] == [
        f"planes.{one}.{key}" for one in ("left", "right") for key in ("mass", "angle")
    ]
    y0, H = room(fan(bound))  # of a gram in each plane, at whichever radius its trial weight was
    ratio = np.array([1.0, side * 100.0 / 150.0])
    sizes, turns = np.linspace(0.0, 60.0, 1201), np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    grid = sizes[:, None] * np.exp(1j * turns)
    good = (np.abs(y0[:, None, None] + (H @ ratio)[:, None, None] * grid) <= 1.0).all(axis=0)
    inside = np.flatnonzero(good.any(axis=1))
    for name, part in zip(("left", "right"), np.abs(ratio), strict=True):
        ((low, high),) = next(span for span in window.spans if span.path == f"planes.{name}.mass").intervals
        ends = [1e3 * low.value, 1e3 * high.value]
        assert ends == pytest.approx([part * sizes[inside[0]], part * sizes[inside[-1]]], abs=0.1)
    mass, angle = (
        [window.centre[f"planes.{one}.{key}"].value for one in ("left", "right")] for key in ("mass", "angle")
    )
    u = 1e3 * np.array(mass) * np.exp(-1j * np.array(angle))  # angles are counted against rotation
    assert u[1] == pytest.approx(u[0] * ratio[1], rel=1e-9)
    with np.errstate(divide="ignore"):
        rows = (1.0 - np.abs(y0[:, None, None] + (H @ ratio)[:, None, None] * grid)) / (
            (np.abs(H) @ np.abs(ratio))[:, None, None] * np.abs(grid)
        )
    assert borne(y0, H, 60.0, u) == pytest.approx(window.part, rel=1e-5)
    best = np.minimum(np.minimum(rows.min(axis=0), 60.0 / np.maximum(np.abs(grid), 1e-9) - 1.0), 0.5).max()
    assert best <= window.part * (1.0 + 1e-5)
