"""The greatest value through the poles: against dense grids, 40 digits and the general search."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from chain_machine import Chain, chains
from shaken_system import Shaken, shaken
from space_machine import Plant
from test_chains import asked, read
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse, drive_extreme, singularities
from vibopt.forms.greatest_values import highest
from vibopt.mechanics.cells import REACH, cells, nearest
from vibopt.mechanics.combine import Extreme
from vibopt.mechanics.peaks import greatest
from vibopt.program.pose import on_needed, pose
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict

few = settings(derandomize=True, database=None, deadline=None, max_examples=60, suppress_health_check=list(HealthCheck))
NONE = np.zeros(0)
seeds = st.integers(0, 1_000_000)


def found(system: Shaken, within: float) -> list[Extreme] | None:
    model = system.model()
    form = system.form(model)
    return highest(model, form, form.drives[0], NONE, within)


def inside(system: Shaken, speed: float) -> bool:
    return any(band.holds(speed, 1e-15) for band in system.bands)


@given(seed=seeds)
@few
def test_no_sample_is_higher_and_the_value_is_reached_at_the_speed_named(seed: int) -> None:
    system = shaken(seed)
    model = system.model()
    form = system.form(model)
    tops = highest(model, form, form.drives[0], NONE, 1.0)
    top = tops[0] if tops is not None else drive_extreme(model, form, form.drives[0], NONE, False)
    here = system.exactly(model, top.speed)
    assert top.value == pytest.approx(here, rel=1e-9 + system.doubt)
    assert inside(system, top.speed)
    assert system.exactly(model, system.sampled()[1]) <= here * (1.0 + 1e-10 + system.doubt)


def test_the_poles_give_the_answer_by_themselves_for_nearly_all_systems() -> None:
    systems = [one for one in map(shaken, range(200)) if len(one.push) > 1]
    answered = [found(one, 1.0) is not None for one in systems]
    assert sum(answered) > 0.9 * len(systems)


@given(seed=seeds)
@few
def test_every_local_maximum_of_half_the_height_is_found_and_nothing_else(seed: int) -> None:
    system = shaken(seed)
    tops = found(system, 0.5)
    assume(tops is not None)
    assert tops is not None
    speeds = np.array([one.speed for one in tops])
    poles = system.poles()
    for band in system.bands:
        near = [pole.real + np.abs(pole.imag) * np.sinh(np.linspace(-5.0, 5.0, 161)) for pole in poles]
        grid = np.concatenate([np.linspace(band.low, band.high, 1501), *near, speeds])
        grid = np.unique(np.clip(grid, band.low, band.high))
        values = system.size(grid)
        padded = np.concatenate([[-1.0], values, [-1.0]])
        rises = (values > padded[:-2] * (1.0 + 1e-8)) & (values > padded[2:] * (1.0 + 1e-8))
        for i in np.flatnonzero(rises & (values >= 0.51 * tops[0].value)).tolist():
            low, high = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
            room = 1e-3 * np.abs(grid[i] - poles).min()
            assert ((speeds >= low - room) & (speeds <= high + room)).any()
    for one in tops:
        step = 1e-3 * np.abs(one.speed - poles).min()
        beside = np.array([speed for speed in (one.speed - step, one.speed + step) if inside(system, speed)])
        assert one.speed == 0.0 or (system.size(beside) <= one.value * (1.0 + 1e-9 + system.doubt)).all()


@given(chain=chains())
@few
def test_forces_and_shaken_bases_are_those_of_the_general_search(chain: Chain) -> None:
    scene = read(chain, {name: words for name, (words, _, _) in asked(chain).items()})
    design = chain.design(np.random.default_rng(3))
    chosen = {".".join(path): value for path, value in design.items()}
    x = np.array([chosen[variable.path] for variable in scene.variables])
    for limit in pose(scene, reduce=False).limits:
        if not isinstance(limit.form, Modulus):
            continue
        model, form, drive = limit.model, limit.form, limit.form.drives[0]
        tops = highest(model, form, drive, x, 1.0)
        if tops is not None:
            general = greatest(DriveResponse(model, form, drive, x), drive.bands, *singularities(model, form, drive, x))
            assert tops[0].value == pytest.approx(general.value, rel=1e-9), limit.name


@given(seed=seeds)
@few
def test_an_undamped_resonance_in_the_band_is_infinite_there(seed: int) -> None:
    system = shaken(seed)
    nothing = np.zeros_like(system.damping)
    system = Shaken(**{**system.__dict__, "damping": nothing, "hysteretic": nothing})
    model = system.model()
    form = system.form(model)
    top = drive_extreme(model, form, form.drives[0], NONE, False)
    poles = np.sort(np.abs(system.poles().real))[::2]
    assume((np.diff(poles) > 1e-4 * poles[1:]).all())
    hit = [pole for pole in poles for band in system.bands if band.low * 1.001 < pole < band.high * 0.999]
    assert np.isfinite(top.value) or np.abs(poles / top.speed - 1.0).min() < 1e-6 or top.speed == 0.0
    if any(pole > 1e-6 * poles.max() for pole in hit):
        assert top.value == np.inf


@given(seed=seeds)
@few
def test_cells_cover_the_stretch_and_are_short_against_the_distance_to_the_poles(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 12))
    half = random.uniform(0.0, 10.0, count) + 1j * 10.0 ** random.uniform(-6.0, 1.0, count)
    still = 1j * 10.0 ** random.uniform(-2.0, 2.0, int(random.integers(0, 3)))
    poles = np.concatenate([half, -half.conj(), still])
    stretches = ((0.0, 2.0), (2.0, 5.0), (7.0, 7.0001))
    made = cells(poles, stretches)
    assert made is not None
    middle, size, which = made
    distance = np.abs(middle[:, None] - poles).min(axis=1)
    assert (size <= REACH * (1.0 + 1e-6) * distance).all()
    for i, (low, high) in enumerate(stretches):
        edges = np.concatenate([middle[which == i] - size[which == i], [high]])
        assert edges[0] == pytest.approx(low, abs=1e-12)
        assert edges[1:] == pytest.approx(middle[which == i] + size[which == i], abs=1e-12)
    first = [one[0] for one in nearest(poles)]
    assert first == sorted(first)


def test_a_second_design_of_the_same_machine_is_not_the_first() -> None:
    plant = Plant(2)
    document = plant.document()
    document["bodies"]["body"]["mass"] = {"from": "300 kg", "to": "3000 kg"}
    document["goal"] = {"minimise": "total_mass"}
    words = {"response": "displacement", "of": "eye", "direction": plant.way.tolist(), "over": "1..400 rad/s"}
    scene = from_dict({**document, "measures": {"worst": words}})
    model, form = on_needed(scene, model_of(scene), scene.measures["worst"])
    for mass in (400.0, 2000.0, 400.0):
        plant.mass = mass
        speeds = np.linspace(1.0, 400.0, 40_001)
        best = speeds[plant.response(speeds).argmax()]
        around = np.clip(best + np.linspace(-0.01, 0.01, 2001), 1.0, 400.0)
        value = form.worst(model, np.array([mass])).value
        assert value == pytest.approx(plant.response(around).max(), rel=1e-9)
