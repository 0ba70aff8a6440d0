"""What a person looks at of a running scene, whatever the program: its frame, its markers, and curves over time.

`bearing_twin.log.layouts` writes it in the forms that programs take; the topics and their types are those of the scene.
"""

from pathlib import Path
from typing import NamedTuple

from bearing_twin.errors import LogError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Facts
from bearing_twin.log import cdr
from bearing_twin.log.run_log import LogStream
from bearing_twin.log.stream import Channelled, topics
from bearing_twin.log.study_log import INPUT, REALISATIONS_TOPIC, first_realisation
from bearing_twin.run.scene import Scene
from bearing_twin.units import labelled

ENERGIES = ("kinetic_energy", "elastic_energy", "potential_energy", "drive_work", "dissipated")
RACEWAYS = ("inner", "outer")


class Curve(NamedTuple):
    """One number over time: full name of the topic, its type, names of nested fields (or an index) and a label."""

    topic: str
    ros_type: str
    path: tuple[str | int, ...]
    label: str

    def dotted(self) -> str:
        """The path as `.force.x` or `.normal_load[0]`."""
        return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.path)


class Plot(NamedTuple):
    """Curves on one pair of axes; the title has their unit. With `number` they are points over it, not over time."""

    title: str
    curves: tuple[Curve, ...]
    number: Curve | None = None


class Panels(NamedTuple):
    """What there is to look at: the frame of the scene, topics of the 3-D view (None: there is none), and plots.

    A study has plots alone, and no frame. What is seen has its middle and the radius `radius` [m] in that frame. Where
    `follows` is a frame, the middle is its origin, and goes with it.
    """

    name: str
    frame: str
    markers: str | None
    description: str | None
    middle: tuple[float, float, float]
    radius: float
    plots: tuple[Plot, ...]
    follows: str = ""


def panels(scene: Scene, namespace: str = "", frame_prefix: str = "") -> Panels:
    """The panels of a scene that runs in `namespace` (empty: that of its kind), its frames behind `frame_prefix`."""
    kind = KINDS[scene.kind]
    table = {topic.name: topic for topic in topics(scene)}
    place = namespace.rstrip("/") or kind.namespace

    def full(name: str) -> str | None:
        return f"{place}/{name}" if name in table else None

    bodies = [name for name, topic in table.items() if topic.ros_type == cdr.WRENCH]
    balls = sum(name.startswith("ball_") for name in bodies)
    plots = [
        *_contact_plots(table, place, balls),
        *(_wrench_plot(table[name], place) for name in bodies if not name.startswith("ball_")),
        *_state_plots(table, place),
    ]
    look = kind.view(Facts(scene, "", ""), scene.channels).look  # of the scene alone, whatever its model
    middle, radius = look.beginning
    shown = full("markers"), full("robot_description")
    seen = ((0.0, 0.0, 0.0), radius) if look.follows else (middle, radius)
    follows = f"{frame_prefix}{look.follows}" if look.follows else ""
    return Panels(scene.name, f"{frame_prefix}{kind.frame}", *shown, *seen, tuple(plots), follows)


def panels_of_log(log: LogStream) -> Panels:
    """The panels of the run in a log, its topics and frames named as there; raises LogError where it has no scene."""
    if log.scene is None:
        raise LogError(
            f"{log.path} holds no scene, neither in its metadata nor on a topic; record the topic `scene` too"
        )
    return panels(log.scene, log.namespace, log.frame.removesuffix(KINDS[log.scene.kind].frame))


def panels_of_study(path) -> Panels:
    """The panels of the study in a log: its quantities and inputs over the number of the realisation.

    Raises LogError for a log without single realisations.
    """
    message = first_realisation(path)

    def curve(path: tuple[str | int, ...], label: str) -> Curve:
        return Curve(REALISATIONS_TOPIC, cdr.REALISATION, path, label)

    number, plots = curve(("number",), "number"), []
    for place, (name, unit) in enumerate(zip(message.name, message.unit, strict=True)):
        sort, _, words = name.partition(" ")
        plot = Plot(labelled(words.replace("_", " "), unit), (curve(("value", place), words),), number)
        plots.insert(len(plots) if sort == INPUT.strip() else 0, plot)
    return Panels(Path(path).stem, "", None, None, (0.0, 0.0, 0.0), 1.0, tuple(plots))


def _contact_plots(table: dict[str, Channelled], place: str, balls: int) -> list[Plot]:
    if "contacts" not in table:
        return []
    topic = table["contacts"]
    shown = {"normal_load": "normal load [N]", "peak_pressure": "peak pressure [Pa]"}

    def curve(field: str, row: int, label: str) -> Curve:
        return Curve(f"{place}/{topic.name}", topic.ros_type, (field, row), label)

    if not balls:
        return [Plot(title, (curve(field, 0, field),)) for field, title in shown.items()]
    return [
        Plot(f"{title}, {raceway} raceway", tuple(curve(field, 2 * k + side, f"ball {k}") for k in range(balls)))
        for field, title in shown.items()
        for side, raceway in enumerate(RACEWAYS)
    ]


def _wrench_plot(topic: Channelled, place: str) -> Plot:
    body = topic.name.removesuffix("/wrench")
    curves = (Curve(f"{place}/{topic.name}", topic.ros_type, ("wrench", "force", axis), f"F{axis}") for axis in "xyz")
    return Plot(f"force on {body.replace('_', ' ')} [N]", tuple(curves))


def _state_plots(table: dict[str, Channelled], place: str) -> list[Plot]:
    if "state" not in table or table["state"].ros_type != cdr.STATE:
        return []
    shown = {
        "speed [rad/s]": ("cage_speed", "inner_ring_speed"),
        "torque of the drive [N m]": ("drive_torque",),
        "energy [J]": ENERGIES,
    }
    return [
        Plot(title, tuple(Curve(f"{place}/state", cdr.STATE, (field,), field.replace("_", " ")) for field in fields))
        for title, fields in shown.items()
    ]
