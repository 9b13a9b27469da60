"""Whether a limit's excitations and speeds make sense."""

from __future__ import annotations

from vibopt.devices import FAMILIES
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import HarmonicResponse, RandomResponse, TransientResponse
from vibopt.responses.asked_speeds import START_UP
from vibopt.scene import places
from vibopt.scene.drives import bands_for, line_count, names_for, speeds_for
from vibopt.scene.scene import MAXIMISE, Scene
from vibopt.units import show
from vibopt.units.spelling import split_detector
from vibopt.values import SpeedRange


def check_speeds(scene: Scene, path: Path, response: HarmonicResponse, mistakes: Mistakes, broken: set[str]) -> None:
    """Add what is wrong with the excitations and the speeds of one harmonic response."""
    name = dotted(path)
    if not scene.excitations:
        if not any(one.startswith("excitations.") for one in broken):
            mistakes.add(
                path, f"{name} is a response to vibration, but nothing shakes the machine. Add [excitations.NAME]."
            )
        return
    for one in response.due_to or ():
        if one not in scene.excitations:
            if f"excitations.{one}" not in broken:
                mistakes.unknown_name((*path, "due_to"), one, "excitation", list(scene.excitations))
            return
    if broken and any(one.startswith("excitations.") for one in broken):
        return
    names = names_for(scene, response)
    if not names:
        mistakes.add((*path, "due_to"), f"{name}.due_to is an empty list. Name an excitation, or leave it out.")
        return
    if response.at is not None or response.over is not None:
        _ranges(scene, path, response, names, mistakes)
    lines, _, somewhere, many = _acting(scene, *names)
    if somewhere or lines > 1 or len(names) > 1:
        _several(scene, path, response, names, mistakes)
    if many or response.normalised:
        _ratio(scene, path, response, names, many, mistakes)
    if whole(scene, broken):
        reached(scene, path, response, names, mistakes)


def _ranges(scene: Scene, path: Path, response: HarmonicResponse, names: tuple[str, ...], mistakes: Mistakes) -> None:
    key = "at" if response.at is not None else "over"
    given = response.at if response.at is not None else response.over
    where = dotted(path)
    if isinstance(given, dict):
        for one in given:
            if one not in names:
                mistakes.unknown_name((*path, key), one, "excitation of this response", list(names))
    elif given == START_UP and len(names) > 1:
        each = ", ".join(f'{name} = "{START_UP}"' for name in names)
        mistakes.add(
            (*path, key),
            f"{where}.{key} speaks of one start-up, but {len(names)} excitations act here: whose? Write "
            f"{key} = {{ {each} }}, or name one in due_to.",
        )
        return
    elif given is not None and len(names) > 1:
        mistakes.add(
            (*path, key),
            f"{where}.{key} speaks of one speed, but {len(names)} excitations act here: whose? Write {key} = {{ "
            f'{names[0]} = "..." }}, or name one in due_to.',
        )
        return
    for name in names:
        excitation = scene.excitations[name]
        speeds = speeds_for(scene, response, name)
        if isinstance(speeds, SpeedRange) and (speeds.dimension == "velocity") != excitation.of_vehicle:
            mistakes.add(
                (*path, key),
                f"{where}.{key} is {'a vehicle speed' if speeds.dimension == 'velocity' else 'a speed of rotation'}, "
                f"but excitations.{name} counts "
                f"{'vehicle speeds' if excitation.of_vehicle else 'speeds of rotation'}. Write it the same way.",
            )
        elif speeds is not None and (not response.normalised or places.rubbing(scene)):
            _known(scene, path, response, name, mistakes)


def _known(scene: Scene, path: Path, response: HarmonicResponse, name: str, mistakes: Mistakes) -> None:
    """The amplitude must be known at every speed that is looked at."""
    excitation = scene.excitations[name]
    known = excitation.known_bands
    for band in bands_for(scene, response, name):
        if any(one.holds(band.low) and one.holds(band.high) for one in known):
            continue
        where = dotted(path)
        if excitation.variation is None:
            mistakes.add(
                path,
                f"{where} looks at speeds other than those of excitations.{name}: how does its amplitude vary? Add "
                f'varies = "constant" or varies = "speed^2" to excitations.{name}.',
            )
        else:
            ends = [
                show(excitation.from_rotation(x), excitation.speed.unit, excitation.speed.dimension)
                for x in (known[0].low, known[0].high)
            ]
            mistakes.add(
                path,
                f"{where} looks at speeds outside the table of excitations.{name}.varies, which goes from {ends[0]} "
                f"to {ends[1]}. Extend the table, or look at fewer speeds.",
            )
        return


@places.once
def _acting(scene: Scene, *names: str) -> tuple[int, str, str, str]:
    """Of what acts together the number of harmonics, and the first of loose parts, at any place, and at several."""
    loose, anywhere, many = (
        next((name for name in names if has(scene.excitations[name])), "")
        for has in (lambda one: len(one.loose) > 1, lambda one: one.anywhere, lambda one: len(one.everywhere) > 1)
    )
    return line_count(scene, names), loose, loose or anywhere, many


def _several(scene: Scene, path: Path, response: HarmonicResponse, names: tuple[str, ...], mistakes: Mistakes) -> None:
    (lines, loose, somewhere, _), where = _acting(scene, *names), dotted(path)
    most = path == ("goal",) and scene.goal is not None and scene.goal.sense == MAXIMISE
    if somewhere and (most or response.at_least is not None or response.worst == "least"):
        mistakes.add(
            path,
            f"{where} asks for the least that excitations.{somewhere} does, whose parts may cancel: at worst nothing. "
            "Ask for the greatest.",
        )
        return
    if loose and response.combine not in (None, "sum"):
        mistakes.value(
            (*path, "combine"),
            response.combine,
            f"does not fit excitations.{loose}, whose unbalances stand at any angles: the worst is their sum. Write "
            'combine = "sum".',
        )
        return
    if lines > 1 and response.combine is None and not response.normalised:
        what = f"{len(names)} excitations" if len(names) > 1 else f"{lines} harmonics of {names[0]}"
        mistakes.add(
            path,
            f'{where} counts {what}: how do they add up? Add combine = "sum" (never too small), "rss"'
            + (
                ' or "peak" (true peak over time).'
                if len(names) == 1
                else f', or due_to = ["{names[0]}"] for one alone.'
            ),
        )
    if response.combine == "peak" and len(names) > 1:
        mistakes.value(
            (*path, "combine"),
            "peak",
            'needs phases, but machines that run independently have no fixed phase. Write "sum" or "rss".',
        )
    if lines > 1 and response.combine is not None:
        _detected(path, response, response.combine, mistakes)


def _detected(path: Path, response: HarmonicResponse, combine: str, mistakes: Mistakes) -> None:
    """What is bounded or shown in rms or pp must be that of several harmonics as they add up."""
    bounds = (getattr(bound, "detector", None) for bound in (response.at_most, response.at_least))
    said = {("bound", bound) for bound in bounds} | {("unit", split_detector(response.unit or "")[1])}
    for what, detector in sorted(said, key=str):
        if detector == "rms" and combine != "rss":
            mistakes.value(
                (*path, "combine"),
                combine,
                f"does not fit a {what} in rms: the rms of several harmonics is their root of sum of squares. Write "
                'combine = "rss".',
            )
        if detector == "pp" and combine != "sum":
            mistakes.value(
                (*path, "combine"),
                combine,
                f"does not fit a {what} in pp: with several harmonics the swing is not twice the peak. Write the "
                f"{what} in pk.",
            )


def _ratio(
    scene: Scene, path: Path, response: HarmonicResponse, names: tuple[str, ...], many: str, mistakes: Mistakes
) -> None:
    if many and (response.normalised or response.rigid_link):
        more = "places (or_on)" if scene.excitations[many].anywhere else "unbalances (also)"
        mistakes.add(
            path,
            f"{dotted(path)} is a ratio to one force, but excitations.{many} has further {more}. Limit the force or "
            "the motion itself.",
        )
        return
    if not response.normalised:
        return
    where = dotted(path)
    if len(names) > 1 or line_count(scene, names) > 1:
        mistakes.add(
            path,
            f"{where} is a ratio to one excitation of one frequency, but several act. Name one in due_to, or limit "
            "the force or the motion itself.",
        )
        return
    family, why, way = response.ratio_to
    if scene.excitations[names[0]].family != family:
        mistakes.add(path, f"{where}: {why}, which excitations.{names[0]} is not.{way}")


def whole(scene: Scene, broken: set[str]) -> bool:
    """Whether all devices could be read, and every link ends at something."""
    return not any(one.split(".")[0] in FAMILIES for one in broken) and _joined(scene)


@places.once
def _joined(scene: Scene) -> bool:
    """Whether every link ends at something; a link that does not has been reported already."""
    points = set(places.points(scene))
    return all(end in points for two in places.ends(scene).values() for end in two)


@places.once
def _still(scene: Scene, place: str, *names: str) -> bool:
    """Whether excitations lead to no motion of a place, or of what ends there; not of a place that is not there."""
    acts = {on for name in names for on in scene.excitations[name].everywhere}
    return _rests(scene, place, acts) and _rests(scene, place, places.shaken(scene, *names))


def _rests(scene: Scene, place: str, moved: set[str]) -> bool:
    """The same, where points move."""
    ends = places.ends(scene)
    if place in places.moving(scene):
        return place not in moved
    if place in ends:
        return not any(end in moved for end in ends[place])
    there = any(end in moved for two in ends.values() if place in two for end in two if end != place)
    return place in places.points(scene) and not there


def reached(
    scene: Scene,
    path: Path,
    response: HarmonicResponse | RandomResponse | TransientResponse,
    names: tuple[str, ...],
    mistakes: Mistakes,
) -> bool:
    """Whether something arrives at a response; where nothing does it is a mistake, and not a limit that holds."""
    before = len(mistakes.found)
    geared = [(name, body.geared_to) for name, body in scene.bodies.items() if body.geared_to is not None]
    if any(to == name or to not in places.raw(scene, "bodies") for name, to in geared):
        return True  # told already; what it turns is not known
    for place in sorted({name for name, _ in response.places().values()}):
        if _still(scene, place, *names):
            where = dotted(path)
            mistakes.add(
                path,
                f"{where} looks at {place}, which {' and '.join(names)} cannot move: no link leads there. Add a "
                "link, or name another place.",
            )
    return len(mistakes.found) == before
