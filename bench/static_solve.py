"""Times equilibria: `python bench/static_solve.py`, microseconds of processor a load case of a 6203 with 8 balls.

The loads point in all directions, 1000 N on average along each axis. A case is solved from nothing.
"""

import time

import numpy as np

from bearing_twin import equilibrium

CASES = 20_000


def main() -> None:
    """Prints one line a case."""
    loads = np.random.default_rng(0).normal(scale=1000.0, size=(CASES, 3))
    radial, tilting = np.tile([0.0, -1000.0, 0.0], (CASES, 1)), np.pad(loads, ((0, 0), (0, 2)))
    equilibrium("bearing_6203_rig_1000N", loads[:10])  # imports
    print(f"{CASES} cases in one call of equilibrium, µs a case")
    for label, cases in (("radial", radial), ("all directions", loads), ("all directions, tilts free", tilting)):
        for speed, control in ((0.0, "shared"), (157.08, "shared"), (157.08, "auto")):
            begin = time.process_time()
            equilibrium("bearing_6203_rig_1000N", cases, drive__speed=speed, model__control=control)
            spent = 1e6 * (time.process_time() - begin) / CASES
            print(f"  {label:30}{speed:4.0f} rad/s, control {control:8}{spent:6.1f}")


if __name__ == "__main__":
    main()
