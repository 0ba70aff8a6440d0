"""Paper 3, figures 13 and 14: the contact time of two discs by line contact, their modulus uncertain."""

import numpy as np

from bearing_twin.charts.sheets import Axis, Panel, Sheet
from bearing_twin.charts.study_convergence import errors, path_panel
from bearing_twin.charts.study_samples import CONTACT_TIME, bars, colour, density_line, draws, footer, known
from bearing_twin.charts.study_spheres import DENSITY
from bearing_twin.uq.statistics import half_widths

STUDIES = {"10 m/s": "discs_small_10", "100 m/s": "discs_small_100"}
MODULUS = Axis("Young's modulus", "Pa")
SEEDS = 25
PRINTED = 1.52e-7  # what the paper calls the deviation of the contact time at 10 m/s, in seconds


def discs(update) -> Sheet:
    """Figures 13 and 14 at both speeds, and the same discs by the law for thick ones."""
    ones = {speed: known(name) for speed, name in STUDIES.items()}
    both = {speed: draws(one) for speed, one in ones.items()}
    slow, moduli = ones["10 m/s"], both["10 m/s"][0]
    source = slow.study.inputs[0]
    top = [Panel("figure 13, modulus", "Figure 13: Young's modulus", MODULUS, Axis("density", "1/Pa"), [
        bars(moduli), density_line("gamma", source),
    ])]  # fmt: skip
    convergence, reading = [], []
    for place, (speed, one) in enumerate(ones.items()):
        parts = [bars(both[speed][1]), density_line("change of variable", one.exact)]
        top.append(Panel(f"figure 13, {speed}", f"Figure 13: contact time at {speed}", CONTACT_TIME, DENSITY, parts))
        counts, of_std, _ = errors(one, SEEDS, lambda share, place=place: update(0.5 * (place + share)))
        band = half_widths(one.exact, counts).std / one.exact.std
        title = f"Figure 14: deviation at {speed}"
        convergence.append(path_panel(f"figure 14, {speed}", title, counts, of_std, band))
        reading.append(
            f"At {speed} eq. (14) gives a mean contact time of {one.exact.mean:.5e} s with a deviation of "
            f"{one.exact.std:.4e} s, known to ± {100.0 * band[-1]:.1f} % from {counts[-1]} realisations."
        )
    laws, shorter = _laws(ones)
    printed = float(np.sqrt(PRINTED))
    less = 100.0 * (1.0 - printed / slow.exact.std)
    reading += [
        f"What the paper prints as a deviation of {PRINTED:g} s comes nearest as a variance, {printed:.2e} s as a "
        f"deviation: that is {less:.0f} % less than eq. (14) gives with the printed data.",
        f"For discs this thick eq. (14) is too long: Johnson's law of plane strain gives {shorter} of its mean.",
    ]
    title = "Two rubber discs by line contact: modulus gamma with mean 5e9 and deviation 1e9 Pa"
    return Sheet(title, [top, [*convergence, laws]], footer(slow, SEEDS), reading)


def _laws(ones):
    """Densities of the contact time by both laws, and in words how much shorter Johnson's is."""
    parts, shorter = [], []
    for place, (speed, one) in enumerate(ones.items()):
        other = known(STUDIES[speed], "contact.normal=johnson")
        parts.append(density_line(f"eq. (14), {speed}", one.exact, colour(place)))
        parts.append(density_line(f"Johnson, {speed}", other.exact, {**colour(place), "linestyle": "--"}))
        shorter.append(f"{other.exact.mean / one.exact.mean:.3f} at {speed}")
    return Panel("two laws", "Contact time by two laws", CONTACT_TIME, DENSITY, parts), " and ".join(shorter)
