"""Errors a user can cause; each message is one sentence that says what to do."""


class BearingTwinError(Exception):
    """Base of every error raised for bad input or a failed run; the command line turns it into exit code 2."""


class SceneError(BearingTwinError):
    """A scene file, scene name or override cannot be used."""


class StudyError(BearingTwinError):
    """A study, one of its uncertain inputs or a way of sampling and propagating them cannot be used."""


class StatisticError(BearingTwinError):
    """A statistic that was asked for does not exist, or cannot be had from the samples there are."""


class LogError(BearingTwinError):
    """A log cannot be read, or may not be written."""


class IntegrationError(BearingTwinError):
    """The integration stopped: `reason` ("not finite", "too deep", "stalled"), at `seconds`, for which `body`.

    Where a method cannot tell, `reason` and `body` are empty and `seconds` is NaN.
    """

    def __init__(self, sentence: str, reason: str = "", seconds: float = float("nan"), body: str = ""):
        super().__init__(sentence)
        self.reason, self.seconds, self.body = reason, seconds, body


class Stopped(BearingTwinError):
    """A computation ended because somebody wanted it to stop; what was given out before is whole."""


class MissingInterfacesError(BearingTwinError):
    """ROS 2 or the interface package bearing_twin_msgs cannot be imported."""
