"""Two bodies of any shape that bounce, roll and spin on each other."""
