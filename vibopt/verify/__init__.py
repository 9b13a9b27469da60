"""The finished thing measured again by another road, and both roads compared."""
