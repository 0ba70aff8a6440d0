"""An impact as tests look at it: the channels of a whole run by name, and its figures."""

from bearing_twin import load_scene, simulate
from bearing_twin.base.sample import join_blocks
from bearing_twin.kinds.bodies.impact import ContactPeriod


class SolvedImpact:
    """A run without a second one."""

    def __init__(self, scene, *overrides):
        run = simulate(load_scene(scene, (*overrides, "solver.check=none")))
        block, self.figures = join_blocks(list(run.blocks())), run.report.figures
        self.time, self.values, self.force = 1e-9 * block.time_ns, block.values, block["normal_load"]
        self.contacts = tuple(ContactPeriod(*one.values()) for one in self.figures["contacts"])
        names = "peak_force_n", "greatest_approach_m", "restitution", "energy_closure"
        self.peak_force, self.greatest_approach, self.restitution, self.energy_closure = map(self.figures.get, names)
