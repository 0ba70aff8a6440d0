"""Whether what studies tell of the error of the method holds: `python bench/study_errors.py [part of a scene ...]`.

Companions go with some realisations of a study, and what they find stands for all. Here every realisation is repeated
at a tolerance of 1e-6. Printed is, of each quantity in its unit, its deviation, the greatest error of all
realisations, that below which 95 % of them err, and what the study tells. By one worker, with the seed of each study.
"""

import sys
from datetime import date

import numpy as np

from bearing_twin import load_scene, parse_study, run_study

SAMPLES, EXACT = 200, 1e-6
QUANTITIES = "greatest_ball_load", "greatest_pressure", "cage_speed", "roll_rate", "dissipated_energy", "drive_torque"
STUDIES = {  # scene, further changes: duration [s]
    ("bearing_6203",): 0.06,
    ("bearing_6203", "initial.motion=rest"): 0.02,
    ("bearing_6203_loose",): 0.06,
    ("bearing_6203_loose", "wanted.tolerance=0.01"): 0.06,
    ("bearing_6203_loose", "contact.friction=spot"): 0.03,
    ("bearing_6203_loose", "drive.offset=[0, -9e-6, 2e-5]"): 0.06,
    ("bearing_6203_sudden",): 0.05,
    ("bearing_6203_sudden", "wanted.tolerance=0.01"): 0.03,
    ("bearing_6203_step_load",): 0.1,
    ("bearing_6203_run_up",): 0.05,
    ("bearing_6203_fast",): 0.05,
    ("bearing_6203_start",): 0.1,
    ("bearing_6203_tilted",): 0.06,
    ("bearing_6203_sticking",): 0.02,
    ("bearing_6205",): 0.06,
    ("bearing_6203_rig_400N",): 0.05,
    ("bearing_6203_rig_400N", "cage.kind=even"): 0.05,
    ("bearing_6203_unbalance",): 0.06,
    ("bearing_6203_load_and_speed",): 0.06,
    ("bearing_6203_guided_cage",): 0.05,
}


def study_of(scene, changes, duration, *overrides):
    """The study of a scene whose clearance, ball diameter and friction (or gravity, without friction) are uncertain."""
    at = load_scene(scene, changes).parameters
    ranges = {
        "geometry.radial_clearance": (at.geometry.radial_clearance, 2e-6),
        "geometry.ball_diameter": (at.geometry.ball_diameter, 1e-6),
    }
    friction = at.contact.friction_coefficient
    ranges |= {"contact.friction_coefficient": (friction, 0.4 * friction)} if friction else {"gravity[0]": (0.0, 1.0)}
    mapping = {
        "scene": scene,
        "set": [f"run.duration={duration}", "run.output_rate=2000", "run.publish_rate=1000", *changes],
        "inputs": {
            key: {"distribution": "uniform", "low": middle - half, "high": middle + half}
            for key, (middle, half) in ranges.items()
        },
        "quantities": list(QUANTITIES),
        "samples": SAMPLES,
        "workers": 1,
        "modality": "no",
    }
    return parse_study(mapping, "study", list(overrides))


def judged(scene, changes, duration):
    """(deviation, greatest error, that of 95 %, what is told) of each quantity."""
    own = run_study(study_of(scene, changes, duration))
    true = run_study(study_of(scene, [*changes, f"wanted.tolerance={EXACT:g}"], duration, "companions=0"))
    off = np.abs(own.quantities - true.quantities)
    for column, name in enumerate(QUANTITIES):
        error = own.summary["quantities"][name]["errors_by_source"].get("method", np.nan)
        yield np.nanstd(true.quantities[:, column]), *np.nanquantile(off[:, column], (1.0, 0.95)), error


def main(*parts):
    """Every study, or those whose names have one of the parts."""
    found = []
    print(f"{SAMPLES} realisations a study, {date.today()}; deviation, greatest error, that of 95 %, told")
    for (scene, *changes), duration in STUDIES.items():
        if parts and not any(part in scene for part in parts):
            continue
        print(" ".join((scene, *changes)), flush=True)
        for name, row in zip(QUANTITIES, judged(scene, changes, duration), strict=True):
            print(f"  {name:20}" + "".join(f"{number:12.2g}" for number in row), flush=True)
            found.append(row)
    _, greatest, most, told = np.transpose(found)
    for words, error in (("greatest error", greatest), ("error of 95 %", most)):
        print(f"what is told is above the {words} in {np.sum(told >= error)} of {len(told)} quantities")


if __name__ == "__main__":
    main(*sys.argv[1:])
