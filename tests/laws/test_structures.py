"""Large structures: what the points need of them, against recurrences in 40 digits and dense solutions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse

from rods import ROD, beam, rod, rod_receptance
from vibopt.forms import Modulus, drive_response
from vibopt.forms.extremes import line_slope
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.built import Joint
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.host import Coordinates, Matrices, digits_lost, krylov, of_modes, reduced_host
from vibopt.mechanics.host.matrices import Dashed, negative_count
from vibopt.mechanics.hosted import Carrier, HostedMachine
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.monomial import Monomial
from vibopt.mechanics.receptance import Attached, slopes_of
from vibopt.responses.response_rows import across_link, at_point, link_forces
from vibopt.scene.read import from_dict
from vibopt.signals import Amplitude, Band, Drive, Line, Output, Piece
from vibopt.solve import solve

FIRST = 0.5 * np.pi * np.sqrt(ROD["stiffness"] / ROD["mass"]) / ROD["length"]
"""First natural frequency of the continuous rod [rad/s]."""
FLAT = Amplitude((Piece(Band(0.0, 1e9), 1.0),))


@pytest.mark.parametrize("n", [3, 100, 10_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_receptances_of_a_rod_are_those_of_its_recurrence(n: int) -> None:
    made = reduced_host(rod(n), {"end": n - 1, "middle": n // 2}, 9.7 * FIRST)
    assert made.error < 1e-10
    assert made.coordinates.count <= 40
    for part in (0.0, 0.1, 0.6, 1.9, 4.4, 7.5, 9.6):
        found = made.coordinates.receptances(np.array([part * FIRST]))[0]
        for column, node in enumerate((n, n // 2 + 1)):
            assert found[column, 0].real == pytest.approx(rod_receptance(n, node, part * FIRST), rel=1e-10)


@pytest.mark.parametrize("part", [0.02, 0.1, 0.3, 1.2])
def test_the_error_said_is_that_at_frequencies_of_ones_own(part: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of 160 alike: few of its modes, or more than are carried; what is off by much says so."""
    monkeypatch.setattr(krylov, "_WIDEST", 96)
    monkeypatch.setattr(krylov, "_MOST", 24)
    ones, below = np.ones(160), np.ones(159)
    stiffness = 1e4 * sparse.diags_array([2.0 * ones, -below, -below], offsets=[0, 1, -1]).tocsc()
    chain = Matrices(sparse.diags_array(ones).tocsc(), (1e-6 * stiffness).tocsc(), stiffness)
    places, top = np.array([52, 159]), part * chain.fastest
    made = reduced_host(chain, {"a": 52, "b": 159}, top)
    omega = top * np.random.default_rng(5).uniform(0.0, 1.0, 40)
    exact = Dashed(chain, places, 0.0).receptances(omega)
    off = np.abs(made.coordinates.receptances(omega) - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))
    assert (float(off.max()) < 1e-6) == (made.error < 1e-6)
    assert (made.error < 1e-6) == (part < 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_no_resonance_of_what_hardly_decays_is_lost_among_two_hundred(seed: int) -> None:
    """A chain of 400 unlike bodies: each resonance by all of its modes, none decays by more than 1e-7 of it."""
    rng = np.random.default_rng(seed)
    masses, springs = 10.0 ** rng.uniform(-0.3, 0.3, 400), 1e4 * 10.0 ** rng.uniform(-0.5, 0.5, 400)
    sums = np.append(springs[:-1] + springs[1:], springs[-1])
    stiffness = sparse.diags_array([sums, -springs[1:], -springs[1:]], offsets=[0, 1, -1]).tocsc()
    chain = Matrices(sparse.diags_array(masses).tocsc(), (1e-9 * stiffness).tocsc(), stiffness)
    places, top = np.random.default_rng(seed + 100).integers(0, 400, 2), 125.0
    made = reduced_host(chain, {"a": int(places[0]), "b": int(places[1])}, top)
    root = np.sqrt(masses)
    squares, shapes = np.linalg.eigh(stiffness.toarray() / np.outer(root, root))
    seen, inside = (shapes / root[:, None])[places], np.sqrt(squares[squares < top**2])
    assert made.error < 1e-10
    assert len(inside) > 180
    for omega in inside[1:].tolist():  # the first is known to fewer digits than it decays by
        exact = (seen / (squares - omega**2 + 1e-9j * omega * squares)) @ seen.T
        found = made.coordinates.receptances(np.array([omega]))[0]
        assert np.abs(found - exact).max() < 0.02 * np.abs(exact).max()


def test_a_rod_of_many_elements_is_a_continuous_rod() -> None:
    made = reduced_host(rod(10_000), {"end": 9_999}, 9.7 * FIRST)
    omega = np.array([0.3, 2.2, 5.5]) * FIRST
    wave = omega * np.sqrt(ROD["mass"] / ROD["stiffness"])
    exact = np.tan(wave * ROD["length"]) / (ROD["stiffness"] * wave)
    assert made.coordinates.receptances(omega)[:, 0, 0].real == pytest.approx(exact, rel=1e-5)


def test_damping_of_any_kind_is_carried() -> None:
    plain = rod(60, mass_damping=2.0, stiffness_damping=1e-6)
    dashpot = sparse.csc_array(([8e4], ([30], [30])), shape=plain.mass.shape)
    damped = Matrices(plain.mass, (plain.damping + dashpot).tocsc(), plain.stiffness, loss_factor=0.01)
    places = [59, 20]
    made = reduced_host(damped, dict(zip("ab", places, strict=True)), 8.0 * FIRST)
    assert made.error < 1e-10
    omega = np.linspace(0.1, 8.0, 40) * FIRST
    w = omega[:, None, None]
    stiff = damped.stiffness.toarray() * (1 + 0.01j) - w**2 * damped.mass.toarray() + 1j * w * damped.damping.toarray()
    exact = np.linalg.inv(stiff)[:, places][:, :, places]
    assert made.coordinates.receptances(omega) == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).min())


def test_what_nothing_holds_keeps_its_rigid_motion() -> None:
    made = reduced_host(rod(400, held=False), {"left": 0, "right": 400}, 6.0 * FIRST)
    assert made.error < 1e-10
    assert np.sqrt(made.coordinates.stiffness[0]) < 1e-4 * FIRST
    first = np.sqrt(made.coordinates.stiffness[1])
    assert first == pytest.approx(2.0 * FIRST, rel=1e-4)


def test_asked_for_modes_are_there_even_where_no_point_sees_them() -> None:
    free = rod(400, held=False)
    seen = reduced_host(free, {"middle": 200}, 0.5 * FIRST)
    asked = reduced_host(free, {"middle": 200}, 0.5 * FIRST, modes=4)
    whole = np.sqrt(np.maximum(np.linalg.eigvalsh(_scaled(free)), 0.0))[:4]
    assert np.sqrt(asked.coordinates.stiffness[1:4]) == pytest.approx(whole[1:], rel=1e-9)
    assert not np.isclose(np.sqrt(seen.coordinates.stiffness[1]), whole[1], rtol=1e-3)


def _scaled(of: Matrices) -> np.ndarray:
    root = np.linalg.inv(np.linalg.cholesky(of.mass.toarray()))
    return root @ of.stiffness.toarray() @ root.T


def test_signs_of_pivots_count_negative_eigenvalues() -> None:
    of = rod(50)
    for part, below in ((0.5, 0), (2.0, 1), (4.0, 2), (6.2, 3)):
        assert negative_count(of.stiffness - (part * FIRST) ** 2 * of.mass) == below


@pytest.mark.parametrize(("n", "least", "most"), [(10, 0.0, 1e-11), (300, 1e-8, 1e-6), (10_000, 1e-3, 1.0)])
def test_a_beam_of_too_many_elements_is_noticed(n: int, least: float, most: float) -> None:
    lost = digits_lost(beam(n), [2 * n - 2])
    assert least <= lost.worst <= most


def test_lost_digits_are_those_of_rounding_every_entry() -> None:
    of, tip = beam(300), 598
    lost = digits_lost(of, [tip])
    plain = reduced_host(of, {"tip": tip}, 1.0).coordinates.receptances(np.zeros(1))[0, 0, 0].real
    moved = []
    signs = np.random.default_rng(1)
    for _ in range(12):
        upper = sparse.triu(of.stiffness).tocsc()
        upper.data = upper.data * (1.0 + 2.0**-47 * signs.uniform(-1, 1, len(upper.data)))
        whole = (upper + sparse.triu(upper, 1).T).tocsc()
        rounded = Matrices(of.mass, of.damping, whole)
        moved.append(reduced_host(rounded, {"tip": tip}, 1.0).coordinates.receptances(np.zeros(1))[0, 0, 0].real)
    spread = float(np.sqrt(np.mean((np.array(moved) / plain - 1.0) ** 2))) * 2.0**-6
    assert 0.3 < lost.rounding / spread < 3.0


def _carrying(at: Coordinates, *, series: bool = False) -> Model:
    """Two absorbers, six variables: mass, frequency and damping ratio of each, on a structure between points."""
    builder = ModelBuilder(6)
    names = [f"host {i}" for i in range(at.count)]
    for name in names:
        builder.add_coordinate(name)
    for point, row in at.points.items():
        builder.add_point(point, dict(zip(names, row.tolist(), strict=True)))
    for absorber in ("one", "two"):
        builder.add_coordinate(absorber)
        builder.add_point(absorber, {absorber: 1.0})
    builder.add_base("floor")
    for name, mass, stiffness, c in zip(names, at.mass, at.stiffness, np.diag(at.damping), strict=True):
        builder.add_term(INERTIA, {name: 1.0}, Monomial(float(mass)), "host")
        builder.add_term(STIFFNESS, {name: 1.0}, Monomial(float(stiffness)), "host")
        builder.add_term(DAMPING, {name: 1.0}, Monomial(float(c)), "host")
    builder.add_link("mount", ("floor", next(iter(at.points))), Monomial(1.0))
    builder.add_stiffness("mount", Monomial(3e7))
    below = ["a", "one" if series else "b"]
    for i, (absorber, on) in enumerate(zip(("one", "two"), below, strict=True)):
        m, w, z = 3 * i, 3 * i + 1, 3 * i + 2
        builder.add_inertia(absorber, Monomial(1.0, {m: 1.0}))
        builder.add_link(f"spring {absorber}", (on, absorber), Monomial(1.0))
        builder.add_stiffness(f"spring {absorber}", Monomial(1.0, {m: 1.0, w: 2.0}))
        builder.add_damping(f"spring {absorber}", Monomial(2.0, {m: 1.0, w: 1.0, z: 1.0}))
    return builder.build()


def _design(at: Coordinates) -> np.ndarray:
    low = np.sqrt(at.stiffness[at.stiffness > 0][:2])
    return np.array([20.0, low[0], 0.1, 9.0, low[-1], 0.03])


def _hosts() -> dict[str, Coordinates]:
    return {
        "damped": reduced_host(rod(80, mass_damping=9.0), {"a": 79, "b": 40}, 6.0 * FIRST).coordinates,
        "undamped": reduced_host(rod(80), {"a": 79, "b": 40}, 6.0 * FIRST).coordinates,
    }


@pytest.mark.sampled(5)
@pytest.mark.parametrize("series", [False, True], ids=["parallel", "series"])
@pytest.mark.parametrize("host", ["damped", "undamped"])
@pytest.mark.parametrize("read", ["point", "absorber", "stroke", "force"])
@pytest.mark.parametrize("on", ["a", "b", "two", "floor"])
def test_designs_from_receptances_are_those_of_the_whole_model(host: str, series: bool, read: str, on: str) -> None:
    at = _hosts()[host]
    model = _carrying(at, series=series)
    outputs: dict[str, Output] = {
        "point": at_point(model, "b", 2),
        "absorber": at_point(model, "one", 1),
        "stroke": across_link(model, "spring two"),
        "force": link_forces(model, {"spring one": 1.0, "mount": -1.0}),
    }
    line = Line(1.0, model.points[on].astype(complex), FLAT)
    speeds = np.linspace(0.0, 5.9, 60) * FIRST
    few = Attached.of(model, outputs[read], line, speeds)
    x = _design(at) * np.array([1.0, 0.97, 1.1, 1.0, 1.05, 1.0])
    value, slope = few.slopes(x)
    whole, whole_slope = line_slope(model, outputs[read], line, x, speeds)
    assert np.abs(value - whole).max() < 1e-9 * np.abs(whole).max()
    assert np.abs(slope - whole_slope).max() < 1e-9 * np.abs(whole_slope).max()
    assert np.abs(few.response(x) - value).max() <= 1e-13 * np.abs(value).max()


@pytest.mark.parametrize("series", [False, True], ids=["parallel", "series"])
@pytest.mark.parametrize("on", ["a", "floor"])
def test_what_reads_one_machine_under_one_load_is_found_together_as_one_by_one(series: bool, on: str) -> None:
    at = _hosts()["damped"]
    model = _carrying(at, series=series)
    outputs = [at_point(model, "b", 2), at_point(model, "one", 1), across_link(model, "spring two")]
    line = Line(1.0, model.points[on].astype(complex), FLAT)
    speeds = np.linspace(0.0, 5.9, 20) * FIRST
    hosted = [Attached.of(model, output, line, speeds) for output in outputs]
    assert len({one.alike for one in hosted}) == 1
    x = _design(at)
    for output, (value, slope) in zip(outputs, slopes_of(hosted, x), strict=True):
        whole, whole_slope = line_slope(model, output, line, x, speeds)
        assert np.abs(value - whole).max() < 1e-9 * np.abs(whole).max()
        assert np.abs(slope - whole_slope).max() < 1e-9 * np.abs(whole_slope).max()


@pytest.mark.parametrize("series", [False, True], ids=["parallel", "series"])
@pytest.mark.parametrize("read", ["point", "absorber", "stroke"])
def test_slopes_are_found_of_what_is_picked_alone(series: bool, read: str) -> None:
    at = _hosts()["damped"]
    model = _carrying(at, series=series)
    outputs = {"point": at_point(model, "b", 2), "absorber": at_point(model, "one", 1)}
    outputs["stroke"] = across_link(model, "spring two")
    line = Line(1.0, model.points["a"].astype(complex), FLAT)
    speeds = np.linspace(0.1, 5.9, 20) * FIRST
    goal, limit = (Attached.of(model, output, line, speeds) for output in (outputs["point"], outputs[read]))
    x = _design(at)
    high = float(np.median(np.abs(limit.response(x))))
    whole, picked = slopes_of([goal, limit], x, [None, lambda value: np.abs(value) > high])
    assert whole[1].shape == (20, len(x))
    value, slope = line_slope(model, outputs[read], line, x, speeds)
    assert np.abs(picked[0] - value).max() < 1e-9 * np.abs(value).max()
    some = slope[np.abs(value) > high]
    assert picked[1].shape == some.shape == (10, len(x))
    assert np.abs(picked[1] - some).max() < 1e-9 * np.abs(slope).max()
    assert slopes_of([limit], x, [lambda value: np.zeros(len(value), dtype=bool)])[0][1].shape == (0, len(x))


def test_what_stands_under_another_load_is_found_apart() -> None:
    model = _carrying(_hosts()["damped"])
    lines = [Line(1.0, model.points[on].astype(complex), FLAT) for on in ("a", "b")]
    hosted = [Attached.of(model, at_point(model, "b", 2), line, np.ones(1)) for line in lines]
    assert hosted[0].alike != hosted[1].alike


def test_a_speed_on_an_undamped_resonance_of_the_structure_does_no_harm() -> None:
    at = of_modes(np.array([10.0]), np.zeros(1), np.array([100.0]), {"a": np.ones(1), "b": np.ones(1)})
    model = _carrying(at)
    line = Line(1.0, model.points["a"].astype(complex), FLAT)
    x = np.array([5.0, 10.0, 0.0 + 1e-3, 2.0, 14.0, 0.02])
    speeds = np.array([10.0, 10.0 * (1 + 1e-9)])
    found = Attached.of(model, at_point(model, "a"), line, speeds).slopes(x)[0]
    whole = line_slope(model, at_point(model, "a"), line, x, speeds)[0]
    assert found == pytest.approx(whole, rel=1e-10)


def test_two_roads_to_receptances_of_points_agree() -> None:
    """Points of sparse matrices with dampers, against modal coordinates with the same dampers."""
    of, places, dash = rod(300), np.array([299, 150]), 5e4
    omega = np.linspace(0.0, 5.0, 12) * FIRST
    direct = Dashed(of, places, dash).receptances(omega)
    at = reduced_host(of, {"a": 299, "b": 150}, 5.0 * FIRST).coordinates
    assert at.receptances(omega, dash) == pytest.approx(direct, rel=1e-9)


@pytest.mark.parametrize("full", [False, True], ids=["enough", "full"])
@pytest.mark.parametrize("damped", [True, False], ids=["damped", "undamped"])
def test_the_built_machine_moves_as_the_model(full: bool, damped: bool) -> None:
    of = rod(300, mass_damping=6.0 if damped else 0.0)
    at = reduced_host(of, {"a": 299, "b": 150}, 6.0 * FIRST).coordinates
    model, x = _carrying(at), _design(at)
    joints = tuple(
        Joint(f"spring {name}", (on, name), m * w * w, 2.0 * m * w * z, 0.0, m * w * w, 1.0)
        for name, on, (m, w, z) in (("one", "a", x[:3]), ("two", "b", x[3:]))
    )
    mount = Joint("mount", ("floor", "a"), 3e7, 0.0, 0.0, 3e7, 1.0)
    masses = {"one": float(x[0]), "two": float(x[3])}
    carrier = Carrier(at, of, np.array([299, 150]))
    built = HostedMachine(masses, (*joints, mount), ("floor",), masses, carriers={"rod": carrier}, full=full)
    speeds = np.concatenate([np.linspace(0.1, 5.9, 7) * FIRST, np.sqrt(at.stiffness[:2])])
    for on, forces in (("b", {"b": np.ones(9, complex)}), ("floor", {})):
        motion = built.shake(speeds, forces, {"floor": np.ones(9, complex)} if on == "floor" else {})
        for point in ("a", "b", "two"):
            line = Line(1.0, model.points[on].astype(complex), FLAT)
            whole = line_slope(model, at_point(model, point), line, x, speeds)[0]
            assert motion.points[point] == pytest.approx(whole, rel=1e-8)
    poles = np.sort(np.abs(built.natural_frequencies()))[:4]
    mass, _, stiffness, _ = built.matrices()
    assert poles**2 == pytest.approx(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)[:4], rel=1e-8)


@pytest.mark.parametrize("least_wanted", [False, True], ids=["greatest", "least"])
def test_peaks_found_through_modes_are_those_of_direct_solutions(
    least_wanted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = _carrying(_hosts()["damped"])
    drive = Drive("shaker", (Line(1.0, model.points["b"].astype(complex), FLAT),), (Band(0.2 * FIRST, 5.0 * FIRST),))
    form = Modulus(at_point(model, "a"), (drive,), "sum")
    x = _design(_hosts()["damped"])
    quick = form.extremes(model, x, least_wanted=least_wanted)
    monkeypatch.setattr(drive_response, "modal_of", lambda *_: None)
    direct = form.extremes(model, x, least_wanted=least_wanted)
    assert len(quick) == len(direct)
    for one, other in zip(quick, direct, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-9)
        assert one.slope == pytest.approx(other.slope, abs=1e-5)


def test_a_body_sags_with_the_structure_that_it_stands_on() -> None:
    """By the flexibility of two modes where it stands; the structure itself is drawn as it hangs."""
    shapes = [(8.0, 1.0), (31.0, -0.4)]
    modes = [
        {"frequency": f"{f} Hz", "damping_ratio": 0.02, "modal_mass": "5000 kg", "shape": {"mid": y}} for f, y in shapes
    ]
    sags = {
        "of": {"response": "static_deflection", "of": "pump"},
        "in": {"response": "static_deflection", "of": "mount"},
    }
    document = {
        "structures": {"floor": {"modes": modes}}, "bodies": {"pump": {"mass": "200 kg"}},
        "links": {"mount": {"between": ["pump", "mid"], "stiffness": "400 kN/m"}}, "measures": sags,
    }  # fmt: skip
    found = solve(from_dict(document), explain=False).measures
    weight, flexible = 200.0 * GRAVITY, sum(y**2 / (5000.0 * (2.0 * np.pi * f) ** 2) for f, y in shapes)
    right = [weight * (1.0 / 4e5 + flexible), weight / 4e5]
    assert [found[name].value.value for name in ("of", "in")] == pytest.approx(right, rel=1e-12)
