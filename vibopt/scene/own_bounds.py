"""Bounds that a mount brings itself: its rating for a static load, its gap for its travel."""

from __future__ import annotations

from collections.abc import Mapping

from vibopt.devices import MountTable
from vibopt.responses import Response
from vibopt.units import Quantity


def with_own_bounds(limits: Mapping[str, Response], mounts: Mapping[str, MountTable]) -> dict[str, Response]:
    """The limits, those without a bound on the load or the travel of a mount with its rating or its gap."""
    return {name: _bounded(one, mounts) for name, one in limits.items()}


def _bounded(limit: Response, mounts: Mapping[str, MountTable]) -> Response:
    if limit.at_most is not None or limit.at_least is not None:
        return limit
    name = getattr(limit, "of", None)
    mount = next((one for group, one in mounts.items() if name == group or name in one.singles(group)), None)
    if mount is None:
        return limit
    if limit.response == "static_load" and mount.rating is not None:
        return limit.model_copy(update={"at_least": mount.rating.least, "at_most": mount.rating.most})
    if limit.response == "travel" and mount.gap is not None:
        return limit.model_copy(update={"at_most": Quantity(mount.gap.value, mount.gap.unit)})
    return limit
