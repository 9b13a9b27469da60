"""Vectors in space: the cross product without the bookkeeping that makes numpy's slow on single ones."""

from __future__ import annotations

from typing import Any

import numpy as np


def cross(a: Any, b: Any) -> Any:
    """a x b over the last axis, real or complex, shapes (..., 3) that go together."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    y = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    z = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.stack((x, y, z), axis=-1) if x.ndim else np.array((x, y, z))
