"""Layouts for RViz, Foxglove and PlotJuggler: the panels of a scene or a run in each program's form."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from string import Template
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from bearing_twin.base.errors import LogError
from bearing_twin.base.paths import share_path
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Topic
from bearing_twin.log import cdr
from bearing_twin.log.run_log import LogStream
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import Scene

ENERGIES = ("kinetic_energy", "elastic_energy", "potential_energy", "drive_work", "dissipated")
RACEWAYS = ("inner", "outer")


class Curve(NamedTuple):
    """One number over time: full name of the topic, its type, names of nested fields (or an index) and a label."""

    topic: str
    ros_type: str
    path: tuple[str | int, ...]
    label: str

    def full_path(self, separator: str) -> str:
        """Topic and path, as `/ball_0/wrench.force.x` or `/contacts.normal_load[0]`."""
        parts = (f"[{part}]" if isinstance(part, int) else f"{separator}{part}" for part in self.path)
        return self.topic + "".join(parts)


class Plot(NamedTuple):
    """Curves over time on one pair of axes; the title has their unit."""

    title: str
    curves: tuple[Curve, ...]


class Panels(NamedTuple):
    """Panels of a scene: its frame, topics of the 3-D view (None if it has none), and plots.

    The visible region has its centre `middle` and its `radius` [m] in that frame. Where
    `follows` is a frame, the centre is its origin and moves with it.
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
    """The panels of a scene that runs in `namespace` (empty: that of its kind), its frames with `frame_prefix`."""
    kind = KINDS[scene.kind]
    table = {topic.name: topic for topic in topics(scene)}
    prefix = namespace.rstrip("/") or kind.namespace

    def full(name: str) -> str | None:
        return f"{prefix}/{name}" if name in table else None

    bodies = [name for name, topic in table.items() if topic.ros_type == cdr.WRENCH]
    balls = sum(name.startswith("ball_") for name in bodies)
    plots = [
        *_contact_plots(table, prefix, balls),
        *(_wrench_plot(table[name], prefix) for name in bodies if not name.startswith("ball_")),
        *_state_plots(table, prefix),
    ]
    camera = kind.view(scene.parameters, scene.channels).look
    middle, radius = camera.beginning
    shown = full("markers"), full("robot_description")
    seen = ((0.0, 0.0, 0.0), radius) if camera.follows else (middle, radius)
    follows = f"{frame_prefix}{camera.follows}" if camera.follows else ""
    return Panels(scene.name, f"{frame_prefix}{kind.frame}", *shown, *seen, tuple(plots), follows)


def panels_of_log(log: LogStream, namespace: str = "") -> Panels:
    """The panels of the run in a log, its topics in `namespace` (empty: as logged); raises LogError without a scene."""
    if log.scene is None:
        raise LogError(
            f"{log.path} holds no scene, neither in its metadata nor on a topic; record the topic `scene` too"
        )
    return panels(log.scene, namespace or log.namespace, log.frame.removesuffix(KINDS[log.scene.kind].frame))


def _contact_plots(table: dict[str, Topic], prefix: str, balls: int) -> list[Plot]:
    if "contacts" not in table:
        return []
    topic = table["contacts"]
    shown = {"normal_load": "normal load [N]", "peak_pressure": "peak pressure [Pa]"}

    def curve(field: str, row: int, label: str) -> Curve:
        return Curve(f"{prefix}/{topic.name}", topic.ros_type, (field, row), label)

    if not balls:
        return [Plot(title, (curve(field, 0, field),)) for field, title in shown.items()]
    return [
        Plot(f"{title}, {raceway} raceway", tuple(curve(field, 2 * k + side, f"ball {k}") for k in range(balls)))
        for field, title in shown.items()
        for side, raceway in enumerate(RACEWAYS)
    ]


def _wrench_plot(topic: Topic, prefix: str) -> Plot:
    body = topic.name.removesuffix("/wrench")
    curves = (Curve(f"{prefix}/{topic.name}", topic.ros_type, ("wrench", "force", axis), f"F{axis}") for axis in "xyz")
    return Plot(f"force on {body.replace('_', ' ')} [N]", tuple(curves))


def _state_plots(table: dict[str, Topic], prefix: str) -> list[Plot]:
    if "state" not in table or table["state"].ros_type != cdr.STATE:
        return []
    shown = {
        "speed [rad/s]": ("cage_speed", "inner_ring_speed"),
        "torque of the drive [N m]": ("drive_torque",),
        "energy [J]": ENERGIES,
    }
    return [
        Plot(title, tuple(Curve(f"{prefix}/state", cdr.STATE, (field,), field.replace("_", " ")) for field in fields))
        for title, fields in shown.items()
    ]


COLORS = (
    "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf",
)  # fmt: skip
PLOTS_IN_A_ROW = 2
AXES = 0.14  # length of a frame's axes as a share of the visible radius: longer ones hide the balls
AWAY = 3.5  # distance of the eye from the middle, of that radius: all of it is within 45 degrees
TITLES = ("foxglovePanelTitle", "lichtblickPanelTitle")  # keys of Foxglove and of Lichtblick
LEGEND_PIXELS = 150  # next to the curves: over them it hides those of small panels


class ViewerLayout(NamedTuple):
    """One program: suffix of the file, function that returns its bytes, how to open it, and `data`, a log with it."""

    suffix: str
    render: Callable[[Panels], bytes]
    command: str
    data: str = ""

    def open_command(self, path: Path, log: Path | None) -> str:
        """The command that opens the layout at `path`, with the log from which it was made, if any."""
        return self.command.format(file=path, data=self.data.format(log=log) if log else "")


def rviz(panels: Panels, *further: Panels) -> bytes:
    """Markers, frames and, switched off, the URDF of one scene or several, in the frame of the first."""
    x, y, z = (f"{coordinate:.9f}" for coordinate in panels.middle)  # no 1e-05, which is text in YAML 1.1
    lengths = {"cell": 0.25, "axes": 0.4, "distance": AWAY, "focus": 0.14}
    named = {name: f"{share * panels.radius:.9f}" for name, share in lengths.items()}
    displays = "".join(map(_rviz_displays, (panels, *further)))
    frames = {"frame": panels.frame, "target": panels.follows or panels.frame}
    return _template("scene.rviz", displays=displays, x=x, y=y, z=z, **frames, **named).encode()


def _template(name: str, **values) -> str:
    """A file of config/layouts with these values."""
    return Template(share_path("config", "layouts", name).read_text(encoding="utf-8")).substitute(values)


def _rviz_displays(panels: Panels) -> str:
    quality = "Depth: 5, History Policy: Keep Last, Reliability Policy: Reliable, Durability Policy:"
    displays = ""
    if panels.description:
        displays += f"""\
  - Class: rviz_default_plugins/RobotModel
    Name: Bodies of {panels.description}
    Enabled: false
    Description Source: Topic
    Description Topic: {{{quality} Transient Local, Value: {panels.description}}}
"""
    if panels.markers:
        displays += f"""\
  - Class: rviz_default_plugins/MarkerArray
    Name: {panels.markers}
    Enabled: true
    Topic: {{{quality} Volatile, Value: {panels.markers}}}
"""
    return displays


def foxglove(panels: Panels) -> bytes:
    """A 3-D panel next to plots."""
    plots = {f"Plot!{number}": _foxglove_plot(plot) for number, plot in enumerate(panels.plots)}
    split = {"first": "3D!scene", "second": _nest([*plots]), "direction": "row", "splitPercentage": 45}
    layout = {"globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1}, "layout": split}
    return json.dumps({"configById": {"3D!scene": _foxglove_view(panels)} | plots, **layout}, indent=1).encode() + b"\n"


def _foxglove_view(panels: Panels) -> dict:
    """The 3-D panel: its grid lies in the scene's frame, or would move with the followed frame.

    Axes of frames are 0.2 m long by default; Lichtblick takes a factor of that, Foxglove the length [m].
    """
    shares = {"scale": AXES / 0.2, "axes": AXES, "distance": AWAY, "near": 0.001, "grid": 6}
    values = {name: share * panels.radius for name, share in shares.items()}
    values |= {"target": panels.follows or panels.frame, "frame": panels.frame, "markers": panels.markers}
    values |= {"follow": "follow-position" if panels.follows else "follow-none", "middle": panels.middle}
    return json.loads(_template("scene.foxglove.json", **{name: json.dumps(value) for name, value in values.items()}))


def _foxglove_plot(plot: Plot) -> dict:
    paths = [
        {"value": curve.full_path("."), "label": curve.label, "enabled": True, "color": color}
        | {"timestampMethod": "receiveTime", "showLine": True}
        for curve, color in _with_colors(plot)
    ]
    shown = {"showXAxisLabels": True, "showYAxisLabels": True, "showLegend": len(plot.curves) > 1}
    shown |= {"legendDisplay": "left", "sidebarDimension": LEGEND_PIXELS, "isSynced": True, "xAxisVal": "timestamp"}
    return dict.fromkeys(TITLES, plot.title) | {"paths": paths} | shown


def _nest(names: Sequence[str], direction: str = "column"):
    """Panels one below the other, as Foxglove nests them: in halves."""
    if len(names) == 1:
        return names[0]
    middle = len(names) // 2
    inner_direction = "row" if direction == "column" and len(names) <= 2 * PLOTS_IN_A_ROW else direction
    first, second = _nest(names[:middle], inner_direction), _nest(names[middle:], inner_direction)
    return {"first": first, "second": second, "direction": direction, "splitPercentage": 50}


def plotjuggler(panels: Panels) -> bytes:
    """One tab of plots, two in a row; the sign in `orientation` shows the line between the parts."""
    shares = min(PLOTS_IN_A_ROW, len(panels.plots))
    columns = [panels.plots[column::shares] for column in range(shares)]
    text = f"""\
<?xml version='1.0' encoding='utf-8'?>
<root>
 <tabbed_widget parent="main_window" name="Main Window">
  <Tab containers="1" tab_name={quoteattr(panels.name)}>
   <Container>
    <DockSplitter orientation="|" {_equal_sizes(shares)}>
{"".join(map(_plotjuggler_column, columns))}\
    </DockSplitter>
   </Container>
  </Tab>
  <currentTabIndex index="0" />
 </tabbed_widget>
 <use_relative_time_offset enabled="1" />
</root>
"""
    return text.encode()


def _plotjuggler_column(plots: Sequence[Plot]) -> str:
    areas = "".join(map(_plotjuggler_plot, plots))
    return f'     <DockSplitter orientation="-" {_equal_sizes(len(plots))}>\n{areas}     </DockSplitter>\n'


def _plotjuggler_plot(plot: Plot) -> str:
    names = ((quoteattr(curve.full_path("/")), color) for curve, color in _with_colors(plot))
    curves = "".join(f'        <curve name={name} color="{color}" />\n' for name, color in names)
    return f"""\
      <DockArea name={quoteattr(plot.title)}>
       <plot mode="TimeSeries" style="Lines" flip_x="false" flip_y="false">
        <limitY />
{curves}\
       </plot>
      </DockArea>
"""


def _equal_sizes(count: int) -> str:
    return f'count="{count}" sizes="{";".join([f"{1 / max(count, 1):.6g}"] * count)}"'


def _with_colors(plot: Plot):
    return [(curve, COLORS[number % len(COLORS)]) for number, curve in enumerate(plot.curves)]


LAYOUTS = {
    "rviz": ViewerLayout(".rviz", rviz, "rviz2 -d {file}"),
    "foxglove": ViewerLayout(".foxglove.json", foxglove, "in Foxglove: Layouts, import from file"),
    "plotjuggler": ViewerLayout(
        ".plotjuggler.xml", plotjuggler, "plotjuggler {data}--layout {file}", "--datafile {log} "
    ),
}
