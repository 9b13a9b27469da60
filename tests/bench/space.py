"""Six coordinates: the exact worst over a range of speeds against 2000 speeds solved in one batch by numpy.

Every call gets a design that it has not seen, so that nothing is remembered.
Run: python tests/bench/space.py
"""

import sys
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "laws"))

from timing import timed

from space_machine import Array, Plant
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse, singularities
from vibopt.forms.greatest_values import highest
from vibopt.mechanics.peaks import greatest
from vibopt.program.pose import on_needed
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict

COUNT = 30
SPEEDS = 2000
LOW, HIGH = 1.0, 400.0
KINDS = ("viscous", "light", "rubber")


class Machine(Plant):
    """A random machine with one kind of damping, and one stiffness of one mount to be chosen."""

    def __init__(self, seed: int, kind: str) -> None:
        super().__init__(seed)
        self.kind = kind
        if kind == "light":
            self.c = self.k * 1e-4 * 2.0 / 50.0

    def document(self) -> dict[str, Any]:
        """The same as a problem file, with a goal for form's sake."""
        made = super().document()
        made["mounts"]["m0"]["stiffness"][0] = {"from": "1 N/m", "to": "1 GN/m"}
        made["goal"] = {"minimise": "total_mass"}
        if self.kind == "rubber":
            for mount in made["mounts"].values():
                mount["loss_factor"] = 0.1
                del mount["damping"]
        return made

    def response(self, omega: Array) -> Array:
        """Modulus of the displacement at the point per newton; rubber has a complex stiffness."""
        if self.kind != "rubber":
            return super().response(omega)
        mass, _, stiffness = self.matrices()
        whole = stiffness * (1.0 + 0.1j) - omega[:, None, None] ** 2 * mass
        load = self.reads(self.force_at, self.push)
        moved = np.linalg.solve(whole, np.broadcast_to(load[:, None], (len(omega), 6, 1)).astype(complex))[..., 0]
        return np.asarray(np.abs(moved @ self.reads(self.point, self.way)))


def measured(machine: Machine) -> tuple[float, ...]:
    """Times of the batch, of the exact worst and of the general search; errors of the worst and of the samples."""
    omega = np.linspace(LOW, HIGH, SPEEDS)
    words = {"response": "displacement", "of": "eye", "direction": machine.way.tolist(), "over": "1..400 rad/s"}
    scene = from_dict({**machine.document(), "measures": {"worst": words}})
    model, form = on_needed(scene, model_of(scene), scene.measures["worst"])
    assert isinstance(form, Modulus)
    drive = form.drives[0]
    fresh = count()

    def another() -> Array:
        return np.array([float(machine.k[0, 0]) * (1.0 + 1e-12 * next(fresh))])

    def general() -> object:
        x = another()
        return greatest(DriveResponse(model, form, drive, x), drive.bands, *singularities(model, form, drive, x))

    x = np.array([float(machine.k[0, 0])])
    found = form.worst(model, x)
    assert highest(model, form, drive, x, 1.0) is not None
    samples = machine.response(omega)
    true = max(found.value, around(machine, float(omega[samples.argmax()])))
    here = machine.response(np.array([found.speeds["shaker"]]))[0]
    error = max(true / found.value - 1.0, abs(here / found.value - 1.0))
    times = (
        timed(lambda: machine.response(omega), 8)[0],
        timed(lambda: form.worst(model, another()), 100)[0],
        timed(general, 4)[0],
    )
    return (*times, error, 1.0 - float(samples.max()) / true)


def around(machine: Machine, speed: float) -> float:
    """The greatest of very many samples near one, and of many again near the highest of those."""
    for reach in (0.25, 1e-4):
        near = np.clip(speed + np.linspace(-reach, reach, 20_001), LOW, HIGH)
        values = machine.response(near)
        speed = float(near[values.argmax()])
    return float(values.max())


def main() -> None:
    """Print the ratio of times, and both errors against a search around every sample."""
    print(f"{COUNT} machines of six coordinates, {SPEEDS} speeds in one batch against the exact worst")
    for kind in KINDS:
        rows = [measured(Machine(seed, kind)) for seed in range(COUNT)]
        batch, exact, general, error, missed = np.array(rows).T
        print(
            f"{kind:8} batch {1e3 * np.median(batch):.2f} ms, exact {1e3 * np.median(exact):.3f} ms, "
            f"ratio {np.median(batch / exact):.1f} ({(batch / exact).min():.1f} to {(batch / exact).max():.1f}); "
            f"by the general search {1e3 * np.median(general):.2f} ms"
        )
        print(f"{'':8} error of the exact worst {error.max():.1e}, of the samples {missed.max():.1e}")


if __name__ == "__main__":
    main()
