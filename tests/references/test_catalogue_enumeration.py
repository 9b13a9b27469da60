"""The shipped catalogue problems against brute force: every combination, by formulas written out here."""

from __future__ import annotations

import csv
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from vibopt.scene.read import read, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve

MOUNTS = Path(__file__).parents[2] / "problems" / "mounts"
GRAVITY = 9.80665


def parts() -> list[dict[str, float | str]]:
    """The rows of the shipped catalogue in SI, read by other code."""
    with (MOUNTS / "mounts.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file, delimiter=";"))

    def number(row: dict[str, str], key: str) -> float:
        return float(row[key].replace(",", "."))

    return [
        {
            "name": row["part"],
            "least": number(row, "rated load min [N]"),
            "most": number(row, "rated load max [N]"),
            "k": 1e3 * number(row, "stiffness [N/mm]"),
            "static": 1e3 * number(row, "static stiffness [N/mm]"),
            "shear": 1e3 * number(row, "shear stiffness [N/mm]"),
            "loss": number(row, "loss factor"),
            "price": number(row, "price [EUR]"),
            "off": number(row, "tolerance [%]") / 100.0,
        }
        for row in rows
    ]


def numbers(rows: list[dict[str, float | str]], key: str) -> np.ndarray:
    """One column as an array."""
    return np.array([row[key] for row in rows], dtype=float)


def as_printed(name: str) -> Scene:
    """A problem with every part as its row says, without its tolerance."""
    scene = read(MOUNTS / name)
    groups = [f"links.{one}" for one in scene.links] + [f"mounts.{one}" for one in scene.mounts]
    return with_changes(scene, {f"{one}.tolerance": "0 %" for one in groups})


def test_the_catalogue_has_sixty_parts_and_says_that_they_are_made_up() -> None:
    text = (MOUNTS / "mounts.csv").read_text(encoding="utf-8-sig")
    assert len(parts()) == 60
    assert all(line.startswith("made up;") for line in text.splitlines()[1:])


def test_compressor_by_brute_force() -> None:
    """One mass m on n mounts: X = m_e e w^2 / |n k (1 + i eta) - m w^2|, force through = n k |1 + i eta| X."""
    rows, mass, unbalance, speed = parts(), 620.0, 0.09, 970.0 * np.pi / 30.0
    omega = np.linspace(1e-3, speed, 400_001)
    found = []
    for index, count in product(range(len(rows)), range(4, 9)):
        row = {key: float(value) for key, value in rows[index].items() if key != "name"}
        load = mass * GRAVITY / count
        stiff = count * row["k"] * (1.0 + 1j * row["loss"])
        if not row["least"] <= load <= row["most"] or load / row["static"] > 8e-3:
            continue
        force = abs(stiff) * unbalance * speed**2 / abs(stiff - mass * speed**2)
        if force > 300.0:
            continue
        moved = (unbalance * omega**2 / np.abs(stiff - mass * omega**2)).max()
        assert abs(moved / 1.2e-3 - 1.0) > 1e-6, "too near the limit for a grid to tell"
        if moved < 1.2e-3:
            found.append((round(count * row["price"], 9), str(rows[index]["name"]), count))
    design = solve(as_printed("compressor_on_bought_mounts.toml"))
    picks = design.details["picks"]
    assert [(round(one["goal"], 9), one["parts"]["links.feet.part"]) for one in picks] == [
        (price, name) for price, name, _ in sorted(found)[:10]
    ]
    assert design.status == "optimal"


def test_chiller_by_brute_force() -> None:
    """Two masses in a row, 7200 combinations, each solved directly at the one speed of the goal."""
    rows, speed, upper_mass, frame = parts(), 1450.0 * np.pi / 30.0, 900.0, 1400.0
    k, loss, price = numbers(rows, "k"), numbers(rows, "loss"), numbers(rows, "price")
    least, most = numbers(rows, "least"), numbers(rows, "most")
    omega = np.linspace(0.01, 1.0, 2000) * speed
    first = [i for i in range(60) if least[i] <= upper_mass * GRAVITY / 4 <= most[i]]
    found = []
    for i, j, count in product(first, range(60), (4, 6)):
        load = (upper_mass + frame) * GRAVITY / count
        cost = 4 * price[i] + count * price[j]
        if not least[j] <= load <= most[j] or cost > 450.0:
            continue
        upper, lower = 4 * k[i] * (1 + 1j * loss[i]), count * k[j] * (1 + 1j * loss[j])
        modes = np.linalg.eigvals(
            np.array([[4 * k[i], -4 * k[i]], [-4 * k[i], 4 * k[i] + count * k[j]]]) / np.array([[upper_mass], [frame]])
        )
        if np.sqrt(modes.min()) < 3.0 * 2.0 * np.pi:
            continue
        determinant = (upper - upper_mass * omega**2) * (upper + lower - frame * omega**2) - upper**2
        top = 0.08 * omega**2 * np.abs((upper + lower - frame * omega**2) / determinant)
        force = 0.08 * omega[-1] ** 2 * abs(upper * lower / determinant[-1])
        assert abs(top.max() / 1.5e-3 - 1.0) > 1e-3
        if top.max() < 1.5e-3:
            found.append((force, rows[i]["name"], rows[j]["name"]))
    best = sorted(found)[:10]
    picks = solve(as_printed("chiller_on_two_stages.toml"), explain=False).details["picks"]
    assert [one["goal"] for one in picks] == pytest.approx([one[0] for one in best], rel=1e-12)
    names = [(one["parts"]["links.upper.part"], one["parts"]["links.lower.part"]) for one in picks]
    assert names == [(one[1], one[2]) for one in best]


def test_generator_set_by_brute_force() -> None:
    """Six coordinates at the centre of mass, matrices from skew matrices; 3600 combinations."""
    rows, omega = parts(), 1500.0 * np.pi / 30.0
    mass = np.diag([1850.0, 1850.0, 1850.0, 310.0, 620.0, 590.0])
    arms = np.array([[0.9, 0.4, 0.0], [0.9, -0.4, 0.0], [-0.8, 0.4, 0.0], [-0.8, -0.4, 0.0]]) - [0.1, 0.0, 0.45]
    reads = []
    for x, y, z in arms:
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        reads.append(np.hstack([np.eye(3), turned]))
    push = np.zeros(6)
    push[2] = 2000.0
    price, shear, axial, static, loss = (numbers(rows, key) for key in ("price", "shear", "k", "static", "loss"))
    least, most = numbers(rows, "least"), numbers(rows, "most")
    found = []
    for i, j in product(range(60), range(60)):
        single = [i, i, j, j]
        down = np.array([0.0, 0.0, 1850.0 * GRAVITY, 0.0, 0.0, 0.0])
        ratio = static / axial
        lower = sum(
            r.T @ np.diag(np.array([shear[p], shear[p], axial[p]]) * ratio[p]) @ r
            for r, p in zip(reads, single, strict=True)
        )
        sag = np.linalg.solve(lower, down)
        loads = np.array([static[p] * (r @ sag)[2] for r, p in zip(reads, single, strict=True)])
        if (loads < least[single]).any() or (loads > most[single]).any():
            continue
        stiff = [np.diag([shear[p], shear[p], axial[p]]) for p in single]
        whole = sum(r.T @ k @ r for r, k in zip(reads, stiff, strict=True))
        modes = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, whole)).real)
        complex_whole = sum((1 + 1j * loss[p]) * r.T @ k @ r for r, k, p in zip(reads, stiff, single, strict=True))
        u = np.linalg.solve(complex_whole - omega**2 * mass, push)
        force = abs(sum(((1 + 1j * loss[p]) * k @ r @ u)[2] for r, k, p in zip(reads, stiff, single, strict=True)))
        if modes.max() <= 18.0 * 2.0 * np.pi and force <= 330.0:
            found.append((2 * (price[i] + price[j]), rows[i]["name"], rows[j]["name"]))
    picks = solve(as_printed("genset_front_and_rear.toml"), explain=False).details["picks"]
    best = sorted(found)[:10]
    assert [one["goal"] for one in picks] == pytest.approx([one[0] for one in best], rel=1e-12)
    names = [(one["parts"]["mounts.front.part"], one["parts"]["mounts.rear.part"]) for one in picks]
    assert sorted(names[:5]) == sorted((one[1], one[2]) for one in best[:5])


def test_compressor_over_the_tolerances_by_brute_force() -> None:
    """As printed, but with the stiffness of all mounts anywhere within what the row says."""
    rows, mass, unbalance, speed = parts(), 620.0, 0.09, 970.0 * np.pi / 30.0
    omega = np.linspace(1e-3, speed, 20_001)
    found = []
    for index, count in product(range(len(rows)), range(4, 9)):
        row = {key: float(value) for key, value in rows[index].items() if key != "name"}
        load = mass * GRAVITY / count
        if not row["least"] <= load <= row["most"] or load / row["static"] / (1.0 - row["off"]) > 8e-3:
            continue
        force = moved = 0.0
        for part in np.linspace(-1.0, 1.0, 41):
            stiff = count * row["k"] * (1.0 + part * row["off"]) * (1.0 + 1j * row["loss"])
            force = max(force, abs(stiff) * unbalance * speed**2 / abs(stiff - mass * speed**2))
            moved = max(moved, float((unbalance * omega**2 / np.abs(stiff - mass * omega**2)).max()))
        assert min(abs(moved / 1.2e-3 - 1.0), abs(force / 300.0 - 1.0)) > 1e-5, "too near the limit for a grid to tell"
        if moved < 1.2e-3 and force < 300.0:
            found.append((round(count * row["price"], 9), str(rows[index]["name"]), count))
    design = solve(read(MOUNTS / "compressor_on_bought_mounts.toml"))
    picks = design.details["picks"]
    assert [(round(one["goal"], 9), one["parts"]["links.feet.part"]) for one in picks] == [
        (price, name) for price, name, _ in sorted(found)[:10]
    ]
    assert design.status == "optimal"


def test_generator_set_over_the_tolerances_by_brute_force() -> None:
    """3600 combinations, each with both kinds of mounts off by their tolerances on a grid of 5 x 5."""
    rows, omega = parts(), 1500.0 * np.pi / 30.0
    mass = np.diag([1850.0, 1850.0, 1850.0, 310.0, 620.0, 590.0])
    arms = np.array([[0.9, 0.4, 0.0], [0.9, -0.4, 0.0], [-0.8, 0.4, 0.0], [-0.8, -0.4, 0.0]]) - [0.1, 0.0, 0.45]
    turned = [np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]) for x, y, z in arms]
    reads = np.array([np.hstack([np.eye(3), one]) for one in turned])
    push = np.array([0.0, 0.0, 2000.0, 0.0, 0.0, 0.0])
    price, shear, axial, static, loss, off = (
        numbers(rows, key) for key in ("price", "shear", "k", "static", "loss", "off")
    )
    least, most = numbers(rows, "least"), numbers(rows, "most")
    springs = np.array([np.diag([s, s, a]) for s, a in zip(shear, axial, strict=True)])
    front, rear = (
        np.array([reads[a].T @ k @ reads[a] + reads[b].T @ k @ reads[b] for k in springs]) for a, b in ((0, 1), (2, 3))
    )
    grid = np.array(list(product(np.linspace(-1.0, 1.0, 5), repeat=2)))
    down = np.array([0.0, 0.0, 1850.0 * GRAVITY, 0.0, 0.0, 0.0])
    found = []
    for i, j in product(range(60), range(60)):
        one, two = (1.0 + grid[:, k, None, None] * off[p] for k, p in ((0, i), (1, j)))
        soft = one * front[i] * static[i] / axial[i] + two * rear[j] * static[j] / axial[j]
        sag = np.linalg.solve(soft, np.broadcast_to(down[:, None], (25, 6, 1)))[..., 0]
        loads = np.array(
            [
                static[p] * scale[:, 0, 0] * (sag @ r[2])
                for r, p, scale in zip(reads, (i, i, j, j), (one, one, two, two), strict=True)
            ]
        )
        kinds = [i, i, j, j]
        if (loads < least[kinds][:, None]).any() or (loads > most[kinds][:, None]).any():
            continue
        whole = one * front[i] + two * rear[j]
        modes = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, whole)).real.max())
        lossy = one * front[i] * (1 + 1j * loss[i]) + two * rear[j] * (1 + 1j * loss[j])
        u = np.linalg.solve(lossy - omega**2 * mass, np.broadcast_to(push[:, None], (25, 6, 1)))
        force = np.abs((lossy[:, 2:3] @ u)[:, 0, 0]).max()
        assert abs(force / 330.0 - 1.0) > 1e-4
        if modes <= 18.0 * 2.0 * np.pi and force <= 330.0:
            found.append((2 * (price[i] + price[j]), rows[i]["name"], rows[j]["name"]))
    design = solve(read(MOUNTS / "genset_front_and_rear.toml"), explain=False)
    best = sorted(found)[:10]
    assert [one["goal"] for one in design.details["picks"]] == pytest.approx([one[0] for one in best], rel=1e-12)
    assert design.status == "optimal"


def test_chiller_over_the_tolerances_by_brute_force() -> None:
    """7200 combinations, each with both kinds of mounts off on a grid; the worst lies at a corner of it."""
    rows, speed, m1, m2 = parts(), 1450.0 * np.pi / 30.0, 900.0, 1400.0
    k, loss, price, off = (numbers(rows, key) for key in ("k", "loss", "price", "off"))
    least, most = numbers(rows, "least"), numbers(rows, "most")
    omega = np.linspace(0.01, 1.0, 400) * speed
    grid = np.array(list(product(np.linspace(-1.0, 1.0, 5), repeat=2)))
    found = []
    for i, j, count in product(range(60), range(60), (4, 6)):
        if not least[i] <= m1 * GRAVITY / 4 <= most[i] or not least[j] <= (m1 + m2) * GRAVITY / count <= most[j]:
            continue
        one, two = 4 * k[i] * (1.0 + grid[:, :1] * off[i]), count * k[j] * (1.0 + grid[:, 1:] * off[j])
        upper, lower = one * (1 + 1j * loss[i]), two * (1 + 1j * loss[j])
        squares = 0.5 * (
            (one / m1 + (one + two) / m2) - np.sqrt((one / m1 + (one + two) / m2) ** 2 - 4 * one * two / m1 / m2)
        )
        if 4 * price[i] + count * price[j] > 450.0 or np.sqrt(squares.min()) < 3.0 * 2.0 * np.pi:
            continue
        determinant = (upper - m1 * omega**2) * (upper + lower - m2 * omega**2) - upper**2
        top = (0.08 * omega**2 * np.abs((upper + lower - m2 * omega**2) / determinant)).max()
        force = (0.08 * omega[-1] ** 2 * np.abs(upper * lower / determinant)[:, -1]).max()
        assert abs(top / 1.5e-3 - 1.0) > 1e-3
        if top < 1.5e-3:
            found.append((force, rows[i]["name"], rows[j]["name"]))
    best = sorted(found)[:10]
    picks = solve(read(MOUNTS / "chiller_on_two_stages.toml"), explain=False).details["picks"]
    assert [one["goal"] for one in picks] == pytest.approx([one[0] for one in best], rel=1e-9)
    assert [(one["parts"]["links.upper.part"], one["parts"]["links.lower.part"]) for one in picks] == [
        (one[1], one[2]) for one in best
    ]


def six_springs(at: np.ndarray, stiff: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Stiffness about a centre of mass (n, 6, 6) of mounts at places (m, 3), stiffness (m, 3), for centres (n, 3)."""
    whole = np.zeros((len(centre), 6, 6))
    for place, k in zip(at, stiff, strict=True):
        x, y, z = (place - centre).T
        o = np.zeros_like(x)
        turned = np.array([[o, z, -y], [-z, o, x], [y, -x, o]]).transpose(2, 0, 1)
        read = np.concatenate([np.broadcast_to(np.eye(3), turned.shape), turned], axis=2)
        whole += read.transpose(0, 2, 1) @ (k[:, None] * read)
    return whole


@pytest.mark.slow
def test_generator_set_on_six_over_the_tolerances_by_brute_force() -> None:
    """3600 combinations, each on 81 machines: mass, centre and both rubbers off; cheapest first until ten will do."""
    rows, base = parts(), np.array([[x, y, 0.0] for x in (1.2, -1.2) for y in (0.45, -0.45)])
    columns = ("price", "shear", "k", "static", "loss", "off", "least", "most")
    price, shear, axial, static, loss, off, least, most = (numbers(rows, key) for key in columns)
    middle = np.array([[0.3, y, 0.0] for y in (0.45, -0.45)])
    grid = np.array(list(product((-1.0, 0.0, 1.0), repeat=4)))
    mass = 2400.0 * (1.0 + 0.03 * grid[:, 0])
    centre = np.array([0.25, 0.0, 0.6]) + np.outer(grid[:, 1], [0.02, 0.0, 0.0])
    inertia = np.zeros((81, 6, 6))
    for k, own in enumerate((470.0, 1430.0, 1350.0)):
        inertia[:, k, k], inertia[:, 3 + k, 3 + k] = mass, own
    each = np.array([shear, shear, axial]).T
    soft = each * (static / axial)[:, None]
    own_corner, own_middle = (
        [six_springs(at, np.broadcast_to(each[i], (len(at), 3)), centre) for i in range(60)] for at in (base, middle)
    )
    own = np.linspace(1450.0, 1560.0, 12) * np.pi / 30.0
    run_up = np.linspace(0.005, 1.0, 500) * 1560.0 * np.pi / 30.0
    found: list[tuple[float, str, str]] = []
    for cost, i, j in sorted((4 * price[i] + 2 * price[j], i, j) for i in range(60) for j in range(60)):
        if len(found) == 3:
            break
        one, two = 1.0 + grid[:, 2, None, None] * off[i], 1.0 + grid[:, 3, None, None] * off[j]
        k1, k2 = own_corner[i] * one, own_middle[j] * two
        still = k1 * (static[i] / axial[i]) + k2 * (static[j] / axial[j])
        weight = np.zeros((81, 6, 1))
        weight[:, 2, 0] = mass * GRAVITY
        down = np.linalg.solve(still, weight)[..., 0]
        if not _carried(base, soft[i, 2] * one, down, centre, least[i], most[i]):
            continue
        if not _carried(middle, soft[j, 2] * two, down, centre, least[j], most[j]):
            continue
        modes = np.sqrt(np.linalg.eigvals(np.linalg.solve(inertia, k1 + k2)).real) / (2.0 * np.pi)
        if ((modes > 1450 / 60 * 0.75) & (modes < 1560 / 60 * 1.25)).any():
            continue
        lossy = k1 * (1 + 1j * loss[i]) + k2 * (1 + 1j * loss[j])
        arm = np.array([0.4, 0.0, 0.5]) - centre
        push = np.zeros((81, 6, 1))
        push[:, 2, 0] = 900.0
        push[:, 3, 0], push[:, 4, 0] = 900.0 * arm[:, 1], -900.0 * arm[:, 0]
        force = max(
            np.abs((lossy[:, 2:3] @ np.linalg.solve(lossy - w * w * inertia, push))[:, 0, 0]).max() * (w / own[-1]) ** 2
            for w in own
        )
        if force > 260.0:
            continue
        turn = np.zeros((81, 6, 1))
        turn[:, 3, 0] = 600.0
        eye = np.array([1.4, 0.35, 1.3]) - centre
        moved = 0.0
        for w in 1.5 * run_up:
            u = np.linalg.solve(lossy - w * w * inertia, turn)[..., 0]
            moved = max(moved, np.abs(u[:, 1] - u[:, 3] * eye[:, 2] + u[:, 5] * eye[:, 0]).max())
        assert min(abs(force / 260.0 - 1.0), abs(moved / 2.5e-3 - 1.0)) > 1e-3, "too near the limit for a grid to tell"
        if moved <= 2.5e-3:
            found.append((round(cost, 9), str(rows[i]["name"]), str(rows[j]["name"])))
    design = solve(read(MOUNTS / "generator_set_on_six.toml"), explain=False)
    picks = design.details["picks"][:3]
    assert [(round(one["goal"], 9), *one["parts"].values()) for one in picks] == found
    assert design.status == "optimal"


def _carried(
    at: np.ndarray, stiff: np.ndarray, down: np.ndarray, centre: np.ndarray, least: float, most: float
) -> bool:
    """Whether every mount of a group is loaded between its ratings on every machine."""
    arms = at[:, None] - centre
    loads = stiff[:, 0, 0] * (down[:, 2] + down[:, 3] * arms[..., 1] - down[:, 4] * arms[..., 0])
    return bool((loads >= least).all() and (loads <= most).all())
