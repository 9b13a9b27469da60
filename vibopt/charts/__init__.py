"""Charts of methods: speed against accuracy, stability on hard ground, fidelity of the model used."""
