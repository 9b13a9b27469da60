"""Random vibration and decay rates against matrices written by hand, in state space and in time."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import vibopt as vo
from vibopt.forms.mean_square import _lyapunov
from vibopt.program.pose import on_needed, pose
from vibopt.verify.certify import measure

Array = NDArray[np.float64]
NAMES = ("a", "b", "c")


class Chain:
    """Bodies one on the other, the first on a support, and a last link back to it or to the first body."""

    def __init__(self, seed: int, support: str) -> None:
        rng = np.random.default_rng(seed)
        self.support = support
        self.n = int(rng.integers(1, 4))
        self.masses = 10.0 ** rng.uniform(-1, 2, self.n)
        pairs = [(i - 1, i) for i in range(self.n)] + ([(-1, self.n - 1)] if rng.random() < 0.4 else [])
        self.links = [
            (i, j, float(10.0 ** rng.uniform(2, 5)), float(10.0 ** rng.uniform(0, 2.5)), int(rng.integers(1, 4)))
            for i, j in pairs
        ]
        self.on = int(rng.integers(self.n))
        self.density = float(10.0 ** rng.uniform(-2, 3))

    def document(self, measures: dict[str, Any]) -> dict[str, Any]:
        bases = {"base": {}} if self.support == "base" else {}
        shaker = (
            {"on": "base", "density": f"{self.density!r} (m/s²)²/Hz"}
            if bases
            else {"on": NAMES[self.on], "density": f"{self.density!r} N²/Hz"}
        )
        return {
            "bodies": {name: {"mass": f"{mass!r} kg"} for name, mass in zip(NAMES, self.masses.tolist(), strict=False)},
            "bases": bases,
            "links": {
                f"l{k}": {
                    "between": [self.support if i < 0 else NAMES[i], NAMES[j]],
                    "stiffness": f"{stiffness!r} N/m",
                    "damping": f"{damping!r} N s/m",
                    "count": count,
                }
                for k, (i, j, stiffness, damping, count) in enumerate(self.links)
            },
            "excitations": {"noise": {"kind": "white_noise", **shaker}},
            "measures": measures,
        }

    def rows(self) -> Array:
        table = np.zeros((len(self.links), self.n))
        for k, (i, j, *_) in enumerate(self.links):
            table[k, j] += 1.0
            if i >= 0:
                table[k, i] -= 1.0
        return table

    def state(self) -> tuple[Array, Array]:
        """A, and B of the force or of the base's acceleration in coordinates relative to it."""
        table = self.rows()
        k = table.T @ np.diag([one[2] * one[4] for one in self.links]) @ table
        c = table.T @ np.diag([one[3] * one[4] for one in self.links]) @ table
        over = np.diag(1.0 / self.masses)
        a = np.block([[np.zeros((self.n, self.n)), np.eye(self.n)], [-over @ k, -over @ c]])
        b = np.zeros(2 * self.n)
        b[self.n :] = -1.0 if self.support == "base" else over[:, self.on]
        return a, b

    def rms(self, c: Array) -> float:
        """Root mean square of c x by the Kronecker form of the Lyapunov equation."""
        a, b = self.state()
        eye = np.eye(len(a))
        whole = np.kron(a, eye) + np.kron(eye, a)
        p = np.linalg.solve(whole, -0.5 * self.density * np.outer(b, b).ravel()).reshape(a.shape)
        return float(np.sqrt(c @ p @ c))


def _readings(chain: Chain) -> dict[str, tuple[dict[str, Any], Array]]:
    n, body = chain.n, chain.n - 1
    table, nothing = chain.rows(), np.zeros(chain.n)
    a, _ = chain.state()
    _, _, stiffness, damping, _ = chain.links[-1]
    across = table[-1]
    asked = {
        "across": ({"response": "rms_relative_displacement", "across": f"l{len(chain.links) - 1}"}, [across, nothing]),
        "through": (
            {"response": "rms_force", "through": f"l{len(chain.links) - 1}"},
            [stiffness * across, damping * across],
        ),
    }
    own = np.eye(n)[body]
    if chain.support == "ground":
        asked["move"] = ({"response": "rms_displacement", "of": NAMES[body]}, [own, nothing])
        asked["speed"] = ({"response": "rms_velocity", "of": NAMES[body]}, [nothing, own])
        total = sum(one[2] * one[4] * table[k] for k, one in enumerate(chain.links) if one[0] < 0)
        dash = sum(one[3] * one[4] * table[k] for k, one in enumerate(chain.links) if one[0] < 0)
        asked["floor"] = ({"response": "rms_force", "into": "ground"}, [total, dash])
    if chain.support == "base" or chain.on != body:
        asked["shock"] = ({"response": "rms_acceleration", "of": NAMES[body]}, list(np.split(a[n + body], 2)))
    return {name: (words, np.concatenate(parts)) for name, (words, parts) in asked.items()}


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), support=st.sampled_from(["ground", "base"]))
@example(seed=8328, support="base")  # far above its modes what is left of the response is rounding
def test_a_mean_square_is_that_of_the_matrices_and_of_the_built_machine(seed: int, support: str) -> None:
    chain = Chain(seed, support)
    readings = _readings(chain)
    scene = vo.from_dict(chain.document({name: words for name, (words, _) in readings.items()}))
    program = pose(scene)
    for name, response in scene.measures.items():
        wanted = chain.rms(readings[name][1])
        model, form = on_needed(scene, program.model, response)
        value = form.value(model, np.zeros(0))
        assert value == pytest.approx(wanted, rel=1e-5)  # the Kronecker form loses digits to fast and slow poles
        assert measure(scene, {}, response).value == pytest.approx(value, rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), support=st.sampled_from(["ground", "base"]))
def test_slopes_are_those_of_the_values(seed: int, support: str) -> None:
    chain = Chain(seed, support)
    document = chain.document({})
    document["measures"] = {name: words for name, (words, _) in _readings(chain).items()}
    document["measures"]["decay"] = {"response": "decay_rate"}
    paths = [("bodies", "a", "mass"), ("links", "l0", "stiffness"), ("links", "l0", "damping")]
    x = []
    for family, name, key in paths:
        number, unit = document[family][name][key].split(" ", 1)
        x.append(float(number))
        document[family][name][key] = {"from": f"{0.5 * x[-1]!r} {unit}", "to": f"{2.0 * x[-1]!r} {unit}"}
    document["goal"] = {"minimise": "mass", "of": "a"}
    scene = vo.from_dict(document)
    order = [paths.index(tuple(one.path.split("."))) for one in scene.variables]
    at = np.array(x)[order]
    program = pose(scene)
    for response in scene.measures.values():
        model, form = on_needed(scene, program.model, response)
        slope = form.slope(model, at)
        tight = 2e-3 if response.response == "decay_rate" else 2e-5  # of slow poles beside fast ones
        step = 1e-5
        for i in range(len(at)):
            up, down = at.copy(), at.copy()
            up[i] *= np.exp(step)
            down[i] *= np.exp(-step)
            ends = [np.log(form.value(model, one)) for one in (up, down)]
            assert slope[i] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=2e-4, abs=tight)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_decay_rate_is_that_of_the_slowest_pole(seed: int) -> None:
    chain = Chain(seed, "ground")
    scene = vo.from_dict(chain.document({"decay": {"response": "decay_rate"}}))
    rates = np.linalg.eigvals(chain.state()[0])
    gaps = np.abs(rates[:, None] - rates[None, :]) + np.abs(rates).max() * np.eye(len(rates))
    assume(gaps.min() > 1e-4 * np.abs(rates).max())
    wanted = float(-rates.real.max())
    model, form = on_needed(scene, pose(scene).model, scene.measures["decay"])
    size = float(np.abs(rates).max())
    assert form.value(model, np.zeros(0)) == pytest.approx(wanted, rel=1e-8, abs=1e-11 * size)
    assert measure(scene, {}, scene.measures["decay"]).value == pytest.approx(wanted, rel=1e-8, abs=1e-11 * size)


def _value(document: dict[str, Any]) -> float:
    scene = vo.from_dict(document)
    return float(measure(scene, {}, next(iter(scene.measures.values()))).value)


def _one(**noise: Any) -> dict[str, Any]:
    return {
        "bodies": {"m": {"mass": "2 kg"}},
        "bases": {"b": {}},
        "links": {"l": {"between": ["b", "m"], "stiffness": "8 kN/m", "damping": "5 N s/m"}},
        "excitations": {"w": {"kind": "white_noise", **noise}},
    }


def test_units_of_density_and_scales() -> None:
    shock = {"x": {"response": "rms_acceleration", "of": "m"}}
    a = _value({**_one(on="b", density="1 (m/s²)²/Hz"), "measures": shock})
    assert _value({**_one(on="b", density="4 m^2/s^4/Hz"), "measures": shock}) == pytest.approx(2.0 * a, rel=1e-12)
    mine = _value({**_one(on="b", density="4e6 (mm/s^2)^2/Hz"), "measures": shock})
    assert mine == pytest.approx(2.0 * a, rel=1e-12)
    assert _value({**_one(on="b", density="1 g²/Hz"), "measures": shock}) == pytest.approx(9.80665 * a, rel=1e-12)
    move = {"x": {"response": "rms_displacement", "of": "m"}}
    x = _value({**_one(on="m", density="1 N²/Hz"), "measures": move})
    assert x == pytest.approx(np.sqrt(1.0 / (4.0 * 5.0 * 8000.0)), rel=1e-12)
    assert _value({**_one(on="m", density="1 lbf²/Hz"), "measures": move}) == pytest.approx(
        4.4482216152605 * x, rel=1e-12
    )
    both = _one(on="m", density="1 N²/Hz")
    both["excitations"]["v"] = {"kind": "white_noise", "on": "m", "density": "3 N²/Hz"}
    assert _value({**both, "measures": move}) == pytest.approx(2.0 * x, rel=1e-12)
    alone = {"x": {**move["x"], "due_to": ["w"]}}
    assert _value({**both, "measures": alone}) == pytest.approx(x, rel=1e-12)


def test_a_simulation_in_time_shows_the_same_mean_square() -> None:
    mass, stiffness, damping, density, step = 2.0, 800.0, 12.0, 5.0, 2e-3
    document = {
        "bodies": {"m": {"mass": f"{mass} kg"}},
        "links": {"l": {"between": ["m", "ground"], "stiffness": f"{stiffness} N/m", "damping": f"{damping} N s/m"}},
        "excitations": {"w": {"kind": "white_noise", "on": "m", "density": f"{density} N²/Hz"}},
        "measures": {"x": {"response": "rms_displacement", "of": "m"}},
    }
    rng = np.random.default_rng(20)
    x, v = np.zeros(6000), np.zeros(6000)
    total = []
    for i in range(1500):
        force = rng.normal(0.0, np.sqrt(0.5 * density / step), len(x))
        v = v + step * (force - stiffness * x - damping * v) / mass
        x = x + step * v
        if i >= 1000:
            total.append(np.mean(x**2))
    assert _value(document) == pytest.approx(np.sqrt(np.mean(total)), rel=0.02)


def test_what_has_no_end_is_infinite_on_both_roads_and_says_why() -> None:
    document = _one(on="m", density="1 N²/Hz")
    document["links"]["l"].pop("damping")
    document["measures"] = {"x": {"response": "rms_displacement", "of": "m"}}
    design = vo.solve(vo.from_dict(document))
    assert design.measures["x"].value.shown == "infinite"
    assert design.notes == (
        "measures.x: rms_displacement is infinite, for an undamped mode at 10.07 Hz is shaken by w, and nothing "
        "stops it.",
    )
    document = _one(on="b", density="1 (m/s²)²/Hz")
    document["links"]["g"] = {"between": ["m", "ground"], "stiffness": "1 kN/m"}
    document["measures"] = {"x": {"response": "rms_relative_displacement", "across": "l"}}
    design = vo.solve(vo.from_dict(document))
    assert design.measures["x"].value.shown == "infinite"
    assert design.notes == (
        "measures.x: rms_relative_displacement is infinite, for what the noise of w pushes drifts away without end.",
    )
    scene = vo.from_dict(document)
    model, form = on_needed(scene, pose(scene).model, scene.measures["x"])
    assert form.value(model, np.zeros(0)) == np.inf


def test_an_undamped_mode_that_is_not_shaken_does_no_harm() -> None:
    document: dict[str, Any] = {
        "bodies": {name: {"mass": "1 kg"} for name in "abc"},
        "links": {
            "ab": {"between": ["a", "b"], "stiffness": "1 kN/m"},
            "cb": {"between": ["c", "b"], "stiffness": "1 kN/m"},
            "foot": {"between": ["b", "ground"], "stiffness": "1 kN/m", "damping": "2 N s/m"},
        },
        "excitations": {"w": {"kind": "white_noise", "on": "b", "density": "1 N²/Hz"}},
        "measures": {"x": {"response": "rms_displacement", "of": "b"}},
    }
    scene = vo.from_dict(document)
    full = pose(scene, reduce=False)
    model, form = on_needed(scene, full.model, scene.measures["x"], reduce=False)
    value = form.value(model, np.zeros(0))
    assert np.isfinite(value)
    assert measure(scene, {}, scene.measures["x"]).value == pytest.approx(value, rel=1e-9)
    there = {**document, "measures": {"x": {"response": "rms_displacement", "of": "a"}}}
    document["excitations"] = {"w": {"kind": "white_noise", "on": "a", "density": "1 N²/Hz"}}
    assert _value(document) == pytest.approx(_value(there), rel=1e-9)
    document["measures"] = {"x": {"response": "rms_displacement", "of": "a"}}
    assert vo.solve(vo.from_dict(document)).measures["x"].value.value == np.inf


@settings(max_examples=25)
@given(
    hung=st.floats(0.1, 50.0),
    damping=st.floats(1.0, 300.0),
    stiffness=st.floats(1e3, 1e6),
    lossy=st.floats(5.0, 300.0),
)
def test_what_hangs_by_a_damper_alone_follows_and_drifts_only_where_it_is_pushed_itself(
    hung: float, damping: float, stiffness: float, lossy: float
) -> None:
    """20 kg on a spring, and a mass on it by a damper: no spring holds its place, yet nothing carries it away."""
    document = {
        "bodies": {"machine": {"mass": "20 kg"}},
        "links": {
            "mount": {
                "between": ["machine", "ground"],
                "stiffness": f"{stiffness!r} N/m",
                "damping": f"{lossy!r} N s/m",
            }
        },
        "absorbers": {"tmd": {"on": "machine", "mass": f"{hung!r} kg", "damping": f"{damping!r} N s/m"}},
        "excitations": {"noise": {"kind": "white_noise", "on": "machine", "density": "3 N²/Hz"}},
        "measures": {"place": {"response": "rms_displacement", "of": "tmd"}},
    }
    # c v' = c / m (v_machine - v): states x_machine, v_machine, v_hung; place = x_machine - m v_hung / c
    a = np.array(
        [
            [0.0, 1.0, 0.0],
            [-stiffness / 20.0, -(lossy + damping) / 20.0, damping / 20.0],
            [0.0, damping / hung, -damping / hung],
        ]
    )
    squares = np.kron(a, np.eye(3)) + np.kron(np.eye(3), a)
    b, row = np.array([0.0, 1.0 / 20.0, 0.0]), np.array([1.0, 0.0, -hung / damping])
    spread = np.linalg.solve(squares, -1.5 * np.outer(b, b).ravel()).reshape(3, 3)
    design = vo.solve(vo.from_dict(document))
    assert design.status == "met", design.claim
    assert design.measures["place"].value.value == pytest.approx(float(np.sqrt(row @ spread @ row)), rel=1e-7)
    document["excitations"]["noise"]["on"] = "tmd"
    assert vo.solve(vo.from_dict(document)).measures["place"].value.value == np.inf


def test_a_place_that_a_damper_alone_holds_is_designed() -> None:
    document = {
        "bodies": {"machine": {"mass": "20 kg"}},
        "links": {"mount": {"between": ["machine", "ground"], "stiffness": "40 kN/m", "damping": "60 N s/m"}},
        "absorbers": {"tmd": {"on": "machine", "mass": {"from": "0.5 kg", "to": "9 kg"}, "damping": "90 N s/m"}},
        "excitations": {"noise": {"kind": "white_noise", "on": "machine", "density": "3 N²/Hz"}},
        "goal": {"minimise": "rms_displacement", "of": "tmd"},
    }
    design = vo.solve(vo.from_dict(document))
    assert (design.status, design.variables["absorbers.tmd.mass"].value.value) == ("optimal", pytest.approx(9.0))


@pytest.mark.parametrize("slow", [1e-3, 1e-12, 1e-30])
def test_what_hardly_decays_beside_what_decays_at_once_has_its_own_share(slow: float) -> None:
    rates, turn = np.array([-slow, -1e9]), np.array([[1.0, 0.5], [0.0, 1.0]])
    load = np.array([1.0, 1e4])
    wanted = turn @ (np.outer(load, load) / -np.add.outer(rates, rates)) @ turn.T
    assert _lyapunov(turn @ np.diag(rates) @ np.linalg.inv(turn), turn @ load) == pytest.approx(wanted, rel=1e-8)
    assert np.isinf(_lyapunov(np.diag([1e-12, -1e9]), load)).all()


@pytest.mark.parametrize("ratio", [30.0, 1.5e5, 1e6])
@pytest.mark.parametrize("on", ["machine", "floor"])
def test_what_creeps_back_a_trillion_times_as_slowly_as_it_brakes_keeps_its_digits(ratio: float, on: str) -> None:
    """Place of one mass by S / (8 z w^3 m^2) per Hz, over which rounding of the fast rate went 1e-5 to 1e-4 of it."""
    mass, turn = 3.0, 10.0
    link = {"stiffness": f"{mass * turn**2} N/m", "damping": f"{2.0 * ratio * mass * turn!r} N s/m"}
    document: dict[str, Any] = {
        "bodies": {"machine": {"mass": f"{mass} kg"}},
        "links": {"mount": {"between": ["ground" if on == "machine" else "floor", "machine"], **link}},
        "excitations": {"noise": {"kind": "white_noise", "on": on, "density": "2 N²/Hz"}},
        "measures": {"x": {"response": "rms_relative_displacement", "across": "mount"}},
    }
    if on == "floor":
        document |= {"bases": {"floor": {}}}
        document["excitations"]["noise"]["density"] = f"{2.0 / mass**2!r} (m/s²)²/Hz"
    answer = vo.solve(vo.from_dict(document))
    assert answer.status == "met", answer.claim
    wanted = np.sqrt(2.0 / (8.0 * ratio * turn**3 * mass**2))
    assert answer.measures["x"].value.value == pytest.approx(wanted, rel=1e-9)
    posed = pose(vo.from_dict({**document, "limits": {"x": {**document.pop("measures")["x"], "at_most": "1 m"}}}))
    [limit] = posed.limits
    assert limit.form.value(limit.model, np.zeros(0)) == pytest.approx(wanted, rel=1e-9)


def _to_many_digits(chain: Chain, row: Array, displaced: bool) -> float:
    """Root mean square of row . (x, x') by the poles and residues of state matrices, to fifty digits.

    Of a displaced base v = x' - M^-1 C u in place of x', and u in place of its rates.
    """
    with mp.workdps(50):
        table, n = mp.matrix(chain.rows().tolist()), chain.n
        values = [[mp.mpf(one[kind]) * one[4] for one in chain.links] for kind in (2, 3)]
        k, c = (table.T * mp.diag(one) * table for one in values)
        over, a, b = mp.diag([1 / mp.mpf(one) for one in chain.masses.tolist()]), mp.zeros(2 * n), mp.zeros(2 * n, 1)
        pull, drag = (mp.matrix(table.T.tolist()) * mp.matrix([one[i] * (link[0] < 0) for i, link in
                      enumerate(chain.links)]) for one in values)  # fmt: skip
        a[:n, n:], a[n:, :n], a[n:, n:] = mp.eye(n), -over * k, -over * c
        if displaced:
            b[:n, 0], b[n:, 0] = over * drag, over * pull - over * c * over * drag
        else:
            for i in range(n):
                b[n + i] = -1 if chain.support == "base" else over[i, i] * (i == chain.on)
        rates, shapes = mp.eig(a)
        parts = [x * y for x, y in zip(mp.matrix(row.tolist()).T * shapes, shapes**-1 * b, strict=True)]
        pairs = [(i, j) for i in range(2 * n) for j in range(2 * n)]
        square = sum(parts[i] * mp.conj(parts[j]) / -(rates[i] + mp.conj(rates[j])) for i, j in pairs)
        return float(mp.sqrt(mp.re(square) * chain.density / 2))


@settings(max_examples=36, deadline=None)
@given(seed=st.integers(0, 10**6), shaken=st.sampled_from(["ground", "base", "displaced"]))
def test_what_hardly_decays_is_known_by_both_routes(seed: int, shaken: str) -> None:
    """Damping ratios of links down to 1e-15, most of them alike, some beside a link that damps well."""
    chain, rng = Chain(seed, "ground" if shaken == "ground" else "base"), np.random.default_rng(seed)
    ratios = 10.0 ** rng.uniform(-15.0, -5.0, len(chain.links))
    ratios[-1] = 0.1 if rng.random() < 0.3 else ratios[-1]
    chain.links = [
        (i, j, k, float(2.0 * ratio * np.sqrt(k * chain.masses[j])), count)
        for (i, j, k, _, count), ratio in zip(chain.links, ratios, strict=True)
    ]
    readings = _readings(chain)
    if shaken == "displaced":
        body = np.concatenate([np.eye(chain.n)[-1], np.zeros(chain.n)])
        readings = {"move": ({"response": "rms_displacement", "of": NAMES[chain.n - 1]}, body)}
    document = chain.document({name: words for name, (words, _) in readings.items()})
    if shaken == "displaced":
        document["excitations"]["noise"]["density"] = f"{chain.density!r} m²/Hz"
    scene = vo.from_dict(document)
    program = pose(scene)
    for name, response in scene.measures.items():
        wanted = _to_many_digits(chain, readings[name][1], shaken == "displaced")
        model, form = on_needed(scene, program.model, response)
        assert form.value(model, np.zeros(0)) == pytest.approx(wanted, rel=1e-6)
        assert measure(scene, {}, response).value == pytest.approx(wanted, rel=1e-6)
    assert vo.solve(scene).status == "met"


@pytest.mark.parametrize("damping", [0.5, 3.5, 300.0])
def test_what_hardly_decays_keeps_its_digits_beside_a_joint_that_follows_at_once(damping: float) -> None:
    """Rounding of the joint's rate went 3e-7 of the root mean square, and one number was sought in 3446 pieces."""
    document: dict[str, Any] = {
        "bodies": {"machine": {"mass": "50 kg"}, "rider": {"mass": "65 kg"}, "joint": {"mass": "0 kg"}},
        "links": {
            "mount": {"between": ["machine", "ground"], "stiffness": "1.6 MN/m", "damping": "0.03 N s/m"},
            "seat": {"between": ["rider", "machine"], "stiffness": "17 MN/m", "damping": "1.6 N s/m"},
            "spring": {"between": ["rider", "joint"], "stiffness": "8 MN/m"},
            "damper": {"between": ["joint", "ground"], "stiffness": "1.2 MN/m", "damping": f"{damping} N s/m"},
        },
        "excitations": {"noise": {"kind": "white_noise", "on": "machine", "density": "2 N²/Hz"}},
        "limits": {"force": {"response": "rms_force", "through": "spring", "at_most": "1 kN"}},
    }
    with mp.workdps(40):
        a, b = mp.zeros(5), mp.matrix([0, 0, mp.mpf(1) / 50, 0, 0])
        a[0, 2] = a[1, 3] = 1
        a[2, :] = mp.matrix([[-18.6e6, 17e6, mp.mpf("-1.63"), mp.mpf("1.6"), 0]]) / 50
        a[3, :] = mp.matrix([[17e6, -25e6, mp.mpf("1.6"), mp.mpf("-1.6"), 8e6]]) / 65
        a[4, :] = mp.matrix([[0, 8e6, 0, 0, -9.2e6]]) / damping
        rates, shapes = mp.eig(a)
        read = mp.matrix([[0, 8e6, 0, 0, -8e6]]) * shapes
        each = [(x * y, rate) for x, y, rate in zip(read, shapes**-1 * b, rates, strict=True)]
        square = sum(x * mp.conj(y) / -(r + mp.conj(s)) for x, r in each for y, s in each)
        wanted = float(mp.sqrt(mp.re(square)))
    [limit] = pose(vo.from_dict(document)).limits
    assert limit.form.value(limit.model, np.zeros(0)) == pytest.approx(wanted, rel=1e-11)
    assert vo.solve(vo.from_dict(document)).limits["force"].value.value == pytest.approx(wanted, rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), hung=st.sampled_from(["by a damper", "by both", "at a joint"]))
def test_a_base_accelerates_beside_the_ground(seed: int, hung: str) -> None:
    """A body between base and ground with others on it: accelerations, and a force that feels no drift."""
    rng = np.random.default_rng(seed)
    springs, dampers = 10.0 ** rng.uniform(3.0, 6.0, 4), 10.0 ** rng.uniform(0.5, 3.0, 4)
    dampers[3], springs[2] = (
        (0.0 if hung == "at a joint" else dampers[3]),
        (0.0 if hung == "by a damper" else springs[2]),
    )
    masses = np.array([10.0 ** rng.uniform(0.0, 2.0), 0.0 if hung == "at a joint" else 5.0, 3.0])
    ends = [("base", "a"), ("a", "ground"), ("a", "b"), ("b", "c")]
    links = {
        f"l{i}": {"between": list(ends[i])}
        | ({"stiffness": f"{float(springs[i])!r} N/m"} if springs[i] else {})
        | ({"damping": f"{float(dampers[i])!r} N s/m"} if dampers[i] else {})
        for i in range(4)
    }
    scene = vo.from_dict({
        "bodies": {name: {"mass": f"{mass!r} kg"} for name, mass in zip(NAMES, masses.tolist(), strict=True)},
        "bases": {"base": {}},
        "links": links,
        "excitations": {"noise": {"kind": "white_noise", "on": "base", "density": "1 (m/s²)²/Hz"}},
        "measures": {
            **{name: {"response": "rms_acceleration", "of": name} for name in "ac"},
            "hung": {"response": "rms_force", "through": "l3"},
        },
    })  # fmt: skip
    design = vo.solve(scene)
    assert design.status == "met", design.claim
    rows = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])

    def squared(w: float) -> Array:
        passed = springs + 1j * w * dampers
        moved = np.linalg.solve(rows.T @ (passed[:, None] * rows) - w**2 * np.diag(masses), [passed[0], 0.0, 0.0])
        return np.abs([moved[0], moved[2], passed[3] * (moved[2] - moved[1]) / w**2]) ** 2

    edges = np.concatenate([[0.0], np.geomspace(1e-4, 1e9, 2000)])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    omega = (0.5 * (edges[1:] + edges[:-1])[:, None] + 0.5 * np.diff(edges)[:, None] * nodes).ravel()
    total = (0.5 * np.diff(edges)[:, None] * weights).ravel() @ np.array([squared(w) for w in omega])
    for name, square in zip(("a", "c", "hung"), total / (2.0 * np.pi), strict=True):
        assert design.measures[name].value.value == pytest.approx(np.sqrt(square), rel=2e-5)
