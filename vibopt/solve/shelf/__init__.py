"""Parts from catalogues: the best choice among all of them, proven."""

from vibopt.solve.shelf.method import Catalogue

__all__ = ["Catalogue"]
