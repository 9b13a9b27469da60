"""The answer to a scene."""

from __future__ import annotations

from typing import TypeAlias

from vibopt.answer.answer import Answer
from vibopt.scene.scene import Scene

Design: TypeAlias = Answer[Scene]
"""Of a machine that is put together of bodies, links and absorbers."""
