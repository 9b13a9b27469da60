"""Balancing problems solved a second time, without vibopt.

Every answer recorded in ``problems/balancing/*.toml`` is found here on another road: triangles and levers in 40 digits
instead of linear solves, full enumeration instead of branch and bound, a general-purpose descent instead of cones,
pistons moved through a turn in time instead of a series.  Each weight is put back into the equations before it is
returned.  All results are in SI units: kg, kg m, kg m², m, N, N m; angles in rad from 0 to 2 pi; amplitudes are peak.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import combinations, permutations, product
from typing import Any

import numpy as np
from mpmath import acos, arg, cos, exp, findroot, mp, mpc, mpf, pi, sin, sqrt

mp.dps = 40

Real = Any  # mpmath's numbers have no static types
Answers = dict[str, Any]


# --- vectors ---------------------------------------------------------------------------------


def deg(angle: float | str) -> Real:
    """Degrees in radians."""
    return mpf(angle) * pi / 180


def turned(angle: Real) -> Real:
    """An angle from 0 to below 2 pi."""
    rest = angle % (2 * pi)
    return mpf(0) if 2 * pi - rest < mpf(10) ** -20 else rest


def vector(size: float | str, angle: float | str) -> Real:
    """A phasor from its size and its angle in degrees."""
    return mpf(size) * exp(mpc(0, deg(angle)))


def rpm(speed: float | str) -> Real:
    """Angular speed in rad/s."""
    return mpf(speed) * 2 * pi / 60


def zero(value: Real, size: Real) -> None:
    """What is put back must vanish."""
    assert abs(value) < mpf(10) ** -25 * abs(size), value


def weight(path: str, z: Real, radius: float | str | None = None, *, removed: bool = False) -> Answers:
    """Unbalance, mass and angle of a correction z that is added; where material goes, of the hole."""
    found: Answers = {f"{path}.angle": turned(arg(-z if removed else z))}
    if radius is not None:
        found[f"{path}.mass"] = abs(z) / mpf(radius)
    else:
        found[f"{path}.unbalance"] = abs(z)
    return found


# --- known masses ----------------------------------------------------------------------------

Points = Sequence[tuple[Real, Real]]
"""(unbalance, place along the shaft)."""


def one_plane(unbalances: Iterable[Real]) -> Real:
    """The closing side of the polygon of unbalances, in real components."""
    listed = list(unbalances)
    x = -sum(abs(u) * cos(arg(u)) for u in listed)
    y = -sum(abs(u) * sin(arg(u)) for u in listed)
    zero(sum(listed) + mpc(x, y), sum(abs(u) for u in listed))
    return mpc(x, y)


def two_planes(points: Points, first: Real, second: Real) -> tuple[Real, Real]:
    """Each correction from the moments about the plane of the other, then both put back."""
    one = -sum(u * (z - second) for u, z in points) / (first - second)
    two = -sum(u * (z - first) for u, z in points) / (second - first)
    size = sum(abs(u) for u, _ in points)
    zero(sum(u for u, _ in points) + one + two, size)
    zero(sum(u * z for u, z in points) + one * first + two * second, size)
    return one, two


def bearing_forces(points: Points, first: Real, second: Real, speed: Real) -> tuple[Real, Real]:
    """Forces of two bearings on the shaft: they are what corrections in their own planes would do."""
    one, two = two_planes(points, first, second)
    return one * speed**2, two * speed**2


def balanced() -> Answers:
    """What is left of a balanced shaft."""
    return {"residual.static": mpf(0), "residual.couple": mpf(0)}


def rao_9_3() -> Answers:
    masses = [vector(35 * mpf("0.11"), 40), vector(15 * mpf("0.09"), 220), vector(25 * mpf("0.13"), 290)]
    return {**weight("planes.disc", one_plane(u / 1000 for u in masses)), "residual.static": mpf(0)}


def rao_9_4() -> Answers:
    holes = [vector("0.01", 0), vector("0.01", 60), vector("0.015", 120), vector("0.015", 180)]
    fifth = one_plane(-u for u in holes)
    return weight("planes.fifth", fifth, "0.12", removed=True)


def rao_9_5() -> Answers:
    masses = [vector("0.5", 10), vector("0.7", 100), vector("1.2", 190)]
    return weight("planes.rim", one_plane(masses), 1)


RAO_9_10 = ((vector("0.02", 30), mpf("0.1")), (vector("0.03", 135), mpf("0.25")), (vector("0.025", 250), mpf("0.4")))


def rao_9_10() -> Answers:
    a, b = two_planes(RAO_9_10, mpf(0), mpf("0.5"))
    return {**weight("planes.A", a), **weight("planes.B", b), **balanced()}


def rao_9_11() -> Answers:
    mass = mpf("0.008")
    points = [(mass * exp(mpc(0, deg(a))), mpf(0)) for a in (90, -60)]
    points += [(mass * exp(mpc(0, deg(a))), mpf("0.6")) for a in (120, -120)]
    # what the temporary masses did, the holes must do: masses off, so their negatives are what is out of balance
    b, c = two_planes([(-u, z) for u, z in points], mpf("0.1"), mpf("0.5"))
    return {**weight("planes.B", b, "0.1", removed=True), **weight("planes.C", c, "0.1", removed=True)}


RAO_9_12 = ((vector("0.5", 90), mpf("0.2")), (vector("1.6", 220), mpf(1)), (vector("0.45", -30), mpf("1.6")))


def rao_9_12() -> Answers:
    a, g = two_planes(RAO_9_12, mpf("-0.4"), mpf("2.2"))
    return {**weight("planes.A", a, "0.5"), **weight("planes.G", g, "0.5"), **balanced()}


RAO_9_14 = ((vector("0.004", 0), mpf("0.2")), (vector("0.001", 120), mpf("0.3")), (vector("0.0024", 200), mpf("0.9")))


RAO_9_14_HALF = (RAO_9_14[0], (RAO_9_14[1][0], mpf("0.5")), RAO_9_14[2])


def reactions(points: Points) -> Answers:
    """Reactions of the bearings of problem 9.14."""
    a, b = bearing_forces(points, mpf(0), mpf("1.1"), rpm(1000))
    return {
        "as_found.bearings.A.reaction": abs(a),
        "as_found.bearings.A.angle": turned(arg(a)),
        "as_found.bearings.B.reaction": abs(b),
        "as_found.bearings.B.angle": turned(arg(b)),
    }


def bearing_weights(points: Points) -> Answers:
    """Weights in the planes of the bearings of problem 9.14."""
    left, right = two_planes(points, mpf(0), mpf("1.1"))
    gone = {"residual.bearings.A.reaction": mpf(0), "residual.bearings.B.reaction": mpf(0)}
    return {**weight("planes.L", left, "0.25"), **weight("planes.R", right, "0.25"), **gone}


def rao_9_14_a() -> Answers:
    return reactions(RAO_9_14)


def rao_9_14_a_half_metre() -> Answers:
    return reactions(RAO_9_14_HALF)


def rao_9_14_b() -> Answers:
    return bearing_weights(RAO_9_14)


def rao_9_14_b_half_metre() -> Answers:
    return bearing_weights(RAO_9_14_HALF)


def rao_9_14_b_capped() -> Answers:
    """Each weight acts on its own bearing alone: the heavier one stops at its cap, in its direction."""
    left, right = two_planes(RAO_9_14, mpf(0), mpf("1.1"))
    short = abs(left) - mpf("0.008") * mpf("0.25")
    return {
        "planes.L.mass": mpf("0.008"),
        "planes.L.angle": turned(arg(left)),
        **{path: one for path, one in weight("planes.R", right, "0.25").items() if not path.endswith("unbalance")},
        "residual.bearings.A.reaction": short * rpm(1000) ** 2,
    }


ASSIGNMENT_2 = ((vector("0.05", 90), mpf("0.2")), (vector("0.225", 220), mpf(1)), (vector("0.05", 330), mpf("1.6")))


def assignment_2() -> Answers:
    a, g = two_planes(ASSIGNMENT_2, mpf("-0.4"), mpf("2.2"))
    return {**weight("planes.A", a, "0.05"), **weight("planes.G", g, "0.05"), **balanced()}


FAN_SHAFT = ((vector("0.012", 20), mpf("0.15")), (vector("0.009", 200), mpf("0.45")), (vector("0.006", 75), mpf("0.7")))


def shaft_three_planes() -> Answers:
    """Least mass over all corrections that balance: stationary in the two numbers that stay free."""
    places, radii = (mpf("0.05"), mpf("0.4"), mpf("0.85")), (mpf("0.1"), mpf("0.16"), mpf("0.1"))

    def corrections(x: Real, y: Real) -> list[Real]:
        middle = mpc(x, y)
        one, other = two_planes([*FAN_SHAFT, (middle, places[1])], places[0], places[2])
        return [one, middle, other]

    def total(x: Real, y: Real) -> Real:
        return sum(abs(u) / r for u, r in zip(corrections(x, y), radii, strict=True))

    def slope(x: Real, y: Real) -> tuple[Real, Real]:
        first = -(places[1] - places[2]) / (places[0] - places[2])
        share = [first, 1, -1 - first]
        unit = sum(s * u / abs(u) / r for s, u, r in zip(share, corrections(x, y), radii, strict=True))
        return unit.real, unit.imag

    start = _descend(lambda v: float(total(mpf(v[0]), mpf(v[1]))), np.array([-1e-3, -1e-3]))
    x, y = findroot(slope, (mpf(start[0]), mpf(start[1])))
    found = corrections(x, y)
    answers = {"goal": total(x, y)}
    for name, u, r in zip("PQR", found, radii, strict=True):
        answers.update(weight(f"planes.{name}", u, r))
    return answers


def _descend(value: Callable[[Any], float], start: Any) -> Any:
    """A general-purpose descent, run twice."""
    from scipy.optimize import minimize

    options: Any = {"xatol": 1e-12, "fatol": 1e-14, "maxiter": 4000}
    first = minimize(value, start, method="Nelder-Mead", options=options)
    return minimize(value, first.x, method="Nelder-Mead", options=options).x


def shaft_holes() -> Answers:
    """Every filling of both planes: 16 holes, up to two weights a plane, judged by force and couple alike."""
    holes, shelf = [22.5 * k for k in range(16)], (0.02, 0.05, 0.1)
    single = [(0.1 * m * np.exp(1j * np.radians(a)), m, k) for k, a in enumerate(holes) for m in shelf]
    fillings = [(0j, 0.0)] + [(u, m) for u, m, _ in single]
    fillings += [(u + v, m + n) for (u, m, i), (v, n, j) in combinations(single, 2) if i != j]
    options = np.array([u for u, _ in fillings])
    known = [(complex(u), float(z)) for u, z in FAN_SHAFT]
    static = sum(u for u, _ in known)
    couple = sum(u * (z - 0.45) for u, z in known)
    best = np.inf
    for u in options:
        left = np.abs(static + u + options) ** 2 + np.abs((couple - 0.4 * u + 0.4 * options) / 0.45) ** 2
        k = int(np.argmin(left))
        if left[k] < best - 1e-15:
            best, chosen = float(left[k]), (u, options[k])
    one, other = chosen
    return {
        "residual.static": abs(static + one + other),
        "residual.couple": abs(couple - 0.4 * one + 0.4 * other),
    }


# --- one measured plane ----------------------------------------------------------------------


def triangle(found: Real, with_trial: Real, trial: Real, *, mirrored: bool) -> Real:
    """The correction from the triangle of readings: the law of cosines for its angle, trial and error for its side.

    `mirrored`: readings are positions of the mark, which moves against the weight.
    """
    original, resultant = abs(found), abs(with_trial)
    effect = sqrt(original**2 + resultant**2 - 2 * original * resultant * cos(arg(with_trial) - arg(found)))
    alpha = acos((original**2 + effect**2 - resultant**2) / (2 * original * effect))
    size = abs(trial) * original / effect
    change = with_trial - found
    for side in (1, -1):
        moved = exp(mpc(0, side * alpha)) * original / effect
        if abs(found + change * moved) < mpf(10) ** -25 * original:
            return size * exp(mpc(0, arg(trial) - side * alpha if mirrored else arg(trial) + side * alpha))
    raise AssertionError("no side of the triangle balances")


def rao_9_6() -> Answers:
    return weight("planes.wheel", triangle(vector("0.2", 40), vector("0.5", 150), vector("0.2", -65), mirrored=True), 1)


def rao_9_7() -> Answers:
    found = triangle(vector("0.15", -15), vector("0.22", 35), vector("0.05", 45), mirrored=True)
    return weight("planes.flywheel", found, 1)


def rao_9_8() -> Answers:
    return weight("planes.wheel", triangle(vector("0.1", 45), vector("0.2", 145), vector("0.1", -20), mirrored=True), 1)


def assignment_1() -> Answers:
    found = triangle(vector("0.165", -15), vector("0.225", 35), vector("0.05", 45), mirrored=True)
    return weight("planes.flywheel", found, 1)


def assignment_1_phases() -> Answers:
    return weight(
        "planes.flywheel", triangle(vector("0.165", -15), vector("0.225", 35), vector("0.05", 45), mirrored=False), 1
    )


def rao_9_9() -> Answers:
    """At resonance the displacement is a quarter turn behind the force: x'' + x' + x = cos(t) has x = sin(t)."""
    heavy = deg(229) + deg(90)
    return {"planes.rotor.angle": turned(heavy)}


def fan_16_blades() -> Answers:
    """The weight between two blades, cut in two along their directions."""
    u = triangle(vector("4.81", "16.8"), vector("4.7628", "299.9"), vector("0.10325", 0), mirrored=False)
    low, high = deg("292.5"), deg(315)
    first = abs(u) * sin(high - arg(u)) / sin(high - low)
    second = abs(u) * sin(arg(u) - low) / sin(high - low)
    zero(first * exp(mpc(0, low)) + second * exp(mpc(0, high)) - u, u)
    return {
        "planes.fan.acts_as": abs(u),
        "planes.fan.mass": first + second,
        "planes.fan.angle": turned(arg(u)),
        "halves": (first, second),
    }


# --- two measured planes ---------------------------------------------------------------------

RAO_9_13 = {
    "found": (vector(5, 100), vector(4, 180)),
    "left": (vector("6.5", 120), vector("4.5", 140)),
    "right": (vector(6, 90), vector(7, 60)),
}


def two_by_two(
    found: Sequence[Real], first: Sequence[Real], second: Sequence[Real], trials: Sequence[Real]
) -> tuple[Real, Real]:
    """Cramer's rule, then the weights put back at both sensors."""
    a, b = [(t - f) / trials[0] for f, t in zip(found, first, strict=True)]
    c, d = [(t - f) / trials[1] for f, t in zip(found, second, strict=True)]
    whole = a * d - b * c
    one, two = (found[1] * c - found[0] * d) / whole, (found[0] * b - found[1] * a) / whole
    zero(found[0] + a * one + c * two, found[0])
    zero(found[1] + b * one + d * two, found[1])
    return one, two


def rao_9_13() -> Answers:
    ounce = mpf("0.028349523125")
    trials = (2 * ounce * exp(mpc(0, deg(30))), 2 * ounce)
    left, right = two_by_two(RAO_9_13["found"], RAO_9_13["left"], RAO_9_13["right"], trials)
    found = {**weight("planes.left", left, 1), **weight("planes.right", right, 1)}
    for side, turn in (("left", deg(30)), ("right", mpf(0))):
        for sensor, before, after in zip("AB", RAO_9_13["found"], RAO_9_13[side], strict=True):
            found[f"influence.{sensor}.{side}.angle"] = turned(arg(after - before) - turn)
    return found


BK = {"found": (vector(170, 112), vector(53, 78)), "one": (vector(235, 94), vector(58, 68))}


def bk_17_227() -> Answers:
    trial = mpf("0.00115")
    one, two = two_by_two(BK["found"], BK["one"], (vector(189, 115), vector(77, 104)), (trial, trial))
    return {**weight("planes.plane_1", one, 1), **weight("planes.plane_2", two, 1)}


def bk_17_227_misprint() -> Answers:
    trial = mpf("0.00115")
    one, two = two_by_two(BK["found"], BK["one"], (vector(185, 115), vector(77, 104)), (trial, trial))
    return {**weight("planes.plane_1", one, 1), **weight("planes.plane_2", two, 1)}


def _numbers(rows: Iterable[str]) -> Any:
    """Complex numbers from "5.4@24" texts."""
    table = []
    for row in rows:
        pairs = [one.split("@") for one in row.split()]
        table.append([float(size) * np.exp(1j * np.radians(float(angle))) for size, angle in pairs])
    return np.array(table)


def bk_17_227_holes() -> Answers:
    """All 24 holes x 5 weights x 2 planes, and empty planes; least worst reading."""
    y0 = np.array([complex(v) for v in BK["found"]])
    trial = [complex(v) for v in BK["one"]], [complex(v) for v in (vector(189, 115), vector(77, 104))]
    effect = np.array([(np.array(t) - y0) / 1.15 for t in trial]).T
    shelf = (0.25, 0.5, 1.0, 1.5, 2.0)
    options = np.array([0.0, *[m * np.exp(1j * np.radians(15.0 * k)) for k, m in product(range(24), shelf)]])
    left = y0[:, None, None] + effect[:, :1, None] * options[:, None] + effect[:, 1:, None] * options
    worst = np.abs(left).max(axis=0)
    i, j = np.unravel_index(int(np.argmin(worst)), worst.shape)
    assert np.sort(worst.ravel())[1] > worst[i, j] * (1.0 + 1e-6)
    found = {"goal": worst[i, j] * 1e-3}
    for name, k in (("plane_1", i), ("plane_2", j)):
        found[f"planes.{name}.mass"] = abs(options[k]) * 1e-3
        found[f"planes.{name}.angle"] = float(np.angle(options[k]) % (2.0 * np.pi))
    return found


FEESE = _numbers(
    (
        "0.68@32 1.31@1 0.54@9",
        "0.56@86 1.25@75 0.52@75",
        "1.94@231 0.93@251 0.81@196",
        "2.07@335 1@342 0.9@296",
    )
)
"""As found, with the aft trial, with both trials; a row per reading."""


def feese_effects() -> tuple[Any, Any]:
    """As found, and the effect of a gram in each plane; the aft trial stayed on in the last run."""
    aft, forward = 11.1 * np.exp(1j * np.radians(35.0)), 3.7 * np.exp(1j * np.radians(135.0))
    effect = np.column_stack([(FEESE[:, 1] - FEESE[:, 0]) / aft, (FEESE[:, 2] - FEESE[:, 1]) / forward])
    return FEESE[:, 0], effect


def feese_two_planes() -> Answers:
    """Least squares by the normal equations in real numbers, and the slope at the answer is zero."""
    y0, effect = feese_effects()
    real = np.block([[effect.real, -effect.imag], [effect.imag, effect.real]])
    x = np.linalg.solve(real.T @ real, -real.T @ np.concatenate([y0.real, y0.imag]))
    assert np.abs(real.T @ (real @ x + np.concatenate([y0.real, y0.imag]))).max() < 1e-12
    u = x[:2] + 1j * x[2:]
    return {
        "planes.aft.mass": abs(u[0]) * 1e-3,
        "planes.aft.angle": float(np.angle(u[0]) % (2 * np.pi)),
        "planes.forward.mass": abs(u[1]) * 1e-3,
        "planes.forward.angle": float(np.angle(u[1]) % (2 * np.pi)),
    }


def feese_two_speeds() -> Answers:
    """All fillings of 12 holes with one or two of four weights in both planes; least worst amplitude."""
    y0, effect = feese_effects()
    single = [(m * np.exp(1j * np.radians(30.0 * k)), k, m) for k in range(12) for m in (2.0, 4.0, 6.0, 8.0)]
    pairs = [(u + v, m + n) for (u, i, m), (v, j, n) in combinations(single, 2) if i != j]
    everything = [(0j, 0.0), *[(u, m) for u, _, m in single], *pairs]
    options = np.array([u for u, m in everything if m <= 12.0 + 1e-12])
    best, chosen = np.inf, (0j, 0j)
    for u in options:
        left = np.abs(y0 + effect[:, 0] * u + effect[:, 1] * options[:, None]).max(axis=1)
        k = int(np.argmin(left))
        if left[k] < best:
            best, chosen = float(left[k]), (u, options[k])
    mil = 25.4e-6 / 2.0
    found: Answers = {"goal": best * mil}
    for name, u in zip(("aft", "forward"), chosen, strict=True):
        found[f"planes.{name}.angle"] = float(np.angle(u) % (2.0 * np.pi))
    return found


def fan_verification_run() -> Answers:
    """Four runs, three unknown phasors a sensor: what the fit leaves is at right angles to all that was fitted."""
    fitted = [(mpc(0), mpc(0)), (vector(10, 270), mpc(0)), (mpc(0), vector(12, 180)), (vector(11, 325), vector(6, 65))]
    read = {
        "a": [vector("8.6", 63), vector("5.9", 123), vector("6.2", 36), vector("0.9", 250)],
        "b": [vector("6.5", 206), vector("4.5", 228), vector("10.4", 162), vector("0.6", 310)],
    }
    # with as many runs but one as unknowns, the residual is along the one combination of runs that no fit can follow
    first, second = fitted[3][0] / fitted[1][0], fitted[3][1] / fitted[2][1]
    blind = [-(1 - first - second), -first, -second, mpc(1)]  # sum(blind * readings) is zero for any rotor
    size = sum(abs(one) ** 2 for one in blind)
    effects = {}
    for sensor, seen in read.items():
        miss = sum(one * y for one, y in zip(blind, seen, strict=True)) / size
        exact = [y - miss * one.conjugate() for one, y in zip(blind, seen, strict=True)]
        effects[sensor] = exact[0], (exact[1] - exact[0]) / fitted[1][0], (exact[2] - exact[0]) / fitted[2][1]
        zero(exact[3] - exact[0] - effects[sensor][1] * fitted[3][0] - effects[sensor][2] * fitted[3][1], 1)
    (ya, a1, a2), (yb, b1, b2) = effects["a"], effects["b"]
    whole = (a2 * yb - b2 * ya) / (a1 * b2 - a2 * b1), (b1 * ya - a1 * yb) / (a1 * b2 - a2 * b1)
    found: Answers = {}
    for name, u, there in zip(("left", "right"), whole, fitted[3], strict=True):
        for path, one in ((f"planes.{name}", u), (f"trim.{name}", u - there)):
            found |= {f"{path}.mass": abs(one) / 1000, f"{path}.angle": turned(arg(one))}
    zero(ya + a1 * whole[0] + a2 * whole[1], abs(ya))
    return found


def fan_for_99_of_100() -> Answers:
    """Least mass with which an error of 0.2 mil in each reading leaves 99 % within 1.5 mil, by the law of Rice."""
    from scipy.optimize import minimize
    from scipy.stats import rice

    weights = np.array([[0, 0], [complex(vector(10, 270)), 0], [0, complex(vector(12, 180))]])
    read = [[("8.6", 63), ("6.5", 206)], [("5.9", 123), ("4.5", 228)], [("6.2", 36), ("10.4", 162)]]
    readings = np.array([[complex(vector(*one)) for one in run] for run in read])
    inverse = np.linalg.inv(np.column_stack([np.ones(3), weights]))

    def kept(x: np.ndarray) -> float:
        shares = np.array([1.0, x[0] + 1j * x[1], x[2] + 1j * x[3]]) @ inverse
        sd = 0.2 * float(np.sqrt((abs(shares) ** 2).sum()))
        return float(np.log(rice.cdf(1.5 / sd, abs(shares @ readings) / sd)).sum())

    def mass(x: np.ndarray) -> float:
        return float(np.hypot(x[0], x[1]) + np.hypot(x[2], x[3]))

    whole = np.linalg.solve((inverse @ readings)[1:].T, -(inverse @ readings)[0])
    start = 0.9 * np.array([whole[0].real, whole[0].imag, whole[1].real, whole[1].imag])
    bound = {"type": "ineq", "fun": lambda x: 100.0 * (kept(x) - np.log(0.99))}
    best = minimize(mass, start, constraints=[bound], method="SLSQP", options={"ftol": 1e-14, "maxiter": 500})
    assert abs(kept(best.x) - np.log(0.99)) < 1e-9
    return {"status": "feasible", "goal": best.fun / 1000.0}


FOILES = _numbers(
    (
        "9.8@117 17@124 7.2@114 38.5@77 55@259",
        "2.7@43 14.3@317 4.5@213 14.3@270 45@118",
        "12.5@323 25@261 15.2@158 30@238 124@21",
        "22.4@92 32.6@45 23.3@315 27.8@210 138@349",
        "26@94 40.3@9 25@330 34@213 107@349",
        "40.3@355 43@144 29.6@61 65.4@322 90@280",
        "20.6@339 32.3@152 36.7@41 61.8@322 58@354",
        "12.6@226 37.6@52 18.8@153 26@176 108@201",
        "13.4@209 26.9@76 47.5@98 71.7@312 88@190",
        "13.4@154 22.4@307 52@299 102@165 56@48",
        "5.4@24 7.2@199 22.4@2 27.8@99 73@158",
    )
)
"""Effects of 1 kg in each of four planes and the reading as found; a row per reading."""


def _least_worst(cap: float) -> Answers:
    """Least greatest amplitude under one cap a plane, by sequential quadratic steps from several starts."""
    from scipy.optimize import minimize

    effect, y0 = FOILES[:, :4] / 100.0, FOILES[:, 4] / 100.0

    def left(x: Any) -> Any:
        return x[8] ** 2 - np.abs(y0 + effect @ (x[:4] + 1j * x[4:8])) ** 2

    def room(x: Any) -> Any:
        return cap**2 - x[:4] ** 2 - x[4:8] ** 2

    def height(x: Any) -> Any:
        return x[8]

    rules: Any = [{"type": "ineq", "fun": left}, {"type": "ineq", "fun": room}]
    best = None
    for seed in range(6):
        start: Any = np.append(np.random.default_rng(seed).normal(size=8), 3.0)
        options: Any = {"ftol": 1e-15, "maxiter": 1000}
        one = minimize(height, start, method="SLSQP", constraints=rules, options=options)
        if one.success and (best is None or one.fun < best.fun):
            best = one
    assert best is not None
    u = _sharpened(effect, y0, best.x[:4] + 1j * best.x[4:8], cap)
    found: Answers = {"goal": float(np.abs(y0 + effect @ u).max()) * 100.0 * 0.5e-6}
    for k, one in enumerate(u):
        found[f"planes.plane_{k + 1}.mass"] = float(abs(one))
        found[f"planes.plane_{k + 1}.angle"] = float(np.angle(one) % (2.0 * np.pi))
    return found


def _sharpened(effect: Any, y0: Any, u: Any, cap: float) -> Any:
    """Newton's method on the conditions of the optimum: the greatest rows are equal, and their pulls cancel."""
    left = np.abs(y0 + effect @ u)
    rows = np.flatnonzero(left > left.max() * (1.0 - 1e-4))
    full = np.flatnonzero(np.abs(u) > cap * (1.0 - 1e-4))
    start = np.concatenate([u.real, u.imag, [left.max() ** 2], np.zeros(len(rows) + len(full))])

    def conditions(v: Any) -> Any:
        z, level, pulls = v[:4] + 1j * v[4:8], v[8], v[9:]
        now = y0[rows] + effect[rows] @ z
        slope = 2.0 * (pulls[: len(rows)] * now) @ effect[rows].conj()
        slope[full] += 2.0 * pulls[len(rows) :] * z[full]
        closed = np.concatenate([np.abs(now) ** 2 - level, np.abs(z[full]) ** 2 - cap**2])
        return np.concatenate([slope.real, slope.imag, [pulls[: len(rows)].sum() - 1.0], closed])

    # the conditions are linear in the pulls: their first guess is a least-squares fit
    base = conditions(start)
    steps = np.eye(len(start))[9:]
    columns = np.array([conditions(start + one) - base for one in steps]).T
    start[9:] = np.linalg.lstsq(columns, -base, rcond=None)[0]
    for _ in range(20):
        now = conditions(start)
        slopes = np.array([(conditions(start + 1e-7 * one) - now) / 1e-7 for one in np.eye(len(start))]).T
        start = start - np.linalg.lstsq(slopes, now, rcond=None)[0]
    assert np.abs(conditions(start)).max() < 1e-11
    assert start[9:].min() > 0.0
    return start[:4] + 1j * start[4:8]


def foiles_min_max() -> Answers:
    return _least_worst(1e3)


def foiles_min_max_capped() -> Answers:
    return _least_worst(3.402)


# --- caps and holes beside unique answers ----------------------------------------------------


def capped(path: str, z: Real, radius: float | str, cap: float | str, *, removed: bool = False) -> Answers:
    """One plane whose weight stops at its cap: it stays in its direction, and what is missing is left."""
    found = weight(path, z, radius, removed=removed)
    assert found[f"{path}.mass"] > mpf(cap)
    found[f"{path}.mass"] = mpf(cap)
    return {**found, "residual.static": abs(z) - mpf(cap) * mpf(radius)}


def rao_9_4_capped() -> Answers:
    holes = [vector("0.01", 0), vector("0.01", 60), vector("0.015", 120), vector("0.015", 180)]
    return capped("planes.fifth", one_plane(-u for u in holes), "0.12", "0.15", removed=True)


def rao_9_5_capped() -> Answers:
    return capped("planes.rim", one_plane([vector("0.5", 10), vector("0.7", 100), vector("1.2", 190)]), 1, "0.8")


def rao_9_11_capped() -> Answers:
    """What plane C is short of acts at both ends with real shares, so it is least in the direction of C.

    Ends at 0 and 0.6 m: B acts there by (5, 1)/6, C by (1, 5)/6, and B makes up for a lack of C with 5/13 of it.
    """
    found = rao_9_11()
    c = found["planes.C.mass"] * mpf("0.1") * exp(mpc(0, found["planes.C.angle"]))
    lack = c * (1 - mpf("0.01") / abs(c))
    b = found["planes.B.mass"] * mpf("0.1") * exp(mpc(0, found["planes.B.angle"])) + lack * 5 / 13
    return {
        **weight("planes.B", b, "0.1"),
        "planes.C.mass": mpf("0.1"),
        "planes.C.angle": turned(arg(c)),
        "residual.static": abs(lack) * 8 / 13,
    }


def fillings(holes: int, shelf: Sequence[float], most: int) -> list[complex]:
    """Every sum of at most so many weights in different holes; hole 1 is at zero."""
    single = [(m * np.exp(2j * np.pi * k / holes), k) for k in range(holes) for m in shelf]
    sums = [0j]
    for count in range(1, most + 1):
        for chosen in combinations(single, count):
            if len({k for _, k in chosen}) == count:
                sums.append(complex(sum(u for u, _ in chosen)))
    return sums


def least(values: Any) -> int:
    """Where the least value is; it must be the only one."""
    ranked = np.sort(values)
    assert ranked[1] > ranked[0] * (1.0 + 1e-6)
    return int(np.argmin(values))


def rao_9_3_holes() -> Answers:
    known = sum(complex(u) for u in (vector("3.85", 40), vector("1.35", 220), vector("3.25", 290))) * 1e-3
    options = 0.1e-3 * np.array(fillings(12, (10.0, 20.0, 30.0), 2))
    left = np.abs(known + options)
    best = least(left)
    return {
        "residual.static": left[best],
        "planes.disc.unbalance": abs(options[best]),
        "planes.disc.angle": float(np.angle(options[best]) % (2.0 * np.pi)),
    }


def rao_9_12_holes() -> Answers:
    """Judged at the bearings, 0 and 2 m; each unbalance acts there by the lever."""
    known = [(complex(u), float(z)) for u, z in RAO_9_12]
    options = 0.5 * np.array(fillings(16, (0.25, 0.5, 1.0, 1.5), 1))
    at_b = sum(u * (1 - z / 2) for u, z in known) + 1.2 * options[:, None] - 0.1 * options
    at_f = sum(u * z / 2 for u, z in known) - 0.2 * options[:, None] + 1.1 * options
    i, j = divmod(least((np.abs(at_b) ** 2 + np.abs(at_f) ** 2).ravel()), len(options))
    found: Answers = {"residual.static": abs(sum(u for u, _ in known) + options[i] + options[j])}
    for name, u in (("A", options[i]), ("G", options[j])):
        found[f"planes.{name}.mass"] = abs(u) / 0.5
        found[f"planes.{name}.angle"] = float(np.angle(u) % (2.0 * np.pi))
    return found


def rao_9_6_capped() -> Answers:
    """Half balanced in the right direction: the reading falls by the part of the weight that is there."""
    z = triangle(vector("0.2", 40), vector("0.5", 150), vector("0.2", -65), mirrored=True)
    return {
        "goal": mpf("0.2e-3") * (1 - mpf("0.05") / abs(z)),
        "planes.wheel.mass": mpf("0.05"),
        "planes.wheel.angle": turned(arg(z)),
    }


def rao_9_7_holes() -> Answers:
    """Positions of the mark are mirror images of phases, so their conjugates turn with the weights."""
    found, trial = (complex(v).conjugate() for v in (vector("0.15", -15), vector("0.22", 35)))
    effect = (trial - found) / complex(vector("0.05", 45))
    options = np.array(fillings(8, (0.01, 0.02, 0.03), 2))
    left = np.abs(found + effect * options)
    best = least(left)
    return {
        "goal": left[best] * 1e-3,
        "planes.flywheel.acts_as": abs(options[best]),
        "planes.flywheel.angle": float(np.angle(options[best]) % (2.0 * np.pi)),
    }


def rao_9_8_sector() -> Answers:
    """The nearest allowed weight is the foot of the perpendicular on the nearer edge of the sector."""
    z = triangle(vector("0.1", 45), vector("0.2", 145), vector("0.1", -20), mirrored=True)
    into = turned(arg(z)) - deg(260)
    assert 0 < into < deg(40)
    return {
        "goal": mpf("0.1e-3") * sin(into),
        "planes.wheel.mass": abs(z) * cos(into),
        "planes.wheel.angle": deg(260),
    }


def rao_9_13_effects() -> Any:
    """Effects of an ounce, a row per bearing and a column per plane, and the readings as found [mil pp]."""
    trials = {"left": 2.0 * np.exp(1j * np.pi / 6.0), "right": 2.0}
    found = np.array([complex(v) for v in RAO_9_13["found"]])
    effect = [(np.array([complex(v) for v in RAO_9_13[side]]) - found) / trials[side] for side in ("left", "right")]
    return np.array(effect).T, found


def rao_9_13_holes() -> Answers:
    effect, found = rao_9_13_effects()
    options = np.array(fillings(12, (1.0, 2.0, 4.0), 1))
    left = found[:, None, None] + effect[:, :1, None] * options[:, None] + effect[:, 1:, None] * options
    i, j = divmod(least(np.abs(left).max(axis=0).ravel()), len(options))
    answers: Answers = {"goal": float(np.abs(left[:, i, j]).max()) * 12.7e-6}
    for name, u in (("left", options[i]), ("right", options[j])):
        answers[f"planes.{name}.mass"] = abs(u) * 0.028349523125
        answers[f"planes.{name}.angle"] = float(np.angle(u) % (2.0 * np.pi))
    return answers


def printed_weights_leave(left: tuple[float, float], right: tuple[float, float]) -> tuple[float, float]:
    """Readings of both bearings of problem 9.68 [mil pp] with weights [oz, degrees] fitted as printed."""
    effect, found = rao_9_13_effects()
    weights = [size * np.exp(1j * np.radians(angle)) for size, angle in (left, right)]
    a, b = np.abs(found + effect @ weights)
    return float(a), float(b)


# --- engines ---------------------------------------------------------------------------------

STEPS = 2048
TURN = np.arange(STEPS) * 2.0 * np.pi / STEPS


def second_derivative(path: Any) -> Any:
    """d²/da² over one turn."""
    orders = np.fft.fftfreq(STEPS, 1.0 / STEPS)
    return np.fft.ifft(-(orders**2) * np.fft.fft(path))


class Cylinder:
    """A slider-crank moved through one turn; forces on the engine as complex numbers across the crankshaft."""

    def __init__(self, crank: float, at: float, *, bank: float = 0.0, two_orders: bool = False) -> None:
        self.crank, self.at, self.bank, self.two_orders = np.radians(crank), at, np.radians(bank), two_orders

    def force(self, mass: float, radius: float, rod: float, speed: float, rotating: float = 0.0) -> Any:
        """Inertia force over one turn [N], shape (STEPS,)."""
        angle = TURN + self.crank - self.bank
        path = radius * np.cos(angle) + np.sqrt(rod**2 - (radius * np.sin(angle)) ** 2)
        if self.two_orders:
            path = radius * (np.cos(angle) + radius / (4.0 * rod) * np.cos(2.0 * angle))
        along = -mass * speed**2 * second_derivative(path).real
        pin = -rotating * speed**2 * second_derivative(radius * np.exp(1j * (TURN + self.crank)))
        return along * np.exp(1j * self.bank) + pin


def longest(force: Any, order: int) -> float:
    """Longest vector of one order of a force over a turn."""
    spectrum = np.fft.fft(force) / STEPS
    return float(abs(spectrum[order]) + abs(spectrum[-order]))


def orders(force: Any, couple: Any, size: float, wanted: Sequence[int] = (1, 2)) -> Answers:
    """Force and couple of each order; what is nothing but rounding is zero."""
    found: Answers = {}
    for order in wanted:
        for word, one in (("force", force), ("couple", couple)):
            value = longest(one, order)
            found[f"orders.{order}.{word}"] = 0.0 if value < 1e-9 * size else value
    return found


def engine(
    cranks: Sequence[float],
    at: Sequence[float],
    data: tuple[float, float, float, float],
    *,
    two_orders: bool = False,
) -> tuple[Any, Any, float]:
    """Force and couple over a turn, and the size of one cylinder's primary force."""
    mass, radius, rod, speed = data
    made = [Cylinder(c, z, two_orders=two_orders) for c, z in zip(cranks, at, strict=True)]
    forces = [one.force(mass, radius, rod, speed) for one in made]
    couple = sum(one.at * force for one, force in zip(made, forces, strict=True))
    return sum(forces), couple, mass * radius * speed**2


def places(count: int, spacing: float) -> list[float]:
    """Places about the middle of the engine."""
    return [spacing * (k - 0.5 * (count - 1)) for k in range(count)]


RPM = np.pi / 30.0


def rao_9_22() -> Answers:
    data = (1.0, 0.1, 0.25, 3000 * RPM)
    force, couple, size = engine((0, 180, 180, 0), places(4, 0.1), data, two_orders=True)
    return orders(force, couple, size)


def rao_9_22_exact() -> Answers:
    force, couple, size = engine((0, 180, 180, 0), places(4, 0.1), (1.0, 0.1, 0.25, 3000 * RPM))
    return {
        "orders.2.force": longest(force, 2),
        "orders.4.force": longest(force, 4),
        "all_orders.force": float(np.abs(force).max()),
        "all_orders.couple": 0.0 if np.abs(couple).max() < 1e-9 * size else float(np.abs(couple).max()),
    }


def rao_9_23() -> Answers:
    force, couple, size = engine((0, 180), places(2, 0.1), (1.0, 0.05, 0.2, 1000 * RPM), two_orders=True)
    return orders(force, couple, size)


def rao_9_24() -> Answers:
    data = (1.5, 0.075, 0.25, 1500 * RPM)
    force, couple, size = engine((0, 180, 90, 270), places(4, 0.1), data, two_orders=True)
    primary = np.fft.fft(couple) / STEPS
    return {**orders(force, couple, size), "measures.at_start.value": float(abs(primary[1] + primary[-1]))}


def rao_9_25() -> Answers:
    data = (1.0, 0.05, 0.2, 3000 * RPM)
    force, couple, size = engine((0, 120, 240, 240, 120, 0), places(6, 0.1), data)
    return orders(force, couple, size, (1, 2, 4, 6))


def best_four() -> Answers:
    """All 24 ways to set four cranks a quarter turn apart."""
    data = (2.0, 0.05, 0.2, 2000 * RPM)
    ranked = []
    for cranks in permutations((0.0, 90.0, 180.0, 270.0)):
        force, couple, size = engine(cranks, places(4, 0.2), data)
        ranked.append((round(longest(couple, 1) / size, 9), round(longest(couple, 2) / size, 9), force, couple, size))
    _, _, force, couple, size = min(ranked, key=lambda one: one[:2])
    return orders(force, couple, size)


def five_cylinders() -> Answers:
    """All 120 ways to set five cranks; the one with the least primary couple."""
    data = (0.6, 0.0432, 0.144, 6000 * RPM)
    ranked = []
    for rest in permutations((72.0, 144.0, 216.0, 288.0)):
        force, couple, size = engine((0.0, *rest), places(5, 0.088), data)
        ranked.append((round(longest(couple, 1) / size, 9), round(longest(couple, 2) / size, 9), force, couple, size))
    _, _, force, couple, size = min(ranked, key=lambda one: one[:2])
    return orders(force, couple, size)


def lanchester() -> Answers:
    """Each of two shafts at twice the speed takes half of the second order; what they leave is the fourth."""
    data = (0.5, 0.045, 0.15, 6000 * RPM)
    force, _, _ = engine((0, 180, 180, 0), places(4, 0.09), data)
    spectrum = np.fft.fft(force) / STEPS
    each = 0.5 * longest(force, 2) / (2.0 * data[3]) ** 2
    left = force - 2.0 * (spectrum[2] * np.exp(2j * TURN)).real
    return {
        "balance_shafts.left.unbalance": each,
        "balance_shafts.right.unbalance": each,
        "orders.2.force": 0.0,
        "orders.4.force": longest(left, 4),
        "all_orders.force": float(np.abs(left).max()),
    }


def v_twin() -> Answers:
    """Shares of the counterweight tried one by one, then refined: the least primary force of a 90 degree V twin."""
    data = (0.4, 0.036, 0.13, 7000 * RPM)
    pair = [Cylinder(0.0, 0.0, bank=b) for b in (-45.0, 45.0)]
    pistons = sum(one.force(*data) for one in pair)
    weights = -2.0 * data[0] * data[1] * data[3] ** 2 * np.exp(1j * TURN)
    low, high = 0.0, 1.0
    for _ in range(60):
        near, far = low + (high - low) / 3.0, high - (high - low) / 3.0
        if longest(pistons - near * -weights, 1) < longest(pistons - far * -weights, 1):
            high = far
        else:
            low = near
    share = 0.5 * (low + high)
    left = pistons + share * weights
    size = data[0] * data[1] * data[3] ** 2
    found = orders(left, 0.0 * left, size)
    found["orders.1.force"] = 0.0 if found["orders.1.force"] < 1e-6 * size else found["orders.1.force"]
    return {"counterweight_share": share, **{k: v for k, v in found.items() if k.endswith("force")}}


def single_capped() -> Answers:
    """One cylinder, its counterweight share held below 40 %: the primary force that stays, in closed form."""
    size = 2.0 * 0.04 * (1500 * RPM) ** 2
    return {
        "counterweight_share": 0.4,
        "orders.1.force": 0.6 * size,
        "limits.second.value": longest(engine((0,), (0.0,), (2.0, 0.04, 0.14, 1500 * RPM))[0], 2),
    }


ROUTES: dict[str, Callable[[], Answers]] = {
    "rao_9_3": rao_9_3,
    "rao_9_4": rao_9_4,
    "rao_9_5": rao_9_5,
    "rao_9_6": rao_9_6,
    "rao_9_7": rao_9_7,
    "rao_9_8": rao_9_8,
    "rao_9_9": rao_9_9,
    "rao_9_10": rao_9_10,
    "rao_9_11": rao_9_11,
    "rao_9_12": rao_9_12,
    "rao_9_13": rao_9_13,
    "rao_9_14_a": rao_9_14_a,
    "rao_9_14_b": rao_9_14_b,
    "rao_9_3_holes": rao_9_3_holes,
    "rao_9_4_capped": rao_9_4_capped,
    "rao_9_5_capped": rao_9_5_capped,
    "rao_9_6_capped": rao_9_6_capped,
    "rao_9_7_holes": rao_9_7_holes,
    "rao_9_8_sector": rao_9_8_sector,
    "rao_9_11_capped": rao_9_11_capped,
    "rao_9_12_holes": rao_9_12_holes,
    "rao_9_13_holes": rao_9_13_holes,
    "rao_9_14_a_half_metre": rao_9_14_a_half_metre,
    "rao_9_14_b_half_metre": rao_9_14_b_half_metre,
    "rao_9_14_b_capped": rao_9_14_b_capped,
    "assignment_1_phases": assignment_1_phases,
    "rao_9_22": rao_9_22,
    "rao_9_22_exact": rao_9_22_exact,
    "rao_9_23": rao_9_23,
    "rao_9_24": rao_9_24,
    "rao_9_25": rao_9_25,
    "rao_9_68": rao_9_13,
    "rao_9_69": rao_9_13,
    "rao_9_70": rao_9_13,
    "assignment_1": assignment_1,
    "assignment_2": assignment_2,
    "assignment_3": rao_9_25,
    "bk_17_227": bk_17_227,
    "bk_17_227_misprint": bk_17_227_misprint,
    "bk_17_227_holes": bk_17_227_holes,
    "fan_16_blades": fan_16_blades,
    "fan_for_99_of_100": fan_for_99_of_100,
    "fan_verification_run": fan_verification_run,
    "feese_two_planes": feese_two_planes,
    "feese_two_speeds": feese_two_speeds,
    "foiles_min_max": foiles_min_max,
    "foiles_min_max_capped": foiles_min_max_capped,
    "shaft_three_planes": shaft_three_planes,
    "shaft_holes": shaft_holes,
    "engine_phasing_four": best_four,
    "engine_phasing_five": five_cylinders,
    "engine_lanchester": lanchester,
    "engine_v_twin": v_twin,
    "engine_share_capped": single_capped,
}
"""Second route by the name of the problem file."""
