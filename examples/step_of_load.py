"""A shaft on its bearing is struck by a step of load: how it rings, and at which frequencies."""

import matplotlib.pyplot as plt
import numpy as np

from bearing_twin import load_scene, simulate

scene = load_scene("bearing_6203_step_load")
samples = list(simulate(scene))
times = np.array([sample.time_ns for sample in samples]) * 1e-9  # s
drop = np.array([sample["inner_ring_offset"][1] for sample in samples]) * 1e6  # µm

after = times >= 0.01
signal = drop[after] - drop[after].mean()
spectrum = np.abs(np.fft.rfft(signal * np.hanning(len(signal)))) * 4.0 / len(signal)
hertz = np.fft.rfftfreq(len(signal), 1.0 / scene.parameters.run.output_rate)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.plot(times * 1e3, drop)
left.set(xlabel="time [ms]", ylabel="inner ring, y [µm]", title="20 N downwards after 10 ms")
right.semilogy(hertz, spectrum)
right.set(xlabel="frequency [Hz]", ylabel="amplitude [µm]", xlim=(0, 3000), ylim=(1e-6, 10), title="Its spectrum")
figure.savefig("step_of_load.png", dpi=100)
print(f"strongest at {hertz[spectrum.argmax()]:.0f} Hz")
