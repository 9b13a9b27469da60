"""Loads the unit registry before the first test, so that no property test pays for it."""

import pytest

from vibopt.units import read_quantity


@pytest.fixture(scope="session", autouse=True)
def loaded_registry() -> None:
    read_quantity("1 kg", "mass")
