"""Parts from catalogues: the best choice among all of them, proven."""

from vibopt.solve.catalogue.parts import Catalogue

__all__ = ["Catalogue"]
