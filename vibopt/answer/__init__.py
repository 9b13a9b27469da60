"""The answer to a job of any kind, and what shows it: text, page, JSON."""
