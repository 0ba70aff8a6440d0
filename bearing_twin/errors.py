"""Errors a user can cause; each message is one sentence that says what to do."""


class BearingTwinError(Exception):
    """Base of every error raised for bad input or a failed run; the command line turns it into exit code 2."""


class SceneError(BearingTwinError):
    """A scene file, scene name or override cannot be used."""


class StudyError(BearingTwinError):
    """A study file, study name, override or input distribution cannot be used, or asks for too much."""


class LogError(BearingTwinError):
    """A log cannot be read, or may not be written."""


class IntegrationError(BearingTwinError):
    """The integration stopped: non-finite state, step refused, or bodies through each other."""


class MissingInterfacesError(BearingTwinError):
    """ROS 2 or the interface package bearing_twin_msgs cannot be imported."""
