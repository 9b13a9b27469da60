"""One link's stiffness and damping on any machine: at each speed a disc, and what discs have in common."""
