"""Whether steady vibration, noise and what comes once are each asked what they have an answer to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.devices import Device
from vibopt.document.mistakes import Mistakes, Path, dotted, given_at
from vibopt.mechanics.builder import GROUND, MOST_WHOLE
from vibopt.responses import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.scene import places
from vibopt.scene.check_speeds import reached, whole
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene

if TYPE_CHECKING:
    from vibopt.excitations.excitation import Once


def check_random(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> bool:
    """Add what is wrong between a response and the noises of the scene; whether the rest is worth checking."""
    if not isinstance(response, (HarmonicResponse, RandomResponse, TransientResponse)):
        return True
    if not _known(scene, path, response, mistakes, broken):
        return isinstance(response, HarmonicResponse)
    asked = response.due_to or (() if names_for(scene, response) else tuple(scene.excitations))
    wrong = [name for name in asked if not response.counts(scene.excitations[name].sorts)]
    if wrong and (response.due_to or len(wrong) == len(scene.excitations)):
        _misfit(scene, path, response, wrong[0], mistakes)
        return False
    if isinstance(response, RandomResponse):
        _infinite(scene, path, response, mistakes, broken)
    elif isinstance(response, TransientResponse):
        _in_time(scene, path, response, mistakes, broken)
    return True


def wrong_density(scene: Scene, name: str, mistakes: Mistakes) -> bool:
    """Whether a white noise has a density of force on a base, or one of acceleration on a body; adds the mistake."""
    noise = scene.excitations[name]
    if noise.sort != "random":
        return False
    force, what = noise.family == "bodies", "displacement" if noise.displaced else "acceleration"
    if noise.on not in (places.supports(scene) if force else places.moving(scene)):
        return False
    given = given_at(scene.document, ("excitations", name, "density"))
    text = (
        f'is a density of force, but {noise.on} is a base. Write one of acceleration, for example "0.01 (m/s²)²/Hz", '
        'or of displacement, "0.01 mm²/Hz".'
        if force
        else f'is a density of {what}, but {noise.on} is no base. Write one of force, for example "100 N²/Hz".'
    )
    mistakes.value(("excitations", name, "density"), given, text)
    return True


def _known(
    scene: Scene,
    path: Path,
    response: HarmonicResponse | RandomResponse | TransientResponse,
    mistakes: Mistakes,
    broken: set[str],
) -> bool:
    """Whether there are excitations, and those of `due_to` among them; a steady response says so itself."""
    hurt = any(one.startswith("excitations.") for one in broken)
    if response.sort != "steady" and response.due_to == ():
        mistakes.add((*path, "due_to"), f"{dotted(path)}.due_to is an empty list. Name an excitation, or leave it out.")
    elif response.sort != "steady" and not scene.excitations and not hurt:
        what, kind = _ASKED[response.sort]
        mistakes.add(
            path,
            f"{dotted(path)} is a response to {what}, but nothing shakes the machine. Add [excitations.NAME] "
            f'with kind = "{kind}".',
        )
    unknown = [name for name in response.due_to or () if name not in scene.excitations]
    if response.sort != "steady" and unknown and not hurt:
        mistakes.unknown_name((*path, "due_to"), unknown[0], "excitation", list(scene.excitations))
    return bool(scene.excitations) and response.due_to != () and not unknown and not hurt


def _misfit(
    scene: Scene,
    path: Path,
    response: HarmonicResponse | RandomResponse | TransientResponse,
    name: str,
    mistakes: Mistakes,
) -> None:
    """A response of one sort of vibration that is asked of an excitation of another."""
    sort = scene.excitations[name].sort
    key, whose = response.response, f"excitations.{name} {_IS[sort]}"
    steady = response if isinstance(response, HarmonicResponse) else response.steady
    twin = {"steady": steady.response, "random": steady.noise_twin, "transient": steady.transient_twin}[sort]
    other = _NAMED[response.sort]
    way = (
        f'Write response = "{twin}"{f", or name {other}" if response.sort != "steady" else ""}'
        if twin
        else (f"Name {other}")
    )
    there = "" if response.sort == "steady" and twin else " in due_to"
    mistakes.add(path, f"{dotted(path)}: {key} is {_OF[response.sort]}, but {whose}. {way}{there}.")


_ASKED = {"random": ("white noise", "white_noise"), "transient": ("what comes once", "pulse")}
_OF = {
    "steady": "of a steady vibration",
    "random": "a root mean square under white noise",
    "transient": "the greatest in time of what comes once",
}
_IS = {
    "steady": "is a steady vibration",
    "random": "is white noise, which has no amplitude",
    "transient": "comes once and is over",
}
_NAMED = {
    "steady": "a steady excitation",
    "random": "a white noise",
    "transient": "a pulse, a drop, a record or a run-up",
}


def _in_time(scene: Scene, path: Path, response: TransientResponse, mistakes: Mistakes, broken: set[str]) -> None:
    """What has no answer in time: loss factors, what turns, structures; and what no pulse reaches."""
    check_lossy(scene, path, "greatest in time", mistakes)
    names = names_for(scene, response)
    if _many_coordinates(scene, path, mistakes) or _joint_pushed(scene, path, response, names, mistakes):
        return
    if not whole(scene, broken) or not _acting(scene, names):
        return
    turning = _turns(scene, response)
    if turning:
        mistakes.add(path, f"{dotted(path)} {turning}")
        return
    from vibopt.scene.check_run_up import contradicts

    together = response.combine is None
    if not reached(scene, path, response, names, mistakes) or contradicts(
        scene, path, names, mistakes, together=together
    ):
        return
    faults = (_from_standstill, *(() if response.combine else (_no_peak_together,)), _blow_handed_on, _moves_on)
    for fault in faults:
        said = fault(scene, response, names)
        if said:
            mistakes.add(path, f"{dotted(path)} {said}")
            return


def _turns(scene: Scene, response: TransientResponse) -> str:
    """Looks at what turns."""
    place, ends = _place(response), places.ends(scene)
    near = {place, *ends.get(place, ())} & set(places.turning(scene))
    if not near:
        return ""
    return f"looks at {min(near)}, which turns. What comes once is answered for bodies on a line only, so far."


def _place(response: TransientResponse) -> str:
    return next((name for name, _ in response.places().values()), "")


def _from_standstill(scene: Scene, response: TransientResponse, names: Sequence[str]) -> str:
    """Adds a steady vibration whose speeds begin at zero."""
    for name in names:
        excitation = scene.excitations[name]
        if response.sort not in excitation.sorts and any(band.low == 0.0 for band in excitation.own_bands()):
            return (
                f"adds the steady vibration of excitations.{name}, whose own speeds begin at standstill. Write those "
                "at which it runs."
            )
    return ""


def _once(scene: Scene, names: Sequence[str]) -> dict[str, Once]:
    return {name: one for name in names if (one := scene.excitations[name].once) is not None}


def _no_peak_together(scene: Scene, response: TransientResponse, names: Sequence[str]) -> str:
    """Counts together what is answered alone: durations that nobody knows, steps, and vibrations that last."""
    once = _once(scene, names)
    unknown = [f"excitations.{name}" for name, one in once.items() if one.durations is not None]
    held = [f"excitations.{name}" for name, one in once.items() if one.holds]
    lasting = [f"excitations.{name}" for name, one in once.items() if one.endless and not one.holds]
    way = "Name one"
    if len(unknown) > 1:
        what = f"{len(unknown)} pulses of unknown duration, {unknown[0]} and {unknown[1]}"
    elif unknown and held + lasting:
        what = f"a pulse of unknown duration, {unknown[0]}, beside {(held + lasting)[0]}, which goes on for ever"
        way = "Write its duration, name one"
    elif held and lasting:
        what = f"a step, {held[0]}, beside {lasting[0]}, which vibrates for ever"
    else:
        return ""
    first = (unknown or held)[0].partition(".")[2]
    return f'counts {what}. {way}: due_to = ["{first}"], or add up the greatest of each: combine = "sum".'


def _blow_handed_on(scene: Scene, response: TransientResponse, names: Sequence[str]) -> str:
    """Reads an acceleration or a force where an inerter ends, and one hands a blow on; or a joint that a blow jolts."""
    inerters = {link: {link, *two} for link, two in places.ends(scene).items() if _passes(scene, link) > 1}
    jump, joints = set(places.joints(scene)).union(*inerters.values()), places.joints(scene)
    place, read = _place(response), response.dimension
    for name in (name for name, one in _once(scene, names).items() if one.blows):
        on = str(scene.excitations[name].on)
        wheel = next((link for link, parts in inerters.items() if on in parts), "")
        blow = f"the blow of excitations.{name}"
        if wheel and place in jump and read in ("acceleration", "force"):  # forces of springs and dampers do not jump
            what, way = f"inerters.{wheel} hands {blow} on at once", "Write a pulse with a duration instead"
        elif place in joints and read == "acceleration" and _falls(scene, on)[place] < 1:
            what, way = (
                f"{blow} reaches {place}, which has no mass, at once",
                "Give it its mass, or ask for its peak_velocity",
            )
        else:
            continue
        return f"is infinite whatever the design: {what}. {way}."
    return ""


def _led(scene: Scene, response: RandomResponse | TransientResponse, name: str) -> bool:
    """Whether a base moves along what is read: in space it may do so across."""
    read, moved = getattr(response, "direction", None), getattr(scene.excitations[name], "direction", None)
    return read is None or moved is None or bool(np.dot(read, moved))


def _moves_on(scene: Scene, response: TransientResponse, names: Sequence[str]) -> str:
    """Reads a displacement beside a base that does not come back."""
    grows = {"peak_displacement": (True, False), "peak_velocity": (True,)}.get(response.response, ())
    moved = [
        name
        for name, one in _once(scene, names).items()
        if one.family == "bases" and not one.returns and one.holds in grows and _led(scene, response, name)
    ]
    if not moved:
        return ""
    return (
        f"is infinite whatever the design: the base of excitations.{moved[0]}, whose acceleration is given, moves on "
        f"behind it, and {_place(response)} with it. Ask for "
        f"{'the peak_travel of a mount' if scene.mounts else 'peak_relative_displacement across a link'}."
    )


def check_lossy(scene: Scene, path: Path, what: str, mistakes: Mistakes) -> None:
    """A loss factor knows steady harmonic motion only."""
    lossy = [
        f"{family}.{name}"
        for family, name, table in places.devices(scene)
        if getattr(table, "loss_factor", None) is not None
    ]
    if lossy:
        other = "" if lossy[0].startswith(("mounts.", "structures.")) else " or damping_ratio"
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {what}, but {lossy[0]} has a loss_factor, which speaks of steady harmonic "
            f"motion only. Give it damping{other} instead.",
        )


def _infinite(scene: Scene, path: Path, response: RandomResponse, mistakes: Mistakes, broken: set[str]) -> None:
    """What is infinite whatever the design, and what no noise reaches."""
    check_lossy(scene, path, "response to white noise", mistakes)
    names, power = names_for(scene, response), getattr(response.steady, "power", None)
    if (
        _many_coordinates(scene, path, mistakes)
        or _joint_pushed(scene, path, response, names, mistakes)
        or _through_inerter(scene, path, response, names, mistakes)
    ):
        return
    if not whole(scene, broken) or not _acting(scene, names):
        return
    place = next((name for name, _ in response.places().values()), "")
    if place in places.turning(scene):
        mistakes.add(path, f"{dotted(path)} looks at {place}, which turns. Random vibration is of bodies on a line.")
        return
    if not reached(scene, path, response, names, mistakes):
        return
    for name in names:
        noise = scene.excitations[name]
        if power is not None and power > 1 and noise.on == place:
            mistakes.add(
                path,
                f"{dotted(path)} is infinite whatever the design: white noise holds every frequency, and the force of "
                f"excitations.{name} accelerates {place} at once. Ask for rms_velocity or rms_displacement.",
            )
        elif noise.displaced:
            _at_once(scene, path, response, name, mistakes)
        elif noise.family == "bases" and power is not None and power < 2 and _led(scene, response, name):
            mistakes.add(
                path,
                f"{dotted(path)} is infinite whatever the design: a base whose acceleration is white noise "
                f"(excitations.{name}) drifts away, and {place} with it. Ask for rms_relative_displacement across a "
                "link, or for rms_acceleration.",
            )


def _many_coordinates(scene: Scene, path: Path, mistakes: Mistakes) -> bool:
    """Whether matrices have more modes than are carried where every frequency counts; adds the mistake."""
    for name, table in scene.structures.items():
        if table.modes is None and table.matrices.size > MOST_WHOLE:
            mistakes.add(
                path,
                f"{dotted(path)} takes every mode of structures.{name}, whose matrices have {table.matrices.size} "
                f"coordinates with mass; {MOST_WHOLE} are the most that are carried so. Give its modes up to the "
                "highest frequency that counts instead.",
            )
            return True
    return False


def _joint_pushed(
    scene: Scene,
    path: Path,
    response: RandomResponse | TransientResponse,
    names: tuple[str, ...],
    mistakes: Mistakes,
) -> bool:
    """Whether a load that is not steady acts on a joint in a way that has no answer; adds the mistake."""
    light = places.joints(scene)
    held = {end for link in damped_links(scene) for end in places.ends(scene).get(link, ())}
    place, power = next((name for name, _ in response.places().values()), ""), getattr(response.steady, "power", 0)
    for name in names:
        on, begins = str(scene.excitations[name].on), _begins(scene, name)
        if on in light and any(begins) and (begins[1] or on not in held):
            why = "has no mass. Release a body with mass, or a joint that a damper holds, by a displacement alone."
        elif on in light and any(begins):
            continue
        elif on in light and on not in held:
            why = "springs alone hold, so that it jumps with the force. Push a body with mass, or give it a damper."
        elif on in light and on == place and (power or 0) > 1:
            why = "has no mass: its acceleration follows the rate of the force. Ask for its velocity or displacement."
        else:
            continue
        does = "shakes" if on not in light else "releases" if any(begins) else "pushes"
        mistakes.add(path, f"{dotted(path)}: excitations.{name} {does} {on}, which {why}")
        return True
    return False


def _begins(scene: Scene, name: str) -> tuple[float, float]:
    """Displacement and velocity with which what an excitation acts on begins."""
    once = scene.excitations[name].once
    return once.start if once is not None else (0.0, 0.0)


def _through_inerter(
    scene: Scene, path: Path, response: RandomResponse, names: tuple[str, ...], mistakes: Mistakes
) -> bool:
    """Whether a force that follows an acceleration is read, or a base drives it beside another support."""
    inerters = {link for link in places.ends(scene) if _passes(scene, link) > 1}
    ends = places.ends(scene)
    place = next((name for name, _ in response.places().values()), "")
    if {"into", "through"} & set(response.places()):
        read = [link for link in inerters if place == link or place in ends[link]]
        if read:
            mistakes.add(
                path,
                f"{dotted(path)} reads the force of inerters.{read[0]}, which follows an acceleration. Under white "
                "noise that is not supported yet. Ask for rms_relative_displacement, or for the force of one link.",
            )
            return True
    shaken = {scene.excitations[name].on for name in names} & set(places.supports(scene))
    others = {end for two in ends.values() for end in two if end not in places.moving(scene)} - shaken
    driven = [link for link in inerters if shaken & set(ends[link]) and others]
    if driven:
        mistakes.add(
            path,
            f"{dotted(path)}: inerters.{driven[0]} ends at a base that white noise shakes, beside another support. "
            "That is not supported yet. Let every support be that base.",
        )
    return bool(driven)


def _at_once(scene: Scene, path: Path, response: RandomResponse, name: str, mistakes: Mistakes) -> None:
    """A base whose displacement is white noise: what does not fall off with frequency is infinite whatever the design.

    A spring passes a displacement on to a mass as its second integral, a damper as its first.
    """
    falls = _falls(scene, scene.excitations[name].on)
    power = getattr(response.steady, "power", None)
    if power is not None:
        order = falls[response.places()["of"][0]] - power
    else:
        order = min(falls[end] - damped for end, damped in _read_links(scene, response))
    if order < 1:
        mistakes.add(
            path,
            f"{dotted(path)} is infinite whatever the design: a base whose displacement is white noise "
            f"(excitations.{name}) moves alike at every frequency, and of this response too much is left at high ones. "
            "Ask for rms_displacement of a body that the base reaches through a spring or a damper, or give a density "
            "of acceleration.",
        )


def _falls(scene: Scene, base: str) -> dict[str, float]:
    """Per point the power of the frequency with which its motion under that of a base falls off; inf if it stays."""
    joined = [(*ends, _passes(scene, link)) for link, ends in places.ends(scene).items()]
    resists = {joint: max(hands for a, b, hands in joined if joint in (a, b)) for joint in places.joints(scene)}
    groups = [table.names for table in scene.structures.values()]
    falls = {one: float("inf") for one in (*places.points(scene), GROUND)} | {base: 0.0}
    for _ in falls:
        for a, b, hands in joined:
            for one, other in ((a, b), (b, a)):
                if one != GROUND and other in places.moving(scene):
                    falls[other] = min(falls[other], falls[one] + resists.get(other, 2) - hands)
        for names in groups:
            falls |= {name: min(falls[other] for other in names) for name in names}
    return falls


def _passes(scene: Scene, link: str) -> int:
    """Power of the frequency that the force across a link has beyond that of a spring: 1 with a damper."""
    table = next(device for _, name, device in places.devices(scene) if link in device.joins(name))
    return table.passes or int(_damped(table))


def _damped(table: Device) -> bool:
    """Whether a link has a damper, or may be given one."""
    for key in ("damping", "torsional_damping", "damping_ratio"):
        given = getattr(table, key, None)
        if given is not None and getattr(given, "value", 1.0) > 0.0:
            return True
    return False


def damped_links(scene: Scene) -> list[str]:
    """Links that have a damper, or may be given one."""
    return [link for _, name, table in places.devices(scene) if _damped(table) for link in table.joins(name)]


def _read_links(scene: Scene, response: RandomResponse) -> list[tuple[str, int]]:
    """Ends of the links that are read, each with the power of the frequency by which the reading grows."""
    ends = places.ends(scene)
    across = getattr(response, "across", None)
    if across is not None:
        return [(one, 0) for one in ends[across]]
    through, into = getattr(response, "through", None), getattr(response, "into", None)
    names = [through] if through is not None else [link for link, two in ends.items() if into in two]
    return [(one, _passes(scene, link)) for link in names for one in ends[link]]


def _acting(scene: Scene, names: tuple[str, ...]) -> bool:
    """Whether every noise acts on something that it can act on; one that does not has been reported already."""
    noises = [scene.excitations[name] for name in names]
    return all(
        noise.on in (places.moving(scene) if noise.family == "bodies" else places.supports(scene)) for noise in noises
    )
