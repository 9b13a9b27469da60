"""What people do instead: grid search, and common solvers on sampled speeds.  Never the default.

Each is given scaled variables, exact slopes and a good start, and claims what its solver claims.
"""
