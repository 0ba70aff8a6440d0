"""Two bodies in one contact, as all kinds but bearings have them: the topics and markers of that contact."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.kinds.contract import Topic
from bearing_twin.kinds.markers import ELLIPSE_SCALE, GREEN, LINE_LIST, RED, TEXT, crossed, marker, outlines
from bearing_twin.kinds.topics import NUMBERS, VECTORS, SolidsOf, body_topics, contacts_topic

ZERO = np.zeros(3)


class ContactPair(NamedTuple):
    """One contact at one output, in SI and the axes of the scene.

    Wrenches are taken about `position` of the first body and `second_position`; `normal` is outward of the first body.
    Friction force and spin friction moment (`drilling_torque`, about the normal) act on the first body; `slip` and
    `spin_rate` are those of the first body against the second.
    """

    position: np.ndarray
    second_position: np.ndarray
    contact_point: np.ndarray
    normal: np.ndarray
    approach: float
    normal_load: float
    semi_major: float
    semi_minor: float
    peak_pressure: float
    major_axis: np.ndarray
    friction_force: np.ndarray = ZERO
    slip: np.ndarray = ZERO
    drilling_torque: float = 0.0
    spin_rate: float = 0.0

    def wrenches(self, one: str, other: str) -> list[Wrench]:
        """On each body by the other, of load, friction and spin friction."""
        force, spun = self.friction_force - self.normal_load * self.normal, self.drilling_torque * self.normal
        torque = crossed(self.contact_point - self.position, force) + spun
        back = crossed(self.contact_point - self.second_position, -force) - spun
        return [Wrench(one, other, "centre", one, force, torque), Wrench(other, one, "centre", other, -force, back)]

    def contacts(self, one: str, other: str) -> dict:
        """The fields of Contacts: the second body acts on the first; normal and what turns about it point into it."""
        known = self._asdict() | {"point": self.contact_point, "normal": 0.0 - self.normal}
        known |= {name: 0.0 - known[name] for name in ("drilling_torque", "spin_rate")}
        rows = {name: np.full(1, known.get(name, 0.0), float) for name in NUMBERS}
        rows |= {name: np.array([known[name]], float) for name in VECTORS}
        return {"bodies": [one, other], "body": [0], "by": [1], "in_contact": rows["approach"] > 0.0, **rows}

    def markers(self, size: float, place) -> list[dict]:
        """The contact ellipse, ELLIPSE_SCALE times as large, while it is loaded; the load as text at `place`."""
        axes = (self.semi_major * self.major_axis, self.semi_minor * np.cross(self.normal, self.major_axis))
        sides = outlines(self.contact_point[None], *(ELLIPSE_SCALE * axis[None] for axis in axes))
        width, text = (0.02 * size, 0.0, 0.0), f"{self.normal_load:.4g} N, ellipse x {ELLIPSE_SCALE:g}"
        return [
            marker("contact_ellipses", 0, LINE_LIST, width, RED, points=sides if self.normal_load > 0.0 else None),
            load_marker(text, size, place),
        ]


def load_marker(text: str, size: float, place) -> dict:
    """A text at a place, for a scene of about that size [m]."""
    return marker("load", 0, TEXT, (0.0, 0.0, 0.3 * size), GREEN, place, text=text)


def pair_topics(
    link: str, pair_of: Callable[[Any, Sample], ContactPair], texts: Mapping[str, str], solids: SolidsOf
) -> tuple[Topic, ...]:
    """Topics of two bodies and their contact; `texts` say by body what its wrench is, the first body first."""
    names = tuple(texts)
    return (
        *body_topics(
            link,
            lambda parameters, sample: pair_of(parameters, sample).wrenches(*names),
            lambda parameters, sample: dict(zip(names, pair_of(parameters, sample)[:2], strict=True)),
            texts,
            solids,
        ),
        contacts_topic(
            link,
            lambda parameters, sample: pair_of(parameters, sample).contacts(*names),
            "the contact, as arrays of one row",
        ),
    )
