"""A run goes into a log, comes back bit by bit, and is simulated again to see that it is the same."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from bearing_twin import load_scene, read_log, simulate, write_log

scene = load_scene(
    "bearing_6205", ["run.duration=0.1", "drive.offset=[0.0,-4e-6,0.0]", "materials.ball=silicon_nitride"]
)
Path("ceramic.mcap").unlink(missing_ok=True)  # a log is never overwritten
write_log(simulate(scene), "ceramic.mcap")
log = read_log("ceramic.mcap")
logged = np.concatenate([block.values["normal_load"][:, 0, 1] for block in log.blocks()])  # N, ball 0, outer raceway
again = np.concatenate([block.values["normal_load"][:, 0, 1] for block in simulate(log.scene).blocks()])
steel = load_scene("bearing_6205", ["run.duration=0.1", "drive.offset=[0.0,-4e-6,0.0]"])
steel_load = np.concatenate([block.values["normal_load"][:, 0, 1] for block in simulate(steel).blocks()])

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
times = np.arange(len(logged)) / scene.parameters.run.output_rate * 1e3  # ms
axes.plot(times, logged, linewidth=3, alpha=0.4, label="silicon nitride, from the log")
axes.plot(times, again, linewidth=1, label="silicon nitride, simulated again")
axes.plot(times, steel_load, linewidth=1, label="steel")
axes.set(
    xlabel="time [ms]", ylabel="load of ball 0 on the outer raceway [N]", title="A 6205 with balls of two materials"
)
axes.legend()
figure.savefig("log_and_verify.png", dpi=100)
print(f"the log and the new run differ by {np.abs(logged - again).max():g} N")
