"""Whatever the conventions, the weight ends up physically opposite the unbalance of a rotor simulated in time."""

from __future__ import annotations

from cmath import rect
from functools import cache
from itertools import product
from math import degrees, pi, radians

import numpy as np
import pytest

from rotor_jobs import FAN, correction, read_text, solve_text

SPEED = 40.0
UNBALANCE = {"left": (0.004, 75.0), "right": (0.0065, 290.0)}
"""kg at 0.1 m, degrees ahead of the mark in the sense of rotation."""
TRIALS = {"left": (0.002, 30.0), "right": (0.003, 200.0)}
RUNS = ("", *TRIALS)
PICKUP, TACHO = {"a": 20.0, "b": 110.0}, 65.0
"""Places on the stator, degrees in the sense of rotation."""
STEPS, TURNS = 720, 40

MASSES = np.array([3.0, 2.0])
K = np.array([[6400.0, -900.0], [-900.0, 2100.0]])
C = np.array([[60.0, -5.0], [-5.0, 40.0]])


@cache
def signals() -> dict[str, dict[str, tuple[float, float]]]:
    """Peak [m] and shaft angle of the mark at the peak [deg] per run and sensor, by stepping the motion in time.

    Each bearing moves in the direction of its pickup; the shaft turns with growing angle, the mark stands at omega t.
    """
    pushed = np.transpose([loads(trial) for trial in RUNS])
    step = 2.0 * pi / SPEED / STEPS
    y = np.zeros((4, len(RUNS)))
    last = np.zeros((STEPS, *pushed.shape))
    for index in range(STEPS * TURNS):
        t = index * step
        k1 = slope(t, y, pushed)
        k2 = slope(t + step / 2, y + step / 2 * k1, pushed)
        k3 = slope(t + step / 2, y + step / 2 * k2, pushed)
        k4 = slope(t + step, y + step * k3, pushed)
        last[index % STEPS] = y[:2]
        y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return {
        trial: {name: peak(last[:, row, column]) for row, name in enumerate(PICKUP)}
        for column, trial in enumerate(RUNS)
    }


def loads(trial: str) -> list[complex]:
    """What a run's weights pull with at each pickup [N], as the shaft stands at time zero."""
    weights = {name: [UNBALANCE[name]] + ([TRIALS[name]] if name == trial else []) for name in UNBALANCE}
    return [
        sum(mass * 0.1 * SPEED**2 * rect(1.0, radians(angle - pickup)) for mass, angle in plane)
        for plane, pickup in zip(weights.values(), PICKUP.values(), strict=True)
    ]


def slope(t: float, y: np.ndarray, pushed: np.ndarray) -> np.ndarray:
    force = (pushed * rect(1.0, SPEED * t)).real
    return np.concatenate([y[2:], (force - C @ y[2:] - K @ y[:2]) / MASSES[:, None]])


def peak(signal: np.ndarray) -> tuple[float, float]:
    """Height and place of the highest sample, refined by a parabola."""
    top = int(np.argmax(signal))
    before, here, after = signal[top - 1], signal[top], signal[(top + 1) % STEPS]
    shift = 0.5 * (before - after) / (before - 2.0 * here + after)
    return float(here - 0.25 * (before - after) * shift), 360.0 * (top + float(shift)) / STEPS


def reading(trial: str, sensor: str, phase: str, readings: str, angles: str, detector: str) -> str:
    """What the instrument would show."""
    height, mark = signals()[trial][sensor]
    lag = (mark - TACHO) % 360.0
    on_stator = mark if angles == "with rotation" else -mark
    phase_angle = lag if phase == "lag" else -lag
    shown = on_stator if readings == "mark" else phase_angle
    amount = height * {"pk": 1.0, "pp": 2.0, "rms": 0.5**0.5}[detector]
    return f"{amount * 1e6!r} µm @ {shown % 360.0!r} deg"


def weight(name: str, angles: str) -> str:
    mass, ahead = TRIALS[name]
    return f"{mass * 1e3} g @ {(ahead if angles == 'with rotation' else -ahead) % 360.0} deg"


def job(phase: str, readings: str, angles: str, detector: str) -> str:
    lines = [
        f'title = "simulated"\nspeed = "{SPEED} rad/s"\n[conventions]\nreadings = "{readings}"\nangles = "{angles}"'
    ]
    lines.append(f'detector = "{detector}"\nzero = "the mark"')
    lines += [f'phase = "{phase}"'] if readings == "phase" else []
    lines += [f'[planes.{name}]\nradius = "100 mm"' for name in UNBALANCE]
    for trial in RUNS:
        fitted = f'weights = {{ {trial} = "{weight(trial, angles)}" }}\n' if trial else ""
        values = ", ".join(f'{one} = "{reading(trial, one, phase, readings, angles, detector)}"' for one in PICKUP)
        lines.append(f"[[runs]]\n{fitted}readings = {{ {values} }}")
    return "\n".join(lines)


COMBINATIONS = [
    (*both, *rest)
    for both in (("lag", "phase"), ("lead", "phase"), ("", "mark"))
    for rest in product(("with rotation", "against rotation"), ("pk", "pp", "rms"))
]


@pytest.mark.parametrize(("phase", "readings", "angles", "detector"), COMBINATIONS)
def test_the_weight_is_opposite_the_unbalance(phase: str, readings: str, angles: str, detector: str) -> None:
    plan = solve_text(job(phase, readings, angles, detector))
    assert plan.status == "optimal"
    for name, (mass, ahead) in UNBALANCE.items():
        found = correction(plan, name)
        written = degrees(np.angle(found))
        on_shaft = written if angles == "with rotation" else -written
        assert abs((on_shaft - ahead + 180.0 + 180.0) % 360.0 - 180.0) < 0.02
        assert abs(found) == pytest.approx(mass, rel=3e-4)


@pytest.mark.parametrize(("phase", "readings"), [("lag", "phase"), ("lead", "phase"), ("", "mark")])
def test_a_wrong_convention_misses(phase: str, readings: str) -> None:
    """Mixed-up words do not cancel out: the mirror image is another weight."""
    right = job(phase, readings, "with rotation", "pk")
    wrong = right.replace('angles = "with rotation"', 'angles = "against rotation"')
    right_plan, wrong_plan = solve_text(right), solve_text(wrong)
    assert (abs(correction(right_plan, "left") - correction(wrong_plan, "left")) < 1e-9) == (readings == "mark")


def test_the_conventions_stand_above_the_answer() -> None:
    assert read_text(job("lag", "phase", "against rotation", "pp")).conventions.sentences() == (
        "Angles of weights are counted against rotation from zero, which is at: the mark.",
        "The angle of a reading is how far the vibration lags the reference pulse.",
        "An amplitude without a word is pp.",
    )
    assert read_text(job("", "mark", "with rotation", "rms")).conventions.sentences() == (
        "Angles of weights are counted with rotation from zero, which is at: the mark.",
        "Readings are positions of the stroboscope mark on a scale that stands still, counted with rotation; "
        "the mark moves the other way round than the weight.",
        "An amplitude without a word is rms.",
    )


@pytest.mark.parametrize("runout", ["", 'runout = "0.5 mil rms @ 10 deg"\n'])
@pytest.mark.parametrize("second", ["5.9 @ 123 deg", "5.90e0 @ 123°", "5.9 mil rms @ 123 deg"])
def test_the_unit_of_a_sensor_is_that_of_its_bare_numbers_with_or_without_runout(runout: str, second: str) -> None:
    """Whichever way the numbers are written, in one sheet or cell by cell; the detector is not that of the others."""
    sensor = f'[sensors.a]\nunit = "mil rms"\n{runout}[sensors.b]\n'
    text = FAN.replace("[[runs]]", sensor + "[[runs]]", 1)
    text = text.replace("8.6 mil @", "8.6 mil rms @").replace("6.2 mil @", "6.2 mil rms @")
    written = solve_text(text.replace("5.9 mil @ 123 deg", "5.9 mil rms @ 123 deg"))
    bare = solve_text(text.replace("8.6 mil rms @", "8.6 @").replace("5.9 mil @ 123 deg", second))
    assert bare.status == "optimal"
    for one, other in zip(bare.plan.planes, written.plan.planes, strict=True):
        assert one.u == pytest.approx(other.u, rel=1e-12)
    assert bare.plan.rows[0].found.shown == ("8.309 mil rms" if runout else "8.6 mil rms")  # |8.6 @ 63 - 0.5 @ 10 deg|
