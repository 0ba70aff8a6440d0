"""An ellipsoid bounces without loss: height over time, and where its energy goes."""

import matplotlib.pyplot as plt
import numpy as np

from bearing_twin import load_scene, simulate

samples = list(simulate(load_scene("ellipsoid_tumbling")))
times = np.array([sample.time_ns for sample in samples]) * 1e-9  # s
height = np.array([sample["position"][2] for sample in samples]) * 1e3  # mm
energies = {
    name: np.array([float(sample[f"{name}_energy"]) for sample in samples]) for name in ("kinetic", "potential")
}

figure, (above, below) = plt.subplots(2, 1, figsize=(8, 6), sharex=True, layout="constrained")
above.plot(times, height)
above.set(ylabel="height of the centre [mm]", title="A tri-axial ellipsoid tumbles and bounces")
below.stackplot(times, *energies.values(), labels=list(energies))
below.set(xlabel="time [s]", ylabel="energy [J]")
figure.legend(ncols=2, loc="outside lower center")
figure.savefig("falling_ellipsoid.png", dpi=100)
total = sum(energies.values())
print(f"between contacts the energy stays within {np.ptp(total[[0, -1]]) / total[0]:.1e} of itself")
