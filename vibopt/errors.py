"""What can go wrong, in the user's words.

Each text says where, what was given, what is wrong and the way out. Messages about a value are
sentences in two halves: the reader of the file knows the place, the reader of the value knows the complaint.
"""

import re
from collections.abc import Iterable

LONGEST = 399
"""Most letters of one message, whatever was given."""
_PIECE, _CONTROL = r"\S{61,}", "[\\x00-\\x1f\\x7f-\\x9f\\ud800-\\udfff]"
_MEANT = {
    "objective": ("goal",),
    "target": ("goal", "of"),
    "constraints": ("limits",),
    "outputs": ("measures",),
    "loads": ("excitations",),
    "forces": ("excitations",),
    "machines": ("bodies",),
    "springs": ("links",),
    "isolators": ("mounts", "links"),
    "dampers": ("absorbers",),
    "upper": ("at_most", "to"),
    "max": ("at_most", "to"),
    "maximum": ("at_most", "to"),
    "lower": ("at_least", "from"),
    "min": ("at_least", "from"),
    "minimum": ("at_least", "from"),
    "k": ("stiffness",),
    "c": ("damping",),
    "m": ("mass",),
    "zeta": ("damping_ratio",),
    "body": ("on", "of"),
    "of": ("across", "into", "on"),
    "into": ("of", "across", "on"),
    "through": ("across", "of", "on"),
    "across": ("through", "of", "on"),
    "ends": ("between",),
    "force": ("amplitude", "transmitted_force"),
    "magnitude": ("amplitude", "displacement"),
    "amplitude": ("displacement", "unbalance"),
    "rate": ("acceleration",),
    "time": ("duration",),
    "friction": ("friction_force",),
    "csv": ("file",),
    "earthquake": ("record",),
    "ground_motion": ("record",),
    "shock": ("pulse",),
    "impact": ("pulse",),
    "fall": ("drop",),
    "length": ("duration",),
    "frequency": ("speed", "natural_frequency"),
    "rpm": ("speed",),
    "range": ("over",),
    "speeds": ("over",),
    "type": ("kind", "response"),
    "quantity": ("response", "count"),
    "number": ("count", "at"),
    "number_of_mounts": ("count", "at"),
    "qty": ("count", "at"),
    "pieces": ("count", "at"),
    "n": ("count", "at"),
    "on": ("between", "of", "across", "into"),
    "mount": ("of", "through"),
    "link": ("of", "through"),
    "height": ("centre", "at"),
    "position": ("at", "centre"),
    "positions": ("at",),
    "location": ("at",),
    "place": ("at",),
    "places": ("at",),
    "cog": ("centre",),
    "cg": ("centre",),
    "centre_of_gravity": ("centre", "centre_of_mass"),
    "moment_of_inertia": ("inertia",),
    "eccentricity": ("radius",),
    "value": ("at_most", "amplitude"),
    "limit": ("at_most",),
    "bound": ("at_most",),
    "floor_force": ("transmitted_force",),
    "force_into_floor": ("transmitted_force",),
    "force_into_ground": ("transmitted_force",),
    "foundation_force": ("transmitted_force",),
    "support_force": ("transmitted_force",),
    "base_force": ("transmitted_force",),
    "mount_force": ("transmitted_force",),
    "reaction": ("transmitted_force",),
    "sag": ("static_deflection",),
    "deflection": ("static_deflection",),
    "resonance": ("natural_frequency",),
    "eigenfrequency": ("natural_frequency",),
    "vibration": ("velocity",),
    "cost": ("price",),
    "isolation_efficiency": ("isolation",),
    "efficiency": ("isolation",),
    "options": ("one_of",),
    "choices": ("one_of",),
    "youngs_modulus": ("modulus",),
    "young_modulus": ("modulus",),
    "e_modulus": ("modulus",),
    "outer_diameter": ("diameter",),
    "polar_inertia": ("polar",),
    "diametral_inertia": ("diametral",),
    "transverse_inertia": ("diametral",),
    "relative_damping": ("loss_factor",),
    "margin": ("outside",),
    "separation_margin": ("critical_speed", "outside"),
    "threshold_speed": ("stability_threshold",),
    "onset_speed": ("stability_threshold",),
    "file": ("catalogue", "readings"),
    "headings": ("columns",),
}
"""What users call a thing that has another name here; the first of them that is known is proposed."""
_SHORT = 2
"""Letters of a name that is like too many."""
_LISTED = 240
"""Most letters of a list of known names."""


class VibOptError(Exception):
    """Root of everything vibopt raises on purpose; `exit_code` is the code of the command line."""

    exit_code: int = 1


class InputError(VibOptError):
    """Mistakes in what the user wrote, all of them at once.

    Parameters
    ----------
    messages
        One finished sentence per mistake, in the order of the file; a single text counts as one.
    """

    exit_code = 2

    def __init__(self, messages: Iterable[str] | str) -> None:
        said = (messages,) if isinstance(messages, str) else messages
        self.messages: tuple[str, ...] = tuple(brief(one) for one in said)
        super().__init__(self.messages)

    def __str__(self) -> str:
        return "\n".join(self.messages)


class QuantityError(VibOptError, ValueError):
    """A value that cannot be read.

    Parameters
    ----------
    complaint
        Continues the sentence "<file> line N: <path> = <given> ", as in 'has no unit. Write "480 kg".'
    """

    exit_code = 2

    def __init__(self, complaint: str) -> None:
        self.complaint = complaint
        super().__init__(complaint)


class UnknownName(VibOptError):  # noqa: N818 - reads better in "except UnknownName"
    """A name that nothing in the scene carries."""

    exit_code = 2

    @classmethod
    def among(cls, what: str, name: str, known: Iterable[str]) -> "UnknownName":
        """The error for `name`, where `what` is the kind of thing ("link") and `known` its names."""
        return cls(f'unknown {what} "{name}".{way_out(name, known)}')


class RoutesDiffer(VibOptError):  # noqa: N818 - a finding rather than an error
    """The model and the machine as built do not agree, so that nothing is told; as the status "check_failed"."""

    exit_code = 6


class PoolError(VibOptError):
    """Those who did the work are gone, and some of it with them; what was ready before is good."""


class NotProven(VibOptError):  # noqa: N818 - public name; a finding rather than an error
    """Raised by `Answer.require_proof()`: the answer may be good, but nothing proves it."""

    exit_code = 5


_ONE = {
    "bodies": "body", "boxes": "box", "batches": "batch", "classes": "class", "frequencies": "frequency",
    "masses": "mass", "ms": "ms", "counterweights and balance shafts": "counterweight or balance shaft",
}  # fmt: skip
"""Words whose plural has more than an s."""
_LARGE, _COUNTLESS = ((1e12, " trillion"), (1e9, " billion"), (1e6, " million")), 1e15


def counted(count: float, things: str) -> str:
    """So many of something: "1 box", "3 boxes"; `things` in the plural, "sets of runs" too."""
    if count != 1:
        size, word = next((pair for pair in _LARGE if pair[0] <= count < _COUNTLESS), (1.0, ""))
        shown = f"{count / size:.{3 if word else 6}g}{word}" if isinstance(count, float) else f"{count}"
        return f"{shown} {things}"
    head, sign, rest = re.fullmatch(r"(.*?)( (?:of|at|with)\b|$)(.*)", things, re.DOTALL).groups()  # type: ignore[union-attr]
    front, _, last = ("", "", head) if head in _ONE else head.rpartition(" ")
    return " ".join(filter(None, ("1", front, _ONE.get(last, last.removesuffix("s"))))) + sign + rest


def way_out(given: object, known: Iterable[str]) -> str:
    """The sentence behind an unknown name: the nearest of `known`, else all of them; starts with a space."""
    name, names = str(given), list(known)
    meant = _MEANT.get(re.sub(r"[\s-]+", "_", name.strip().lower()), ())
    near = [one for one in meant if one in names and (one != "at" or "over" not in names)][:1]  # there a speed
    near = near or [one for one in names if name in one.split(".")][:1]  # a step of a path alone
    if not near and len(name) > _SHORT:
        from difflib import get_close_matches

        near = get_close_matches(name[:LONGEST], names, n=1)
    if near:
        return f' Did you mean "{shortened(near[0], 60)}"?'
    if names:
        return f" Known: {_listed(names)}."
    return ""


def _listed(names: list[str]) -> str:
    """Names in a row; of many the first ones and how many more there are."""
    text = ", ".join(names)
    if len(text) <= _LISTED:
        return text
    kept: list[str] = []
    for name in names:
        kept.append(shortened(name, 60))
        if sum(map(len, kept)) + 2 * len(kept) > _LISTED - 20:
            break
    return f"{', '.join(kept)} and {len(names) - len(kept)} more" if len(kept) < len(names) else ", ".join(kept)


def shortened(text: str, most: int) -> str:
    """A text of at most `most` letters: a longer one has dots in its middle."""
    if len(text) <= most:
        return text
    head = (most - 3) * 2 // 3
    return f"{text[:head]}...{text[len(text) - (most - 3 - head) :]}"


def brief(message: str) -> str:
    """A message in one line of bounded length: a monstrous name is cut, the place and the way out stay."""
    plain = re.sub(_CONTROL, "?", message)
    if len(plain) <= LONGEST:
        return plain
    return shortened(re.sub(_PIECE, lambda match: shortened(match[0], 60), plain), LONGEST)
