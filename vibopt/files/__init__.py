"""The two doors to the disk: every file is read through `reading` and written through `writing`."""
