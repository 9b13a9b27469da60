"""Natural frequencies outside the orders of an excitation: the bands are what the words say, and modes keep out."""

import numpy as np
import pytest

from refusals import refused
from vibopt.scene.read import from_text
from vibopt.solve import solve

SCENE = """
[bodies.box]
mass = "900 kg"
shape = { box = ["1.2 m", "0.8 m", "0.7 m"] }
centre = ["0.1 m", "0 m", "0.5 m"]
[mounts.foot]
between = ["box", "ground"]
at = [["0.5 m", "0.4 m", "0 m"], ["0.5 m", "-0.4 m", "0 m"], ["-0.5 m", "0.4 m", "0 m"], ["-0.5 m", "-0.4 m", "0 m"]]
stiffness = { from = "0.05 MN/m", to = "5 MN/m" }
shear_ratio = 0.6
loss_factor = 0.1
[excitations.engine]
kind = "force"
on = "box"
direction = "z"
amplitude = "1 kN"
speed = ["600 rpm", "1200..1500 rpm"]
[limits.orders]
response = "natural_frequency"
outside = { orders = [0.5, 1, 2], of = "engine", margin = "10 %" }
[goal]
maximise = "stiffness"
of = "foot"
"""


def modes(stiffness: float) -> np.ndarray:
    """Natural frequencies [Hz] of the box by its own matrices, from skew matrices."""
    sides = np.array([1.2, 0.8, 0.7]) ** 2
    mass = np.diag([900.0] * 3 + (75.0 * (sides.sum() - sides)).tolist())
    whole = np.zeros((6, 6))
    for x, y in ((0.5, 0.4), (0.5, -0.4), (-0.5, 0.4), (-0.5, -0.4)):
        a, b, c = np.array([x, y, 0.0]) - [0.1, 0.0, 0.5]
        reads = np.hstack([np.eye(3), np.array([[0.0, c, -b], [-c, 0.0, a], [b, -a, 0.0]])])
        whole += reads.T @ np.diag([0.6, 0.6, 1.0]) @ reads * stiffness
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, whole)).real)) / (2.0 * np.pi)


def test_the_stiffest_mount_keeps_all_modes_outside_the_orders() -> None:
    """Bands in Hz: 5 x 0.9..1.1 and 10 x 0.9..12.5 x 1.1 (order 0.5), and so on, joined where they meet."""
    design = solve(from_text(SCENE, name="orders.toml"))
    bands = [
        (n * low / 60.0 * 0.9, n * high / 60.0 * 1.1) for n in (0.5, 1, 2) for low, high in ((600, 600), (1200, 1500))
    ]

    def allowed(stiffness: float) -> bool:
        return not any(low * (1 + 1e-9) < f < high * (1 - 1e-9) for f in modes(stiffness) for low, high in bands)

    best = design.x[0]
    assert design.status == "optimal"
    assert allowed(best)
    assert not any(allowed(stiffness) for stiffness in np.geomspace(best * (1.0 + 1e-6), 5e6, 4000))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            '{ orders = [1], of = "engin", margin = "10 %" }',
            'orders.toml line 19: limits.orders.outside speaks of orders of "engin", which is no excitation with a '
            'speed. Did you mean "engine"?',
        ),
        (
            '{ orders = [1], of = "engine" }',
            'has no margin. Write outside = { orders = [0.5, 1, 2], of = "engine", margin = "20 %" }.',
        ),
        ('{ orders = [0], of = "engine", margin = "10 %" }', "has orders that are no numbers above zero. Write"),
        ('{ orders = [1], of = "engine", margin = "3 mm" }', "has a margin that is no ratio. Write"),
        ('{ orders = [1], of = "engine", margin = "100 %" }', "has a margin that is not between 0 and 100 %. Write"),
        ('{ orders = [1], on = "engine", margin = "1 %" }', 'has an unknown key "on". Write'),
    ],
)
def test_orders_that_say_nothing_are_refused(given: str, said: str) -> None:
    text = SCENE.lstrip().replace('{ orders = [0.5, 1, 2], of = "engine", margin = "10 %" }', given)
    assert said in str(refused(from_text, text, name="orders.toml"))


def test_a_mount_that_the_weights_lift_is_named() -> None:
    text = SCENE.replace('centre = ["0.1 m"', 'centre = ["0.7 m"').replace(
        "[goal]", '[measures.load]\nresponse = "static_load"\nof = "foot"\n[goal]'
    )
    notes = solve(from_text(text, name="orders.toml")).notes
    pull = 900.0 * 9.80665 / 4.0 * (0.7 / 0.5 - 1.0)
    assert any(
        one.startswith(f"mounts.foot.3 is lifted with {pull:.1f} N by the weights: it must be able to pull.")
        for one in notes
    ), notes
