"""From rest to rolling: friction carries the balls of a bearing up to the speed of its theory."""

import matplotlib.pyplot as plt
import numpy as np

from bearing_twin import load_scene, simulate

run = simulate(load_scene("bearing_6203_start", ["run.duration=0.0008", "run.output_rate=1e5"]))
samples = list(run)
times = np.array([sample.time_ns for sample in samples]) * 1e-6  # ms
rolling = np.array([np.abs(sample["roll_rate"]) for sample in samples])  # rad/s, of each ball
theory = abs(run.report.figures["roll_rate_theory_rad_s"])

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
axes.plot(times, rolling, linewidth=0.8)
axes.axhline(theory, color="black", linestyle="--", label="pure rolling")
axes.set(xlabel="time [ms]", ylabel="roll rate of each ball [rad/s]", title="A 6203 from rest under preload, 1750 rpm")
axes.legend(loc="lower right")
figure.savefig("up_to_speed.png", dpi=100)
print(f"{rolling[-1].mean():.1f} rad/s at the end; pure rolling is {theory:.1f} rad/s")
