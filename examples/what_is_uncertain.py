"""Two spheres whose contact was measured with a deviation: what is known of the contact time?"""

import matplotlib.pyplot as plt

from bearing_twin import load_study, run_study

result = run_study(load_study("spheres_alpha_4e-5", ["samples=2000", "workers=1"]))
duration = result.as_dict()["quantities"]["contact_duration"]
times = result.sample("contact_duration") * 1e6  # µs

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
axes.hist(times, bins=60, color="0.75")
for name, quantile in duration["quantiles"].items():
    axes.axvspan(quantile["low"] * 1e6, quantile["high"] * 1e6, color="tab:blue", alpha=0.4)
    axes.text(quantile["value"] * 1e6, axes.get_ylim()[1], f" {name}", rotation=90, va="top", fontsize="small")
axes.set(xlabel="contact time [µs]", ylabel="realisations", title="Quantiles with their 95 % intervals")
figure.savefig("what_is_uncertain.png", dpi=100)
print(
    f"mean {duration['mean'] * 1e6:.1f} µs, 95 % interval {[round(end * 1e6, 1) for end in duration['mean_interval']]}"
)
