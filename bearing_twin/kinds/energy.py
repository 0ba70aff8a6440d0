"""The channels of the energy that a scene stores, and how much of energy numbers may gain or lose."""

STORED = ("kinetic_energy", "elastic_energy", "potential_energy")
ENERGY_GAIN = 0.01  # of the energy brought or the work moved; more, either way, is never a success
