"""Classes of messages, services and actions, by the names of their types.

Such a name may come from a log or from anybody on the network, and to import a module is to run it.
"""

import importlib
import re
import sys

from ament_index_python import get_resource

from bearing_twin.errors import BearingTwinError, MissingInterfacesError
from bearing_twin.spelling import echo, harmless, unknown

INDEX = "rosidl_interfaces"  # where packages of interfaces that are installed are listed
_TYPE = re.compile(r"([a-z]\w*)/(?:(\w+)/)?([A-Z]\w*)", flags=re.ASCII)


class InterfaceError(BearingTwinError):
    """What was given is no name of a type, or of none in its package."""


def interface(ros_type: str, group: str) -> type:
    """The class of a type such as `std_srvs/srv/SetBool`, for short `std_srvs/SetBool`; `group`: msg, srv or action.

    Raises InterfaceError for what is no name of a type, or of none in its package, MissingInterfacesError for a package
    that ROS does not list as one of interfaces, or that cannot be imported: no other is.
    """
    found = _TYPE.fullmatch(ros_type)
    if not found or found[2] not in (None, group):
        raise InterfaceError(f"{echo(ros_type)} is no type of this group; write package/{group}/Name")
    package, _, name = found.groups()
    module = f"{package}.{group}"
    try:
        if module not in sys.modules:
            get_resource(INDEX, package)
        home = importlib.import_module(module)
    except (LookupError, OSError, ImportError) as error:
        raise MissingInterfacesError(
            harmless(f"the type {package}/{group}/{name} cannot be imported ({error}): install or source its package")
        ) from error
    kind = getattr(home, name, None)
    if not isinstance(kind, type):
        names = [one for one, value in vars(home).items() if isinstance(value, type)]
        raise InterfaceError(f"{package} has no {group} {echo(name)}; {unknown(name, names)}")
    return kind
