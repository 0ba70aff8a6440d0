"""What the axes of a channel are called and what stands along them: balls, races, x, y, z."""

from typing import NamedTuple

from bearing_twin.base.sample import Channel
from bearing_twin.kinds import KINDS

LABELS = {
    "axis": ("x", "y", "z"),
    "quaternion": ("x", "y", "z", "w"),
    "about": ("x", "y"),
    "in_plane": ("x", "y"),
}
"""What stands along an axis of this name; along others stand whole numbers from 0."""


class ChannelAxis(NamedTuple):
    """An axis of a channel: its name, and a label for each place along it."""

    name: str
    labels: tuple[str | int, ...]


def axes_of(channel: Channel, kind: str | None) -> tuple[ChannelAxis, ...]:
    """The axes of a channel's shape: as the channel declares them, else by the bodies and contacts of the kind.

    An axis along which `Kind.place_of` names other bodies is called by their first word and labelled by number, one
    along which it names other contacts is `contact`. Of the rest one of length 3 is `axis`, one of length 4 a
    `quaternion`. Without a scene `kind` is None, and axes are called by their channel.
    """
    return tuple(_axis(channel, kind, place) for place in range(len(channel.shape)))


def _axis(channel: Channel, kind: str | None, place: int) -> ChannelAxis:
    size = channel.shape[place]
    if channel.axes:
        return _labelled(channel.axes[place], size)
    if kind is None:
        return _labelled(f"{channel.name}_{place}", size)
    bodies, contacts = zip(
        *(KINDS[kind].place_of(channel, _index(channel, place, k)) for k in range(size)), strict=True
    )
    if size > 1 and len(set(contacts)) == size:
        return ChannelAxis("contact", contacts)
    if bodies[0][-1:].isdigit() and len(set(bodies)) == size:
        return ChannelAxis(bodies[0].split()[0], tuple(range(size)))
    return _labelled({3: "axis", 4: "quaternion"}.get(size, f"{channel.name}_{place}"), size)


def _index(channel: Channel, place: int, k: int) -> tuple[int, ...]:
    return tuple(k if one == place else 0 for one in range(len(channel.shape)))


def _labelled(name: str, size: int) -> ChannelAxis:
    labels = LABELS.get(name, ())
    return ChannelAxis(name, labels if len(labels) == size else tuple(range(size)))
