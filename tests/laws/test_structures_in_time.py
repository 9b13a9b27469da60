"""Structures in time and under white noise: against chains of bodies, exponentials of matrices and Lyapunov."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import eigh, expm, solve_continuous_lyapunov

import vibopt as vo
from vibopt.scene.read import from_dict

FEW = settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SAMPLES = 20_000
Array = NDArray[np.float64]

SHAKERS: dict[str, dict[str, Any]] = {
    "half sine": {"kind": "pulse", "on": "b0", "shape": "half sine", "amplitude": "1 kN", "duration": "0.1 s"},
    "rectangle": {"kind": "pulse", "on": "b1", "shape": "rectangle", "amplitude": "1 kN", "duration": "0.3 s"},
    "step": {"kind": "pulse", "on": "b1", "shape": "step", "amplitude": "1 kN"},
    "any length": {"kind": "pulse", "on": "b0", "shape": "triangle", "amplitude": "1 kN", "duration_up_to": "0.2 s"},
    "blow": {"kind": "drop", "on": "deck", "velocity_change": "0.2 m/s"},
    "ground": {"kind": "pulse", "on": "deck", "shape": "versed sine", "displacement": "5 mm", "duration": "0.4 s"},
    "let go": {"kind": "release", "on": "box", "displacement": "3 mm", "velocity": "-0.1 m/s"},
    "begun": {"kind": "force", "on": "b1", "amplitude": "200 N", "speed": "4 Hz", "begins": "suddenly"},
    "run-up": {"kind": "unbalance", "on": "b1", "unbalance": "2 kg m", "speed": "5 Hz",
               "run_up": {"acceleration": "3 Hz/s"}},
    "noise": {"kind": "white_noise", "on": "b0", "density": "100 N²/Hz"},
    "noise of the ground": {"kind": "white_noise", "on": "deck", "density": "1 mm²/Hz"},
}  # fmt: skip
ASKED = {
    "displacement": {"of": "b1"}, "velocity": {"of": "b0"}, "acceleration": {"of": "box"},
    "relative_displacement": {"across": "foot"}, "force": {"through": "foot"},
}  # fmt: skip


def answered(document: dict[str, Any]) -> dict[str, float]:
    """Measures on the machine as built; both routes agree."""
    design = vo.solve(from_dict(document))
    assert design.status == "met", design.claim
    return {name: row.value.value for name, row in design.measures.items()}


def shaken(shaker: str, document: dict[str, Any]) -> dict[str, Any]:
    """A machine under one excitation, and all that is asked of it."""
    sort = "rms" if shaker.startswith("noise") else "peak"
    asked = {kind: {"response": f"{sort}_{kind}", **place} for kind, place in ASKED.items()}
    if shaker == "blow":  # the base goes on with its velocity
        del asked["displacement"], asked["velocity"]
    if shaker == "any length":
        asked = {kind: asked[kind] for kind in ("displacement", "force")}
    if shaker == "noise of the ground":
        for kind in ("velocity", "acceleration", "force"):
            del asked[kind]
    return {**document, "excitations": {"shaker": SHAKERS[shaker]}, "measures": asked}


def carried(on: dict[str, Any]) -> dict[str, Any]:
    """A box on a point b0, which a base pulls at, of what is described otherwise."""
    return {
        **on,
        "bases": {"deck": {}},
        "bodies": {**on.get("bodies", {}), "box": {"mass": "40 kg"}},
        "links": {
            **on.get("links", {}),
            "foot": {"between": ["box", "b0"], "stiffness": "30 kN/m", "damping": "150 N s/m"},
            "held": {"between": ["b1", "deck"], "stiffness": "20 kN/m", "damping": "90 N s/m"},
        },
    }


def chain(masses: list[float], rate: float, lost: float) -> tuple[dict[str, Any], Array, Array, Array]:
    """Bodies one above the other on the ground, with dampers in proportion to springs, and their M, C, K."""
    n = len(masses)
    stiffness = masses[0] * rate**2
    bodies = {f"b{i}": {"mass": f"{mass!r} kg"} for i, mass in enumerate(masses)}
    spring = {"stiffness": f"{stiffness!r} N/m", "damping": f"{lost * stiffness!r} N s/m"}
    links = {f"s{i}": {"between": [f"b{i}", f"b{i - 1}" if i else "ground"], **spring} for i in range(n)}
    K = stiffness * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[-1, -1] = stiffness
    return {"bodies": bodies, "links": links}, np.diag(masses), lost * K, K


def by_modes(M: Array, C: Array, K: Array) -> dict[str, Any]:
    """The same as a list of all modes."""
    squares, shapes = eigh(K, M)
    modes = [
        {
            "frequency": f"{square**0.5!r} rad/s",
            "damping_ratio": float(shape @ C @ shape / (2.0 * square**0.5)) if square else 0.0,
            "modal_mass": "1 kg",
            "shape": {f"b{i}": float(value) for i, value in enumerate(shape)},
        }
        for square, shape in zip(np.where(squares > 1e-9 * squares[-1], squares, 0.0).tolist(), shapes.T, strict=True)
    ]
    return {"structures": {"frame": {"modes": modes}}}


def by_matrices(folder: Path, M: Array, C: Array, K: Array, points: list[int]) -> dict[str, Any]:
    """The same as matrices in a file, with points b0 and so on at some coordinates."""
    np.savez(folder / "frame.npz", M=M, C=C, K=K)
    named = {f"b{i}": place for i, place in enumerate(points)}
    return {"structures": {"frame": {"file": str(folder / "frame.npz"), "points": named}}}


@pytest.mark.parametrize(
    "shaker", [pytest.param(one, marks=[pytest.mark.slow] * (one in ("any length", "rectangle"))) for one in SHAKERS]
)
@FEW
@given(st.lists(st.floats(50.0, 500.0), min_size=2, max_size=4), st.floats(15.0, 60.0), st.floats(1e-4, 2e-3))
def test_modes_and_matrices_of_a_chain_are_the_chain(
    tmp_path_factory: pytest.TempPathFactory, shaker: str, masses: list[float], rate: float, lost: float
) -> None:
    bodies, *matrices = chain(masses, rate, lost)
    own = answered(shaken(shaker, carried(bodies)))
    folder = tmp_path_factory.mktemp("chain")
    for other in (by_modes(*matrices), by_matrices(folder, *matrices, list(range(len(masses))))):
        assert answered(shaken(shaker, carried(other))) == pytest.approx(own, rel=1e-6)


@pytest.mark.parametrize("asked", ["steady", "run-up"])
@FEW
@given(st.lists(st.floats(50.0, 500.0), min_size=2, max_size=4), st.floats(15.0, 60.0), st.floats(1e-4, 2e-3))
def test_a_free_chain_on_springs_is_that_chain_from_standstill_on(
    tmp_path_factory: pytest.TempPathFactory, asked: str, masses: list[float], rate: float, lost: float
) -> None:
    """Receptances of what nothing holds have no end at standstill; those of the machine have."""
    bodies, M, C, K = chain(masses, rate, lost)
    spring = bodies["links"].pop("s0")
    C[0, 0], K[0, 0] = C[0, 0] / 2.0, K[0, 0] / 2.0
    spun = {"kind": "unbalance", "on": "b1", "unbalance": "2 kg m", "speed": "5 Hz"}
    if asked == "run-up":
        spun["run_up"] = {"acceleration": "3 Hz/s"}
    kinds = ("peak_displacement", "peak_acceleration") if asked == "run-up" else ("displacement", "transmitted_force")
    measures = {kind: {"response": kind, **({"through": "s0"} if "force" in kind else {"of": "b0"})} for kind in kinds}
    if asked == "steady":
        measures = {kind: {**one, "over": "start-up"} for kind, one in measures.items()}
    found = []
    for on in (bodies, by_modes(M, C, K), by_matrices(tmp_path_factory.mktemp("free"), M, C, K, [*range(len(M))])):
        document = carried(on)
        document["links"]["s0"] = spring
        found.append(answered({**document, "excitations": {"spun": spun}, "measures": measures}))
    assert found[1] == pytest.approx(found[0], rel=1e-6)
    assert found[2] == pytest.approx(found[0], rel=1e-6)


@pytest.mark.parametrize("asked", ["steady", "noise", "run-up"])
@FEW
@given(
    st.lists(st.tuples(st.floats(1.0, 500.0), st.floats(1e3, 1e6)), min_size=2, max_size=20),
    st.sampled_from([0.0, 1e-4, 2e-3]),
    st.sampled_from([3, 4, 17]),
)
def test_a_free_chain_is_that_of_its_bodies(
    tmp_path_factory: pytest.TempPathFactory,
    asked: str,
    parts: list[tuple[float, float]],
    lost: float,
    digits: int,
) -> None:
    """Rounding of matrices whose rows add up to a last digit holds nothing to the ground."""
    M, K = np.diag([mass for mass, _ in parts]), np.zeros((len(parts), len(parts)))
    links: dict[str, Any] = {}
    for i, (_, drawn) in enumerate(parts[1:]):
        stiffness = float(f"{drawn:.{digits}g}")
        spring = {"stiffness": f"{stiffness!r} N/m", "damping": f"{lost * stiffness!r} N s/m"}
        links[f"s{i}"] = {"between": [f"b{i}", f"b{i + 1}"], **spring}
        K[i : i + 2, i : i + 2] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    bodies = {"bodies": {f"b{i}": {"mass": f"{mass!r} kg"} for i, (mass, _) in enumerate(parts)}, "links": links}
    shaker = {
        "steady": {"kind": "force", "on": "box", "amplitude": "100 N", "speed": "1..20 Hz", "varies": "constant"},
        "noise": {"kind": "white_noise", "on": "deck", "density": "0.1 (m/s²)²/Hz"},
        "run-up": {**SHAKERS["run-up"], "on": "box"},
    }[asked]
    sort = {"steady": "", "noise": "rms_", "run-up": "peak_"}[asked]
    measures = {
        "box": {"response": f"{sort}acceleration", "of": "box"},
        "base": {"response": f"{sort or 'transmitted_'}force", "through": "held"},
    }
    found = [
        answered({**carried(on), "excitations": {"shaker": shaker}, "measures": measures})
        for on in (bodies, by_matrices(tmp_path_factory.mktemp("free"), M, lost * K, K, [*range(len(parts))]))
    ]
    assert found[1] == pytest.approx(found[0], rel=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_one_mode_is_one_mass_on_a_spring_of_any_size(scale: float) -> None:
    """An undamped step moves it to twice the static deflection, from which F/m and F/sqrt(k m) follow."""
    mass, stiffness, force = 30.0 * scale, 12e3 * scale**2, 5.0 * scale
    mode = {"frequency": f"{(stiffness / mass) ** 0.5!r} rad/s", "modal_mass": f"{mass!r} kg", "shape": {"top": 1.0}}
    found = answered({
        "structures": {"mast": {"modes": [mode]}},
        "excitations": {"pull": {"kind": "pulse", "on": "top", "shape": "step", "amplitude": f"{force!r} N"}},
        "measures": {kind: {"response": f"peak_{kind}", "of": "top"}
                     for kind in ("displacement", "velocity", "acceleration")},
    })  # fmt: skip
    assert found == pytest.approx(
        {
            "displacement": 2.0 * force / stiffness,
            "velocity": force / np.sqrt(stiffness * mass),
            "acceleration": force / mass,
        },
        rel=1e-9,
    )


def any_matrices(seed: int, n: int) -> tuple[Array, Array, Array]:
    """Symmetric, of positive energy, and not of proportional damping."""
    draw = np.random.default_rng(seed)
    first, second, third = draw.normal(size=(3, n, n))
    M = 40.0 * (first @ first.T / n + np.eye(n))
    K = 9e4 * (second @ second.T / n + 0.3 * np.eye(n))
    return M, 60.0 * (third @ third.T / n + 0.1 * np.eye(n)), K


def with_box(M: Array, C: Array, K: Array) -> tuple[Array, Array, Array, Array]:
    """A box of 40 kg on coordinate 0, behind the others, as in `carried`; and the row of its stretch."""
    n = len(M)
    row = np.zeros(n + 1)
    row[[0, n]] = -1.0, 1.0
    M, C, K = (np.pad(one, (0, 1)) for one in (M, C, K))
    M[n, n] = 40.0
    return M, C + 150.0 * np.outer(row, row), K + 30e3 * np.outer(row, row), row


def rates(M: Array, C: Array, K: Array) -> Array:
    """Of places and velocities, (2 n, 2 n)."""
    inverse = np.linalg.inv(M)
    return np.block([[np.zeros(M.shape), np.eye(len(M))], [-inverse @ K, -inverse @ C]])


def standing(folder: Path, matrices: tuple[Array, Array, Array]) -> dict[str, Any]:
    """A box on coordinate 0 of matrices."""
    document = carried(by_matrices(folder, *matrices, [0, len(matrices[0]) - 1]))
    del document["bases"], document["links"]["held"]
    return document


@FEW
@given(st.integers(0, 10**6), st.integers(2, 7), st.floats(0.02, 0.5))
def test_any_matrices_move_as_their_exponential_says(
    tmp_path_factory: pytest.TempPathFactory, seed: int, n: int, duration: float
) -> None:
    document = standing(tmp_path_factory.mktemp("any"), matrices := any_matrices(seed, n))
    M, C, K, row = with_box(*matrices)
    a, omega = rates(M, C, K), np.pi / duration
    push = np.linalg.solve(M, np.eye(n + 1)[n - 1])
    whole = np.zeros((2 * n + 4, 2 * n + 4))
    whole[:-2, :-2], whole[n + 1 : -2, -2], whole[-2, -1], whole[-1, -2] = a, push, omega, -omega
    free = np.zeros(whole.shape)
    free[:-2, :-2] = a
    now, seen = np.eye(len(whole))[-1], []
    for step in (expm(whole * duration / SAMPLES), expm(free * 3.0 / SAMPLES)):
        for _ in range(SAMPLES):
            seen.append(now)
            now = step @ now
        now[-2:] = 0.0
    states = np.array(seen)
    places, speeds, force = states[:, : n + 1], states[:, n + 1 : -2], states[:, -2]
    fast = states[:, :-2] @ a[n + 1 :].T + force[:, None] * push
    own = {
        "displacement": places[:, n - 1],
        "velocity": speeds[:, 0],
        "acceleration": fast[:, n],
        "relative_displacement": places @ row,
        "force": 30e3 * places @ row + 150.0 * speeds @ row,
    }
    hit = {"kind": "pulse", "on": "b1", "shape": "half sine", "amplitude": "1 N", "duration": f"{duration!r} s"}
    measures = {kind: {"response": f"peak_{kind}", **place} for kind, place in ASKED.items()}
    found = answered({**document, "excitations": {"hit": hit}, "measures": measures})
    for kind, values in own.items():
        sampled = float(np.abs(values).max())
        assert sampled <= found[kind] * (1.0 + 1e-9)
        assert found[kind] == pytest.approx(sampled, rel=1e-5)


@FEW
@given(st.integers(0, 10**6), st.integers(2, 40))
def test_any_matrices_under_white_noise_are_those_of_the_lyapunov_equation(
    tmp_path_factory: pytest.TempPathFactory, seed: int, n: int
) -> None:
    document = standing(tmp_path_factory.mktemp("noise"), matrices := any_matrices(seed, n))
    M, C, K, row = with_box(*matrices)
    push = np.concatenate([np.zeros(n + 1), np.linalg.solve(M, np.eye(n + 1)[n - 1])])
    states = solve_continuous_lyapunov(rates(M, C, K), -0.5 * np.outer(push, push))
    read = {"displacement": np.eye(2 * n + 2)[n - 1], "velocity": np.eye(2 * n + 2)[n + 1]}
    read["relative_displacement"] = np.concatenate([row, np.zeros(n + 1)])
    measures = {kind: {"response": f"rms_{kind}", **ASKED[kind]} for kind in read}
    noise = {"kind": "white_noise", "on": "b1", "density": "1 N²/Hz"}
    found = answered({**document, "excitations": {"noise": noise}, "measures": measures})
    assert found == pytest.approx({kind: float(np.sqrt(one @ states @ one)) for kind, one in read.items()}, rel=1e-7)


@FEW
@given(st.integers(0, 10**6), st.integers(2, 6))
def test_a_blow_here_moves_there_as_one_there_moves_here(
    tmp_path_factory: pytest.TempPathFactory, seed: int, n: int
) -> None:
    document = standing(tmp_path_factory.mktemp("both"), any_matrices(seed, n))
    hit = {"kind": "pulse", "shape": "triangle", "amplitude": "1 N", "duration": "0.05 s"}
    there, here = (
        answered({
            **document,
            "excitations": {"hit": {**hit, "on": on}},
            "measures": {"moved": {"response": "peak_displacement", "of": of}},
        })["moved"]
        for on, of in (("b1", "box"), ("box", "b1"))
    )  # fmt: skip
    assert there == pytest.approx(here, rel=1e-8)


@pytest.mark.parametrize("shaker", ["half sine", "step", "noise"])
@pytest.mark.parametrize("lost", [0.0, 4e-4])
def test_coordinates_without_mass_follow_the_others(tmp_path: Path, shaker: str, lost: float) -> None:
    """Of every second coordinate without mass, springs in a row are one of half the stiffness."""
    masses = [120.0, 200.0, 90.0]
    whole = chain([80.0] * 6, 40.0, lost)
    light = np.diag([0.0, masses[0], 0.0, masses[1], 0.0, masses[2]])
    short = chain(masses, float(np.sqrt(0.5 * 80.0 * 40.0**2 / masses[0])), lost)
    found = answered(shaken(shaker, carried(by_matrices(tmp_path, light, *whole[2:], [1, 3, 5]))))
    assert found == pytest.approx(answered(shaken(shaker, carried(short[0]))), rel=1e-6)


def test_more_coordinates_than_are_carried_are_refused(tmp_path: Path) -> None:
    large = chain([100.0] * 101, 60.0, 1e-4)[1:]
    for shaker, key in (("half sine", "displacement"), ("noise", "displacement")):
        with pytest.raises(vo.InputError) as refused:
            from_dict(shaken(shaker, carried(by_matrices(tmp_path, *large, [40, 100]))))
        assert (
            f"measures.{key} takes every mode of structures.frame, whose matrices have 101 coordinates with mass; 100 "
            "are the most that are carried so. Give its modes up to the highest frequency that counts instead."
        ) in str(refused.value)


def test_a_point_is_not_let_go() -> None:
    document = shaken("let go", carried(by_modes(*chain([90.0, 60.0], 30.0, 1e-3)[1:])))
    document["excitations"] = {"shaker": {**SHAKERS["let go"], "on": "b1"}}
    with pytest.raises(vo.InputError) as refused:
        from_dict(document)
    assert (
        "excitations.shaker lets b1 go, a point of a structure, and says nothing of how the rest of it is bent. Let a "
        'body go that stands there, or push it: kind = "pulse".'
    ) in str(refused.value)


def test_a_mesh_that_is_braked_too_fast_is_told_its_way_out(tmp_path: Path) -> None:
    stiff = chain([1e-6] * 3, 1e6, 1.0)[1:]
    with pytest.raises(vo.InputError) as refused:
        from_dict(shaken("half sine", carried(by_matrices(tmp_path, *stiff, [0, 2]))))
    assert (
        "more than the 100000 that are followed. Write a shorter load or a smaller damping, or give structures.frame "
        "by its lowest modes."
    ) in str(refused.value)
