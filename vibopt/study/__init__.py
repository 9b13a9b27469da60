"""Studies: many answers, compared."""
