"""The answer and its evidence."""
