"""The question as data: variables, limits as forms with bounds, and a goal."""
