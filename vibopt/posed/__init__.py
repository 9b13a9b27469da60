"""The programs in the open: every job as a cvxpy problem where it is convex, and in CasADi where it is smooth.

These are the statements that a reader can check against a textbook, and that an engineer can add a constraint to.
The exact methods stay the default; `--method cvxpy` and `--method ipopt` solve what stands here.
"""
