"""The sheet: one printed page for a machine on mounts, that an engineer can sign."""

from vibopt.report.sheet.printing import browser, digests_of, pdf
from vibopt.report.sheet.sheet_page import asks_for_one_design, html, printed

__all__ = ["asks_for_one_design", "browser", "digests_of", "html", "pdf", "printed"]
