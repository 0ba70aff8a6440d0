"""What a simulation is told while it runs, and asked where it stands: checked by its kind, then obeyed."""

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.sample import Sample
from bearing_twin.kinds.contract import OperatingPoint


class Commanded:
    """The commands of a `Simulation`, which has scene, kind, choice, motion, and `_to_last_output`."""

    def set_speed(self, speed: float) -> None:
        """New goal [rad/s] for the speed of inner ring or shaft, approached at the drive's acceleration from now on.

        Raises BearingTwinError, and changes nothing, where the load is not carried at this speed, or a torque turns it.
        """
        if self.kind.check_drive is not None:
            self.kind.check_drive(self.scene.parameters, self.choice.law, "speed", float(speed), self._load)
        self._to_last_output()
        self._motion.goal_speed = float(speed)

    def set_torque(self, torque: float) -> None:
        """New torque [N m] on the inner ring about +z; raises BearingTwinError where the speed is prescribed."""
        self._refuse_without(self.kind.check_drive, "torque")
        self.kind.check_drive(self.scene.parameters, self.choice.law, "torque", float(torque), self._load)
        self._to_last_output()
        self._motion.set_torque(float(torque))

    def set_load(self, force, moment) -> None:
        """New force (3,) [N] and moment (2,) or (3,) [N m] on the inner ring or the shaft, from now on.

        None for both: the scene's own. Raises BearingTwinError, and changes nothing, for what the scene cannot carry.
        """
        if force is not None:
            self._refuse_without(self.kind.check_load, "load")
            self.kind.check_load(self.scene.parameters, self.choice.law, self._motion.goal_speed, force, moment)
        self._to_last_output()
        self._load = force, moment
        self._motion.set_load(force, moment)

    def operating_point(self) -> tuple[Sample, OperatingPoint]:
        """The last output given out, or the first, with loads and stiffness there; raises BearingTwinError."""
        self._refuse_without(self.kind.operating_point, "stiffness")
        sample = (self._begun() if self._given is None else self._given)[-1]
        return sample, self.kind.operating_point(self.scene.parameters, self.choice.law, sample)

    def _refuse_without(self, part, word: str) -> None:
        if part is None:
            raise BearingTwinError(f"a scene of the kind {self.kind.name} has no {word}; a bearing has")
