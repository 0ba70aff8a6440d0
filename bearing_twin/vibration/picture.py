"""Picture of an envelope spectrum, with the lines that damage would leave."""

import numpy as np
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.pictures.panels import finish
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading
from bearing_twin.vibration.envelope import DAMAGE, HARMONICS, Spectrum

COLOURS = {"BPFO": BALL_COLOURS[5], "BPFI": BALL_COLOURS[0], "2BSF": BALL_COLOURS[2], "FTF": BALL_COLOURS[3]}


def draw_spectrum(found: Spectrum, name: str, path):
    """Draws amplitude and level over frequency, the harmonics of each family dashed where they were found."""
    figure = Figure(figsize=(15.0, 9.0), dpi=100, facecolor="white")
    grid = figure.add_gridspec(2, 1, left=0.07, right=0.975, top=0.86, bottom=0.1, hspace=0.34)
    rows = (
        (found.amplitude, "Amplitude of the envelope", "amplitude [m/s²]"),
        (found.level, "Level over the median around each frequency", "level [dB]"),
    )
    shown = found.orders > 0.3
    hertz = found.shaft_hz * found.orders[shown]
    lines = {line.name: line for line in found.lines}
    for place, (values, words, label) in enumerate(rows):
        panel = figure.add_subplot(grid[place])
        frame(panel)
        panel.plot(hertz, values[shown], lw=0.8, color=STYLE["ink"])
        for family, colour in COLOURS.items():
            for harmonic in HARMONICS:
                line = lines[f"{harmonic}x{family}" if harmonic > 1 else family]
                key = family if harmonic == 1 else None
                panel.axvline(line.found_hz, color=colour, ls="--", lw=1.4, alpha=0.8, zorder=1.5, label=key)
        panel.set_xlim(0.0, hertz[-1])
        panel.set_ylim(0.0, 1.05 * float(np.max(values[shown])))
        heading(panel, words, "frequency [Hz]", label)
        if place == 0:
            panel.legend(frameon=False, fontsize=11, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=4)
    low, high = (round(one) for one in found.band_hz)
    words = f"shaft {found.shaft_hz:.4g} Hz   ·   band {low} to {high} Hz   ·   {found.seconds:.4g} s"
    title = DAMAGE.get(found.verdict, found.verdict)
    return finish(figure, f"{name}: {title}", f"{words}   ·   bearing_twin {__version__}", path)
