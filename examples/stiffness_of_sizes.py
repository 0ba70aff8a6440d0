"""Stiffness against load for bearings of one bore series, from the JSON of the command line."""

import json
import subprocess

import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
for size in ("6004", "6204", "6304"):
    command = ["bearing_twin", "bearing", size, "--load", "0,-1000,0", "--sweep", "load=50:3000:25", "--json"]
    curves = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    loads = curves["values"]  # N
    radial = [matrix[1][1] * 1e-6 for matrix in curves["stiffness"]]  # N/µm, of y by y
    axes.plot(loads, radial, label=size)
    print(f"{size}: {radial[-1]:.0f} N/µm at {loads[-1]:.0f} N")
axes.set(xlabel="radial load [N]", ylabel="radial stiffness [N/µm]", title="Three bearings of 20 mm bore")
axes.legend(title="designation")
axes.grid(alpha=0.3)
figure.savefig("stiffness_of_sizes.png", dpi=100)
