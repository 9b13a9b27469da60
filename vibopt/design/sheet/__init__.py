"""The sheet: one printed page for a machine on mounts, that an engineer can sign."""

from vibopt.design.sheet.digest import digests_of
from vibopt.design.sheet.page import asks_for_one_design, html, printed
from vibopt.design.sheet.pdf import browser, pdf

__all__ = ["asks_for_one_design", "browser", "digests_of", "html", "pdf", "printed"]
