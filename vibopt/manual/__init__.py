"""The manual: guides in `guides/*.md`, and pages made from registries, tables and docstrings, so that none can drift.

One book of topics has two faces: `vibopt help` in the terminal and `vibopt manual`, a page that stands alone.  A new
key needs a line under "Keys" in the docstring of its table; a new guide is a file and a name in `book.GROUPS`.
"""
