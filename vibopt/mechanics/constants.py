"""Constants of nature that a scene relies on."""

GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CODATA, exact by definition)."""
