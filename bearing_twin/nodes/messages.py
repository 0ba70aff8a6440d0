"""What the nodes know of ROS messages: classes by type name (`interface`), quality of service, diagnostics.

Importing this module raises MissingInterfacesError, in one sentence, where ROS 2 or our interface package is missing.
"""

from collections.abc import Mapping, Sequence

from bearing_twin.errors import BearingTwinError, MissingInterfacesError
from bearing_twin.log.bag import Qos

try:
    import rclpy
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    from bearing_twin.nodes.interfaces import interface
except ImportError as error:
    raise MissingInterfacesError(
        f"ROS 2 cannot be imported ({error}): run `make setup` and `source env.bash`, or source a ROS 2 Jazzy."
    ) from error
try:
    from bearing_twin_msgs.action import RunStudy
    from bearing_twin_msgs.msg import Contacts  # noqa: F401
    from bearing_twin_msgs.srv import Step, Stiffness
except ImportError as error:
    raise MissingInterfacesError(
        f"the interface package bearing_twin_msgs cannot be imported ({error}): build it with `make setup` and "
        "`source env.bash`, or with colcon and source its install/setup.bash."
    ) from error

__all__ = [
    "QoSProfile", "RunStudy", "Step", "Stiffness", "diagnostics", "fill_stiffness", "interface",
    "qos_profile", "qos_words", "rclpy", "stamp", "suited",
]  # fmt: skip

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
DIAGNOSTICS_PERIOD = 1.0  # s
BURST = 4000  # messages of one topic, or requests to one service, that may wait


def qos_profile(qos: Qos) -> QoSProfile:
    """Quality of service in rclpy's form; `depth` samples are kept."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )


def qos_words(profile: QoSProfile) -> Qos:
    """The inverse of `qos_profile`, also for a profile that discovery reported (its depth is then unknown, 0)."""
    return Qos(profile.depth, profile.reliability.name.lower(), profile.durability.name.lower())


SERVICE = qos_profile(Qos(BURST))  # with the default of 10 most of 30 requests at once are never answered


def burst_profile(qos: Qos) -> QoSProfile:
    """Quality of service of a publisher that may send all messages of a run at once: none is dropped before it arrives.

    What is latched, or sent as best effort, keeps its depth.
    """
    kept = qos.durability == "volatile" and qos.reliability == "reliable"
    return qos_profile(qos._replace(depth=max(qos.depth, BURST)) if kept else qos)


def suited(offered: Sequence[QoSProfile], depth: int) -> QoSProfile:
    """A quality of service that publishers who offer these can serve, with `depth` messages that may wait."""
    reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in offered)
    latched = bool(offered) and all(one.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in offered)
    words = "reliable" if reliable else "best_effort", "transient_local" if latched else "volatile"
    return qos_profile(Qos(depth, *words))


def stamp(time_ns: int) -> Time:
    """A ROS time from integer nanoseconds; raises BearingTwinError for one that it has no seconds for."""
    if not -(1 << 31) <= time_ns // 1_000_000_000 < 1 << 31:
        raise BearingTwinError(f"{time_ns * 1e-9:g} s is no time of ROS, whose seconds end at {(1 << 31) - 1}")
    return Time(sec=time_ns // 1_000_000_000, nanosec=time_ns % 1_000_000_000)


def fill_stiffness(response: Stiffness.Response, sample, point, frame: str) -> Stiffness.Response:
    """The answer of ~/stiffness from an output and its operating point."""
    response.header.stamp, response.header.frame_id = stamp(sample.time_ns), frame
    response.sequence, response.inner_ring_speed = sample.sequence, float(sample["inner_ring_speed"])
    response.coordinates, response.load = point.coordinates, point.loads
    response.stiffness = point.stiffness.ravel()
    response.success, response.message = True, f"at {sample.time_ns * 1e-9:.6f} s"
    return response


def diagnostics(now_ns: int, name: str, level: bytes, message: str, values: Mapping[str, object]) -> DiagnosticArray:
    """One status with `values` as text, stamped with the wall clock."""
    texts = {key: f"{value:.6g}" if isinstance(value, float) else str(value) for key, value in values.items()}
    pairs = [KeyValue(key=key, value=text) for key, text in texts.items()]
    status = DiagnosticStatus(level=level, name=name, message=message, hardware_id="bearing_twin", values=pairs)
    array = DiagnosticArray(status=[status])
    array.header.stamp = stamp(now_ns)
    return array
