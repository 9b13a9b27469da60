"""vibopt: vibration-control design by optimisation, each answer with its evidence.

    import vibopt as vo
    design = vo.solve(vo.read("problems/isolation/rao_9_34.toml"))

Importing vibopt loads next to nothing and changes nothing; each name is fetched when it is first used.
"""

import sys
from types import FunctionType, ModuleType

from vibopt.answer.views import register as _register

TYPE_CHECKING = False
if TYPE_CHECKING:
    from vibopt.answer.answer import Answer as Answer
    from vibopt.document.toml_writing import to_toml as to_toml
    from vibopt.document.toml_writing import write as write
    from vibopt.errors import InputError as InputError
    from vibopt.errors import NotProven as NotProven
    from vibopt.errors import VibOptError as VibOptError
    from vibopt.jobs import from_dict as from_dict
    from vibopt.jobs import from_text as from_text
    from vibopt.jobs import read as read
    from vibopt.jobs import solve as solve
    from vibopt.jobs import with_changes as with_changes
    from vibopt.posed.posed_job import posed as posed
    from vibopt.report.spectrum_views import shock_spectrum as shock_spectrum
    from vibopt.scene.language import Limit as Limit
    from vibopt.scene.language import Machine as Machine
    from vibopt.scene.language import Measure as Measure
    from vibopt.scene.language import choose as choose
    from vibopt.scene.language import find_all as find_all
    from vibopt.scene.language import maximise as maximise
    from vibopt.scene.language import minimise as minimise
    from vibopt.scene.language import one_of as one_of
    from vibopt.scene.scene import Scene as Scene
    from vibopt.study.explain import explain as explain
    from vibopt.study.prices import prices as prices
    from vibopt.study.remedies import remedies as remedies
    from vibopt.study.sweep import sweep as sweep
    from vibopt.study.tradeoff import tradeoff as tradeoff
    from vibopt.study.tradeoff_surface import tradeoff_surface as tradeoff_surface
    from vibopt.study.variants import compare as compare
    from vibopt.study.whatif import whatif as whatif
    from vibopt.study.window import window as window

_HOMES = {
    "vibopt.answer.answer": ("Answer",),
    "vibopt.errors": ("InputError", "NotProven", "VibOptError"),
    "vibopt.scene.language": (
        "Limit",
        "Machine",
        "Measure",
        "choose",
        "find_all",
        "maximise",
        "minimise",
        "one_of",
    ),
    "vibopt.jobs": ("from_dict", "from_text", "read", "solve", "with_changes"),
    "vibopt.posed.posed_job": ("posed",),
    "vibopt.report.spectrum_views": ("shock_spectrum",),
    "vibopt.scene.scene": ("Scene",),
    "vibopt.document.toml_writing": ("to_toml", "write"),
    "vibopt.study.explain": ("explain",),
    "vibopt.study.prices": ("prices",),
    "vibopt.study.remedies": ("remedies",),
    "vibopt.study.sweep": ("sweep",),
    "vibopt.study.tradeoff": ("tradeoff",),
    "vibopt.study.tradeoff_surface": ("tradeoff_surface",),
    "vibopt.study.variants": ("compare",),
    "vibopt.study.whatif": ("whatif",),
    "vibopt.study.window": ("window",),
}
_register(
    {
        "scene": "vibopt.report.machine_views",
        "rotor": "vibopt.balancing.plan_views",
        "known": "vibopt.balancing.plan_views",
        "engine": "vibopt.balancing.plan_views",
    }
)
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}


if not TYPE_CHECKING:  # a type checker that saw it would take every name for known

    def __getattr__(name: str) -> object:
        if name not in _HOME_OF:
            raise AttributeError(f"vibopt has no {name!r}", name=name, obj=sys.modules[__name__])
        from importlib import import_module

        value = getattr(import_module(_HOME_OF[name]), name)
        if isinstance(value, FunctionType):
            from vibopt.arguments import checked

            value = checked(name, value)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME_OF})


class _Verbs(ModuleType):
    """`vibopt.solve` is the verb: importing the package of the same name does not put a module over it."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in _HOME_OF or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Verbs
