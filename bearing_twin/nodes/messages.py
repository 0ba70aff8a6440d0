"""ROS messages: classes by type name (`interface`), quality of service, conversion to and from data.

Importing this module raises MissingInterfacesError, in one sentence, where ROS 2 or our interface package is missing.
"""

import importlib
import re
import sys
from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bearing_twin.base.errors import BearingTwinError, MissingInterfacesError, echo, escape_controls, legal_hint
from bearing_twin.base.parameters import read_number
from bearing_twin.log.bag import Qos

try:
    import rclpy  # noqa: F401
    from ament_index_python import get_resource
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticStatus
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
    from rosidl_parser.definition import AbstractNestedType, BasicType, NamespacedType
except ImportError as error:
    raise MissingInterfacesError(
        f"ROS 2 cannot be imported ({error}): run `make setup` and `source env.bash`, or source a ROS 2 Jazzy."
    ) from error
try:
    from bearing_twin_msgs.action import RunStudy  # noqa: F401
    from bearing_twin_msgs.srv import Step, Stiffness  # noqa: F401
except ImportError as error:
    raise MissingInterfacesError(
        f"the interface package bearing_twin_msgs cannot be imported ({error}): build it with `make setup` and "
        "`source env.bash`, or with colcon and source its install/setup.bash."
    ) from error

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
DIAGNOSTICS_PERIOD = 1.0  # s
BURST = 4000  # messages of one topic, or requests to one service, that may wait


def qos_profile(qos: Qos) -> QoSProfile:
    """Quality of service as a profile of rclpy."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )


def qos_of(profile: QoSProfile) -> Qos:
    """The inverse of `qos_profile`, also for a profile that discovery reported (its depth is then unknown, 0)."""
    return Qos(profile.depth, profile.reliability.name.lower(), profile.durability.name.lower())


SERVICE = qos_profile(Qos(BURST))  # with the default of 10 most of 30 requests at once are never answered


def burst_profile(qos: Qos) -> QoSProfile:
    """Quality of service of a publisher that may send all messages of a run at once: none is dropped before it arrives.

    What is latched, or sent as best effort, keeps its depth.
    """
    keeps_all = qos.durability == "volatile" and qos.reliability == "reliable"
    return qos_profile(qos._replace(depth=max(qos.depth, BURST)) if keeps_all else qos)


def compatible_profile(offered: Sequence[QoSProfile], depth: int) -> QoSProfile:
    """A quality of service that publishers who offer these can serve, with `depth` messages that may wait."""
    reliable = bool(offered) and all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = bool(offered) and all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    policies = "reliable" if reliable else "best_effort", "transient_local" if latched else "volatile"
    return qos_profile(Qos(depth, *policies))


def stamp(time_ns: int) -> Time:
    """A ROS time from integer nanoseconds; raises BearingTwinError for one that it has no seconds for."""
    if not -(1 << 31) <= time_ns // 1_000_000_000 < 1 << 31:
        raise BearingTwinError(f"{time_ns * 1e-9:g} s is not a time of ROS, whose seconds end at {(1 << 31) - 1}")
    return Time(sec=time_ns // 1_000_000_000, nanosec=time_ns % 1_000_000_000)


INDEX = "rosidl_interfaces"  # where packages of interfaces that are installed are listed
_TYPE = re.compile(r"([a-z]\w*)/(?:(\w+)/)?([A-Z]\w*)", flags=re.ASCII)


class InterfaceError(BearingTwinError):
    """The name of a type is malformed, or unknown in its package."""


def interface(ros_type: str, group: str) -> type:
    """The class of a type such as `std_srvs/srv/SetBool`, for short `std_srvs/SetBool`; `group`: msg, srv or action.

    Raises InterfaceError for what is no name of a type, or of none in its package, MissingInterfacesError for a package
    that ROS does not list as one of interfaces, or that cannot be imported: no other is.
    """
    match = _TYPE.fullmatch(ros_type)
    if not match or match[2] not in (None, group):
        raise InterfaceError(f"{echo(ros_type)} is not a type of this group; write package/{group}/Name")
    package, _, name = match.groups()
    module = f"{package}.{group}"
    try:
        if module not in sys.modules:
            get_resource(INDEX, package)
        home = importlib.import_module(module)
    except (LookupError, OSError, ImportError) as error:
        raise MissingInterfacesError(
            escape_controls(
                f"the type {package}/{group}/{name} cannot be imported ({error}): install or source its package"
            )
        ) from error
    kind = getattr(home, name, None)
    if not isinstance(kind, type):
        names = [key for key, value in vars(home).items() if isinstance(value, type)]
        raise InterfaceError(f"{package} has no {group} {echo(name)}; {legal_hint(name, names)}")
    return kind


FLOATS = ("float", "double", "long double")


class MessageError(BearingTwinError):
    """The data do not fit the type of a message."""


def plain_data(message, limit: int | None = None) -> Any:
    """A message as mappings, lists, numbers and text; of arrays longer than `limit` the first items and ..."""
    if hasattr(message, "get_fields_and_field_types"):
        return {name: plain_data(getattr(message, name), limit) for name in message.get_fields_and_field_types()}
    if isinstance(message, bytes):
        return message[0] if len(message) == 1 else list(message)
    if isinstance(message, (array, np.ndarray, list, tuple)):
        shown = message if limit is None else message[:limit]
        values = shown.tolist() if hasattr(shown, "tolist") else [plain_data(item, limit) for item in shown]
        return values if len(shown) == len(message) else [*values, "..."]
    return message


def message_from(message_class: type, data: Any, path: str = "") -> Any:
    """A message of this class with the fields that `data` names, the others at their defaults.

    Raises MessageError with the field and what it must be. A whole number is accepted where a real one is meant.
    """
    types = dict(zip(message_class.get_fields_and_field_types(), message_class.SLOT_TYPES, strict=True))
    name_shown = path or message_class.__name__
    if not isinstance(data, Mapping | None):
        such = ", ".join(f"{name}: ..." for name in types)
        raise MessageError(f"{name_shown} = {echo(data)} must be fields with values, as {{{such}}}")
    fields = {}
    for name, value in (data or {}).items():
        if name not in types:
            hint = "write a space behind the colon" if ":" in str(name) else legal_hint(name, types)
            raise MessageError(f"{name_shown} has no field {echo(name)}; {hint}")
        fields[name] = _field_value(types[name], value, f"{path}.{name}" if path else str(name))
    try:
        return message_class(check_fields=True, **fields)
    except AssertionError as error:
        raise MessageError(f"{name_shown}: {error}") from error


def _field_value(kind, value: Any, path: str) -> Any:
    """The value of a field of this type, converted from `value`; other types are refused by the message itself."""
    if isinstance(kind, NamespacedType):
        return message_from(interface(f"{'/'.join(kind.namespaces)}/{kind.name}", kind.namespaces[-1]), value, path)
    if isinstance(kind, AbstractNestedType) and isinstance(value, list):
        return [_field_value(kind.value_type, item, f"{path}[{index}]") for index, item in enumerate(value)]
    if not isinstance(kind, BasicType) or isinstance(value, bool | float) or kind.typename == "boolean":
        return value
    number, problem = read_number(value, integer=kind.typename not in FLOATS)  # to YAML 2e-3 is a text
    if problem:
        raise MessageError(f"{path} = {echo(value)} {problem}")
    if kind.typename == "octet":
        return bytes([number]) if 0 <= number < 256 else value
    return number
