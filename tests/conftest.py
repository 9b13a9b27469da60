"""One thread of linear algebra per process, as the tests run side by side; the same drawn examples every time.

A law tries a part of its examples by default and all of them with `-m slow`, which takes the laws in as well.
"""

import gc
import os
from collections import Counter

import pytest
from hypothesis import HealthCheck, is_hypothesis_test, settings
from hypothesis.internal.conjecture import providers

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ["VIBOPT_CACHE"] = "off"  # each answer of a test is its own
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that tests start would compile all of vibopt, one by one

settings.register_profile(
    "same", derandomize=True, database=None, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("same")

# Numbers that stand in the modules imported so far are drawn, too: what is drawn would follow the order of the tests.
vars(providers)["_get_local_constants"] = lambda: vars(providers)["_local_constants"]

LONGEST = ("test_tool_finds_nothing[mypy]", "test_reproducible.py")
"""Each takes long: at the end the other worker would wait for it, or find anew what many tests of a file share."""
PART, LEAST = 8, 2
"""By default one example of so many is tried, and no fewer than the second."""
_SETTINGS = "_hypothesis_internal_use_settings"
"""Where a test keeps its settings; without it every law tries all of its examples."""


def _sample(items: list[pytest.Item]) -> None:
    """Of cases marked `sampled(n)` every n-th is tried by default, from the first on, and the others are slow."""
    seen: Counter[str] = Counter()
    for item in items:
        if mark := item.get_closest_marker("sampled"):
            name = item.nodeid.partition("[")[0]
            if seen[name] % mark.args[0]:
                item.add_marker(pytest.mark.slow)
            seen[name] += 1


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Fewer examples, or with `-m slow` every law with all of them; the longest begin first."""
    items.sort(key=lambda item: not item.nodeid.endswith(LONGEST[0]) and LONGEST[1] not in item.nodeid)
    _sample(items)
    slow = config.getoption("markexpr") == "slow"
    seen = set()
    for item in items:
        law = getattr(item, "obj", None)
        law = getattr(law, "__func__", law)
        if not is_hypothesis_test(law):
            continue
        if slow:
            item.add_marker(pytest.mark.slow)
        elif id(law) not in seen and item.get_closest_marker("slow") is None:
            seen.add(id(law))
            own = getattr(law, _SETTINGS, None) or settings.default
            fewer = min(own.max_examples, max(own.max_examples // PART, LEAST))
            setattr(law, _SETTINGS, settings(own, max_examples=fewer))


def pytest_collection_finish() -> None:
    """What was imported and collected stays, and is not looked through for circles again and again."""
    gc.collect()
    gc.freeze()
