"""What balls that bear load on one raceway alone are off, told by their steps, against a far more exact run."""

import numpy as np
from made_up_run import a_choice

from bearing_twin.kinds.bearing.companion.inherited import ringing_alone
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.stepping.pointing import POINTED
from bearing_twin.run.scene import load_scene

RUNS_UP = ("drive.acceleration=2500", "drive.change={time: 0.02, speed: 90}", "rings.inner.load=[0, -600, 0]")


def test_balls_that_left_the_inner_raceway_are_off_by_as_much_as_that_says(monkeypatch):
    """Within five times, where a ring under 600 N runs up: windows told a sixth of it."""
    parts, found = [], {}
    monkeypatch.setattr(BearingMotion, "_look", lambda self, part: parts.append(part))
    monkeypatch.setattr(
        BearingMotion, "_pointer", lambda self, instants: np.zeros((self.bearing.balls, instants, POINTED))
    )
    for tolerance in (1e-7, 1e-5):
        parts.clear()
        parameters = load_scene("bearing_6203_rig_1000N", (*RUNS_UP, f"wanted.tolerance={tolerance}")).parameters
        times = np.arange(1, 37) / parameters.run.output_rate
        found[tolerance] = BearingMotion(parameters, a_choice("hertz", "rodas4")).advance(times, times[-1])
    exact, out = found.values()
    greatest, coefficient = float(exact.normal_load.max()), parameters.contact.friction_coefficient
    off = np.linalg.norm(out.friction_force - exact.friction_force, axis=-1)
    share = off / (coefficient * np.maximum(exact.normal_load, 0.01 * greatest))
    alone = (exact.normal_load > 0.0).sum(axis=-1) == 1
    told = max(ringing_alone(part, greatest) for part in parts)
    assert 0.2 < told / share[alone].max() < 5.0
