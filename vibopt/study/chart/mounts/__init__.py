"""Machines on mounts of a catalogue in the charts: random shelves, hard ground, one, three and six coordinates."""
