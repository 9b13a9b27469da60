"""What is refused, and the sentences with which it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from vibopt.errors import InputError


def refused(call: Callable[..., Any], *given: Any, **words: Any) -> InputError:
    """The error of a call that must be refused; its `messages` are the sentences."""
    with pytest.raises(InputError) as caught:
        call(*given, **words)
    return caught.value
