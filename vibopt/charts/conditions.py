"""Under what a chart was measured: machine, cores, versions, day."""

from __future__ import annotations

import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from vibopt.errors import counted
from vibopt.records import dataclass

PACKAGES = ("vibopt", "numpy", "scipy", "cvxpy", "clarabel", "casadi", "highspy", "cma", "hsbalance", "pyyeti")
"""Whose versions matter to a chart; one that is not installed is left out."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a reader must know to compare with a chart of another day.

    processor
        Its name, or the kind of machine where the system does not tell.
    cores
        Those that this process may use.
    load
        Mean number of busy processes in the minute before, or -1 where the system does not tell.
    versions
        By package.
    date
        Day of the run (UTC), "2030-01-31".
    """

    processor: str
    cores: int
    load: float
    system: str
    python: str
    versions: dict[str, str]
    date: str

    @property
    def words(self) -> str:
        """In one line."""
        cores = counted(self.cores, "cores")
        busy = f", {self.load:.1f} processes busy before" if self.load >= 0.0 else ""
        packages = ", ".join(f"{name} {number}" for name, number in self.versions.items())
        return f"{self.processor}, {cores}{busy}; {self.system}, Python {self.python}; {packages}; {self.date}"


def conditions() -> Conditions:
    """Those of this process, now."""
    return Conditions(
        processor=_processor(),
        cores=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        load=os.getloadavg()[0] if hasattr(os, "getloadavg") else -1.0,
        system=platform.system(),
        python=platform.python_version(),
        versions=_versions(),
        date=datetime.now(UTC).strftime("%Y-%m-%d"),
    )


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, "") or platform.processor() or platform.machine()


def _versions() -> dict[str, str]:
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
