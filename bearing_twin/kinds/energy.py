"""The channels of the energy that a scene stores, and how much of energy numbers may gain or lose."""

STORED = ("kinetic_energy", "elastic_energy", "potential_energy")
ENERGY_GAIN = 0.01  # of the energy brought or the work moved; where less exactness is wanted, as much as that


def adds_up(closure: float, parameters) -> bool:
    """True if the energy that numbers gained or lost, a share, is no more than ENERGY_GAIN or than is wanted."""
    return abs(closure) <= max(ENERGY_GAIN, parameters.wanted.tolerance)
