"""The command line: one file per group of verbs, each loaded only when it is called."""
