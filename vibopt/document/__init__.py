"""A problem file as text and tables: reading, writing, paths, and mistakes with their lines."""
