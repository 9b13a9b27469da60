"""Balancing in the charts: its optimisers against rivals, on questions whose answers other roads give."""
