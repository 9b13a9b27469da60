"""Thousands of one-mass questions that differ in one number, answered together.

`lower` reads a program as numbers, `numbers` finds how they follow the varied fact, `outer` answers,
`check` measures the answers on the machines as built.  What does not fit is refused and answered one by one.
"""
