"""Six coordinates: the exact worst over a range of speeds against 2000 speeds solved in one batch by numpy.

Run: python tests/bench/space.py
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "laws"))

from space_machine import Array, Plant
from vibopt.program.pose import on_needed
from vibopt.program.worst import worst
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict

COUNT = 30
SPEEDS = 2000
LOW, HIGH = 1.0, 400.0


def best(call: Callable[[], object], repeats: int = 5) -> float:
    """Least time of some calls [s]."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return min(times)


def sampled(plant: Plant, omega: Array) -> float:
    """The greatest of all samples, assembled and solved in one batch."""
    return float(plant.response(omega).max())


def main() -> None:
    """Print the ratio of times, and both errors against a search around every sample."""
    rows = []
    omega = np.linspace(LOW, HIGH, SPEEDS)
    for seed in range(COUNT):
        plant = Plant(seed)
        words = {"response": "displacement", "of": "eye", "direction": plant.way.tolist(), "over": "1..400 rad/s"}
        scene = from_dict({**plant.document(), "measures": {"worst": words}})
        model, form = on_needed(scene, model_of(scene), scene.measures["worst"])
        x = np.zeros(0)
        found = worst(model, form, x)
        around = omega[np.argmax(plant.response(omega))] + np.linspace(-0.25, 0.25, 20_001)
        true = max(found.value, float(plant.response(around[(around >= LOW) & (around <= HIGH)]).max()))
        here = plant.response(np.array([found.speeds["shaker"]]))[0]
        error = max(true / found.value - 1.0, abs(here / found.value - 1.0))
        times = best(partial(sampled, plant, omega)), best(partial(worst, model, form, x))
        rows.append((*times, error, 1.0 - sampled(plant, omega) / true))
    batch, exact, error, missed = np.array(rows).T
    print(f"{COUNT} machines of six coordinates, {SPEEDS} speeds in one batch against the exact worst")
    ratio = np.median(batch / exact)
    print(f"batch {1e3 * np.median(batch):.2f} ms, exact {1e3 * np.median(exact):.2f} ms, ratio {ratio:.1f}")
    print(f"error of the exact worst {error.max():.1e}, of the samples {missed.max():.1e}")


if __name__ == "__main__":
    main()
