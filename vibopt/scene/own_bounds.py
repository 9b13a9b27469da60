"""Bounds that come from elsewhere in the file: a mount's rating and gap, the orders of an excitation's speeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from vibopt.excitations import Excitation
from vibopt.responses import Response
from vibopt.units import Quantity

if TYPE_CHECKING:
    from vibopt.devices.mount import MountTable


def with_own_bounds(
    limits: Mapping[str, Response], mounts: Mapping[str, MountTable], excitations: Mapping[str, Excitation]
) -> dict[str, Response]:
    """The limits: without a bound on the load or the travel of a mount its rating or its gap; orders as bands."""
    return {name: _bounded(_banded(one, excitations), mounts) for name, one in limits.items()}


def _banded(limit: Response, excitations: Mapping[str, Excitation]) -> Response:
    """Orders stay where the excitation that they name is none, or has no speed."""
    shaker = excitations.get(limit.orders_of)
    return limit if shaker is None or shaker.random else limit.at_orders(shaker.own_bands())


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
