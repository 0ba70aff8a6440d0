"""Loads of the balls of a loose bearing: who carries, and for how long."""

import matplotlib.pyplot as plt
import numpy as np

from bearing_twin import load_scene, simulate

run = simulate(load_scene("bearing_6203_loose", ["run.duration=0.1"]))
samples = list(run)
times = np.array([sample.time_ns for sample in samples]) * 1e-6  # ms
loads = np.array([sample["normal_load"][:, 0] for sample in samples])  # N, on the inner raceway

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
axes.stackplot(times, loads.T, labels=[f"ball {ball}" for ball in range(loads.shape[1])])
axes.set(
    xlabel="time [ms]", ylabel="normal load on the inner raceway [N]", title="A 6203 whose inner ring stands 9 µm low"
)
axes.legend(loc="upper left", ncols=4, fontsize="small")
axes.set_ylim(0.0, 1.45 * loads.sum(axis=1).max())
figure.savefig("loads_over_time.png", dpi=100)
print(f"{(loads > 0).sum(axis=1).mean():.1f} balls carry on average, {loads.max():.1f} N at most")
