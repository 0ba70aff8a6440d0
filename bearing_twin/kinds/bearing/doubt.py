"""What a bearing's figures are worth: of the method by its companion, of law, friction model and what is left out."""

import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bearing.adequacy import mend_of_method, told_of_equilibria
from bearing_twin.kinds.bearing.companion.growth import Growth, greatest_until
from bearing_twin.kinds.bearing.companion.means import MeanError
from bearing_twin.kinds.bearing.companion.pointers import dearest
from bearing_twin.kinds.bearing.companion.windows import WINDOW, carries, unseen
from bearing_twin.kinds.bearing.companion.worst import TOGETHER, Spread, Worst, spread_of
from bearing_twin.kinds.bearing.forces.drilling import SIDES, Drilled, drilling_of
from bearing_twin.kinds.bearing.friction_choice import as_chosen
from bearing_twin.kinds.bearing.law_error import half_space_error, law_error, spots_off
from bearing_twin.kinds.bearing.left_out import left_out, of_torque, unknown_drilling
from bearing_twin.kinds.bearing.load_error import by_load
from bearing_twin.kinds.bearing.parameters import LOADS, BearingScene
from bearing_twin.kinds.bearing.quasi_static.worth import LOADS_OF, SceneWorth, Worth, worths_of_run
from bearing_twin.kinds.bearing.rings import FREE_RING, QUASI_STATIC, dimension_of, spots_built
from bearing_twin.kinds.bearing.spot_errors import rule_error
from bearing_twin.kinds.bearing.still import EQUILIBRIA, friction_of_equilibria
from bearing_twin.kinds.bearing.summing import STRETCH, turning
from bearing_twin.kinds.bearing.tilt_error import Tilted, added
from bearing_twin.kinds.doubt import FRICTION_MODEL, HERTZ_MENDS, LATER, LAW, LEFT_OUT, METHOD, Errors, Promise
from bearing_twin.report import Choice
from bearing_twin.sample import Block

LEAST_TOLD = 3e-9  # of friction: differences of positions are rounded, and truths are no better known
EITHER_WAY = 2.0  # times what friction can be, mu N of the greater load: the most that it is off
AROUND = 1.0  # rad or so lie between the greatest load and the least: a ball that is off further is off by no more load
TILTING = "ring_moment_nm", "misalignment_rad"
SUMS = {"drive_work_j": "drive_torque_nm", "dissipated_j": "drive_torque_nm"}  # over the angle that the ring turns
STANDS = 1e-12  # rad/s: a ring that turns no faster stands, and work over its angle says nothing of a torque
THEORY = "cage_speed_theory_rad_s", "roll_rate_theory_rad_s"
OUT_OF_PLANE = "ring_moment_nm", *(f"contact_angle_{side}_rad" for side in SIDES)  # all 0: the motion is a plane one


class BearingDoubt:
    """Gathers what a run's errors follow from, in memory that does not grow with the run."""

    in_stretches = False  # blocks may hold many
    errorless = "inner_ring_speed_at_end_rad_s", *THEORY, "energy_closure", "equilibria", "catalogue_drive_torque_nm"

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.choice = as_chosen(parameters, choice), choice
        balls = parameters.geometry.balls
        self.worst = Worst()
        self.outputs = 0
        self.least = math.inf  # load of a ball [N]
        self.growth = Growth(parameters.wanted.tolerance, parameters.wanted.outputs == LOADS)
        self.mean, self.tilted = MeanError(), Tilted(balls)
        self.load = np.zeros((balls, 2))
        self.curvatures = np.ones((2, balls, 2))
        self.spin = np.zeros((balls, 2))  # greatest under load
        self.rubbed = np.zeros((balls, 2))  # sums of load^(4/3) times spin

    def add(self, block: Block) -> None:
        """Takes a block in."""
        load = np.ascontiguousarray(block.values["normal_load"])
        begins = np.array([0, *range(STRETCH - block.first_sequence % STRETCH, len(block), STRETCH)])
        self.least = min(self.least, float(load.min()))
        self._note_windows(block, load, begins)
        self.outputs += len(block)
        spin = np.where(load > 0.0, np.abs(block.values["spin_rate"]), 0.0)
        self.spin = np.maximum(self.spin, spin.max(axis=0))
        rubbed = np.add.reduceat(load * np.cbrt(load) * spin, begins, axis=0)
        for stretch in rubbed:  # one after the other: sums are the same to the bit however outputs are cut
            self.rubbed += stretch
        better = load.max(axis=0) > self.load
        at = load.argmax(axis=0)[better], *np.nonzero(better)
        self.tilted.add(block, better, at)
        if better.any():
            self.load[better] = load[at]
            for kept, name in zip(self.curvatures, ("curvature_small", "curvature_large"), strict=True):
                kept[better] = block.values[name][at]

    def _note_windows(self, block: Block, load, begins) -> None:
        """Takes in what a companion found; loads count up to the end of the stretch in which a window ends."""
        rows = block.records.get(WINDOW.name, ())
        if not len(rows) or rows.shape[1] != len(WINDOW.columns):  # a log of an earlier version
            return
        for row, most in zip(rows, greatest_until(rows, self.load.max(), block.time_ns, load, begins), strict=True):
            self.mean.add(row)
            self.growth.add(row, most)
            self.worst.add(row)

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The errors of these figures so far."""
        law = law_error(self.parameters, self.choice.law, *self.curvatures, self.load)
        law, found, still = None if law is None else np.abs(law), {}, self._still
        balls = self.parameters.geometry.balls
        more = still.by_friction(balls) if still else {}
        width = np.array([half_space_error(self.parameters, figures[f"semi_major_{side}_m"]) for side in SIDES]).T
        for source, errors in (
            (METHOD, self._method(figures)),
            (LAW, {} if law is None else self._by_load(figures, law, LAW)),
            (LEFT_OUT, added(self._by_load(figures, width, LEFT_OUT), self._tilting(figures), more)),
            (FRICTION_MODEL, still.by_axes(balls) if still else self._friction(figures)),
        ):
            for key, error in errors.items():
                found.setdefault(key, {})[source] = error
        if not any(map(any, (figures[key] for key in OUT_OF_PLANE))):
            found |= {key: {source: [0.0, 0.0] for source in found[key]} for key in TILTING if key in found}
        mends = {LAW: HERTZ_MENDS, METHOD: self._mend()}
        if self.choice.stepper == QUASI_STATIC:
            mends[FRICTION_MODEL] = self._smaller_steps
        elif not FRICTIONS[self.parameters.contact.friction].over_spot and spots_built(self.parameters):
            mends[FRICTION_MODEL] = "set contact.friction: spot, which computes the drilling that a point does not hold"
        spent = dearest(self.worst.rows["steps"], balls)
        horizon, wanted = self.growth.horizon, self.parameters.wanted.tolerance * float(self.load.max())
        # What is left for the ring is a difference of loads, which err by as much as is wanted.
        spared = {"ring_force_n": wanted, "ring_moment_nm": 0.5 * self.parameters.geometry.pitch_diameter * wanted}
        return Errors(found, self._promises(law, horizon), self._notes(), mends, spent, horizon, SUMS, spared)

    @property
    def _known(self) -> bool:
        return self.worst.windows > 0

    @property
    def _inherited(self) -> float:
        """How many times what windows of all balls see the motion may be off: 1 where both raceways carry all balls.

        Then nothing bumps, and what a ball is off is forgotten as it rolls.
        """
        return 1.0 if self.least > 0.0 else unseen(self.parameters)

    def _seen(self, name: str, worst: Worst | None = None, spread: Spread | None = None) -> float:
        """The greatest error of the method in a quantity, of all windows or those in `worst`; with its `spread`."""
        # Up to a horizon windows that are followed show what bumps make of errors: that is how it was found.
        worst, inherited = (worst, 1.0) if worst else (self.worst, self._inherited)
        if name != "load":
            return min(worst.seen(name, inherited, self.least <= 0.0, spread), self._most.get(name, math.inf))
        # Bumps into a cage drive balls round, not against a held ring.
        held = dimension_of(self.parameters) != FREE_RING
        seen = worst.seen(name, 1.0 if held else inherited, self.least <= 0.0, spread)
        # Between the greatest load and the least a ball goes a radian or so: what a jump or a bounce does is no slope.
        around = min(worst.seen("orbit_angle", inherited, False), AROUND)
        return seen + around * (float(self.load.max()) - self.least)

    @property
    def _most(self) -> dict[str, float]:
        """What physics bounds: a contact rubs with mu N at most, in the run one way, in truth perhaps the other."""
        rubs = self.parameters.contact.friction_coefficient * 0.5 * self.parameters.geometry.ball_diameter
        return {"friction": EITHER_WAY, "torque": EITHER_WAY * rubs * float(self.load.sum(axis=1).max())}

    def _method(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of the method by figure; one that no window saw is missing."""
        if not self._known:
            return {}
        seen = {column.name: self._seen(column.name) for column in WINDOW.columns}
        balls, pitch = self.parameters.geometry.balls, self.parameters.geometry.pitch_diameter
        share = np.divide(seen["load"], self.load, out=np.zeros_like(self.load), where=self.load > 0.0)
        torque = balls * seen["drive_torque"]
        free = dimension_of(self.parameters) == FREE_RING
        # what touches nothing bears exactly nothing
        bears = dict(zip(SIDES, (self.load.max(axis=0) > 0.0).astype(float).tolist(), strict=True))
        ring = seen["ring_force"] or bears["inner"] * balls * seen["load"]
        turned = torque * abs(figures["inner_ring_speed_at_end_rad_s"])
        moved = seen["ring_displacement"] if free else 0.0
        return {
            **spots_off(figures, share),
            **{f"{key}_{side}_n": [bears[side] * seen["load"]] * balls for key in LOADS_OF for side in SIDES},
            **{f"contact_angle_{side}_rad": [seen["contact_angle"]] * balls for side in SIDES},
            "cage_speed_rad_s": turning(self.parameters, seen["orbit_speed"]),
            "roll_rate_rad_s": turning(self.parameters, seen["roll_rate"]),
            "drive_work_j": turned * self._seconds + moved * math.hypot(*figures["ring_force_n"]),
            **of_torque(self.parameters, figures, torque, self._seconds),
            "dissipated_j": balls * seen["loss"] * self._seconds,
            "ring_displacement_m": [moved] * 3,
            # A tilt is integrated as exactly as the displacement that it makes at the balls.
            "misalignment_rad": [moved / (0.5 * pitch)] * 2,
            "ring_force_n": [ring] * 3,
            "ring_moment_nm": [0.5 * ring * pitch] * 2,
            "friction_torque_nm": [self.mean.over(0.5 * self._seconds, self._inherited, seen["torque"])] * balls,
        }

    @property
    def _given(self) -> bool:
        """Whether the loads of the ring are given, not its place."""
        return dimension_of(self.parameters) in (QUASI_STATIC, FREE_RING)

    @property
    def _seconds(self) -> float:
        return max(self.outputs - 1, 0) / self.parameters.run.output_rate

    @functools.cached_property
    def _equilibria(self) -> list[SceneWorth]:
        return worths_of_run(self.parameters, self.choice.law)

    def _nearest(self) -> SceneWorth | None:
        """The equilibrium whose greatest load is nearest to the run's; None where there is none."""
        return min(self._equilibria, key=lambda one: abs(one.greatest - float(self.load.max())), default=None)

    def _worth(self, source: str) -> Worth | None:
        """What an error of contacts does to the nearest equilibrium; None where none stands for the run."""
        nearest = self._nearest()
        return nearest.of(source, float(self.load.max())) if nearest else None

    @property
    def _still(self) -> SceneWorth | None:
        """The equilibrium that a run from equilibria is nearest to; None of other runs."""
        return self._nearest() if self.choice.stepper == QUASI_STATIC else None

    def _tilting(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of figures where the ring is tilted: as the equilibrium answers where one stands for the run."""
        geometry, nearest = self.parameters.geometry, self._nearest()
        if self._still:
            return self._still.by_tilt(geometry.balls)
        moving = self.tilted.errors(geometry, figures, self.load, self._given)
        stands = nearest and nearest.alike(float(self.load.max()))
        return moving | nearest.by_tilt(geometry.balls) if stands else moving

    def _by_load(self, figures: Mapping[str, Any], share: np.ndarray, source: str) -> dict[str, Any]:
        """Errors of figures where contacts are off by these shares (N, 2) of their load at the same approach."""
        return by_load(self.parameters.geometry, figures, self.load, share, self._worth(source), self._given)

    def _friction(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of the friction model: at a point it holds no drilling; over a spot it is off by its quadrature."""
        if dimension_of(self.parameters) == QUASI_STATIC or not self.outputs:
            return {}
        met = Drilled(self.load, self.curvatures, self.spin, self.rubbed / self.outputs)
        contact, speed = self.parameters.contact, abs(figures["inner_ring_speed_at_end_rad_s"])
        off = functools.partial(rule_error, contact) if FRICTIONS[contact.friction].over_spot else None
        most, power = drilling_of(contact, met, figures, off)
        found = {
            "dissipated_j": power * self._seconds,
            "drive_work_j": power * self._seconds,
            "friction_torque_nm": most.tolist(),
        }
        return found | (of_torque(self.parameters, figures, power / speed, self._seconds) if speed > STANDS else {})

    def _promises(self, law: np.ndarray | None, horizon: float | None) -> tuple[Promise, ...]:
        """What is wanted: loads, and friction unless loads alone are; up to the run's horizon [s] as well."""
        wanted, greatest = self.parameters.wanted, float(self.load.max())
        still = self.choice.stepper == QUASI_STATIC
        worth = self._worth(LAW)
        off = 0.0 if law is None else float((law * self.load).max(initial=0.0)) / greatest if greatest else 0.0
        off *= 1.0 if worth is None else worth.kept
        method = self._seen("load") / greatest if self._known and greatest else self._of_equilibria
        whole = None if method is None else method + off
        mend = self._mend() if method is not None and method >= off else HERTZ_MENDS
        norm, earlier = "over the greatest load", None if horizon is None else self.worst.until(horizon)
        before = self._seen("load", earlier) / greatest + off if earlier and greatest else None
        spread = spread_of(self.least <= 0.0, carries(self.parameters))
        may = self._seen("load", spread=spread) / greatest + off if self._known and greatest else None
        loads = Promise("loads", norm, whole, wanted.tolerance, self.worst.where("load"), mend, before, may)
        if wanted.outputs == LOADS or not self.parameters.contact.friction_coefficient:
            return (loads,)
        norm = "over mu N of a contact, or mu N R of a ball"
        if still:
            known = friction_of_equilibria(self.parameters, self.choice.law)
            return loads, Promise("friction", norm, known, wanted.tolerance, "", self._smaller_steps)
        error = may = None
        if self._known:
            error, may = (max(self._seen("friction", spread=one), LEAST_TOLD) for one in (None, spread))
        place = self.worst.where("friction")
        before = max(self._seen("friction", earlier), LEAST_TOLD) if earlier else None
        return loads, Promise("friction", norm, error, wanted.tolerance, place, self._mend(), before, may)

    def _mend(self) -> str:
        """What makes the method's error smaller."""
        return LATER if self.growth.grown else self._smaller_steps

    @functools.cached_property
    def _of_equilibria(self) -> float | None:
        return told_of_equilibria(self.parameters, self.choice)

    @functools.cached_property
    def _smaller_steps(self) -> str:
        return mend_of_method(self.parameters, self.choice)

    def _notes(self) -> dict[str, str]:
        """What is not known, by source and by what is left out."""
        notes = {}
        if self.choice.stepper == QUASI_STATIC:
            notes[METHOD] = EQUILIBRIA
        elif self.parameters.solver.companion == "off":
            notes[METHOD] = "solver.companion: off, so nothing is known of the error of the integration method"
        elif not self._known:
            notes[METHOD] = "the run holds no window of a companion, so the error of its integration is not known"
        elif self.worst.most[TOGETHER].any() and self._inherited > 1.0:
            notes[METHOD] = (
                f"balls touch, or bump into a cage: {self._inherited:g} times what windows show stands for what they "
                "inherit"
            )
        elif carries(self.parameters):
            notes[METHOD] = "what a moving ring carries on is taken to add up as a random walk does while it rings"
        if self.choice.law in LAWS and LAWS[self.choice.law].measured:
            notes[LAW] = f"the law {self.choice.law} is given by the scene; nothing is known of its error"
        if drilling := unknown_drilling(self.parameters):
            notes[FRICTION_MODEL] = drilling
        return notes | self.growth.notes | left_out(self.parameters)
