"""Layouts for RViz, Foxglove and PlotJuggler, drawn from the panels of a scene."""

import json
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import yaml

from bearing_twin.errors import BearingTwinError
from bearing_twin.log.panels import Curve, Panels, Plot
from bearing_twin.paths import write_whole

COLORS = (
    "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf",
)  # fmt: skip
PLOTS_IN_A_ROW = 2
AXES = 0.14  # length of a frame's axes, of the radius of what is seen: longer ones hide the balls
AWAY = 3.5  # distance of the eye from the middle, of that radius: all of it is within 45 degrees
TITLES = ("foxglovePanelTitle", "lichtblickPanelTitle")  # what Foxglove shows, and what Lichtblick shows
LEGEND_PIXELS = 150  # beside the curves: in front of them it hides those of small panels


class ViewerLayout(NamedTuple):
    """One program: end of the file's name, what makes its bytes, how to open them, and `data`, a log with them."""

    suffix: str
    made: Callable[[Panels], bytes]
    opened: str
    data: str = ""

    def opening(self, path: Path, log: Path | None) -> str:
        """What opens the layout at `path`, with the log it was made of where there is one."""
        return self.opened.format(file=path, data=self.data.format(log=log) if log else "")


def write_layout(program: str, panels: Panels, path) -> Path:
    """Writes the layout for a program of LAYOUTS to a new file; raises BearingTwinError where it cannot."""
    path = Path(path)
    if path.exists():
        raise BearingTwinError(f"{path} exists and is not overwritten; give another folder or remove it first")
    return write_whole(path, LAYOUTS[program].made(panels))


def rviz(panels: Panels, *others: Panels) -> bytes:
    """Markers, frames and, switched off, the URDF of one scene or several, in the frame of the first."""
    displays = [
        {"Class": "rviz_default_plugins/Grid", "Name": "Grid", "Enabled": True, "Cell Size": 0.25 * panels.radius},
        {"Class": "rviz_default_plugins/TF", "Name": "Frames", "Enabled": False, "Marker Scale": 0.4 * panels.radius},
    ]
    for one in (panels, *others):
        displays += _rviz_displays(one)
    view = {
        "Class": "rviz_default_plugins/Orbit",
        "Name": "Current View",
        "Distance": AWAY * panels.radius,
        "Focal Point": dict(zip("XYZ", panels.middle, strict=True)),
        "Focal Shape Size": 0.14 * panels.radius,
        "Target Frame": panels.follows or panels.frame,
        "Yaw": 0.6,
        "Pitch": 0.9,
        "Near Clip Distance": 0.001,  # m, the least that RViz takes
    }
    tools = [{"Class": f"rviz_default_plugins/{name}"} for name in ("MoveCamera", "Select", "FocusCamera", "Measure")]
    manager = {
        "Class": "",
        "Name": "root",
        "Enabled": True,
        "Displays": displays,
        "Tools": tools,
        "Global Options": {"Fixed Frame": panels.frame, "Background Color": "48; 48; 48", "Frame Rate": 30},
        "Views": {"Current": view, "Saved": None},
    }
    sides = [{"Class": "rviz_common/Displays", "Name": "Displays"}, {"Class": "rviz_common/Views", "Name": "Views"}]
    text = yaml.safe_dump({"Panels": sides, "Visualization Manager": manager}, sort_keys=False)
    return text.encode()


def _rviz_displays(panels: Panels) -> list[dict]:
    found = []
    if panels.description:
        named = {"Name": f"Bodies of {panels.description}", "Enabled": False, "Description Source": "Topic"}
        topic = _rviz_topic(panels.description, "Transient Local")
        found.append({"Class": "rviz_default_plugins/RobotModel", **named, "Description Topic": topic})
    if panels.markers:
        named = {"Name": panels.markers, "Enabled": True}
        topic = _rviz_topic(panels.markers, "Volatile")
        found.append({"Class": "rviz_default_plugins/MarkerArray", **named, "Topic": topic})
    return found


def _rviz_topic(name: str, durability: str) -> dict:
    quality = {"Depth": 5, "Durability Policy": durability, "History Policy": "Keep Last"}
    return {**quality, "Reliability Policy": "Reliable", "Value": name}


def foxglove(panels: Panels) -> bytes:
    """A 3-D panel beside plots; of a study the plots alone."""
    found, names = {}, []
    for number, plot in enumerate(panels.plots):
        name = f"Plot!{number}"
        names.append(name)
        found[name] = _foxglove_plot(plot)
    layout = {"configById": found, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1}}
    if not panels.frame:
        return json.dumps(layout | {"layout": _halved(names)}, indent=1).encode() + b"\n"
    layout["configById"] = {"3D!scene": _foxglove_view(panels), **found}
    split = {"first": "3D!scene", "second": _halved(names), "direction": "row", "splitPercentage": 45}
    return json.dumps(layout | {"layout": split if names else "3D!scene"}, indent=1).encode() + b"\n"


def _foxglove_view(panels: Panels) -> dict:
    # axes of frames are 0.2 m long unless told; Lichtblick is told a factor of that, Foxglove the length [m]
    frames = {"showLabel": False, "axisScale": AXES / 0.2 * panels.radius, "axisSize": AXES * panels.radius}
    return {
        "followTf": panels.follows or panels.frame,
        "followMode": "follow-position" if panels.follows else "follow-none",
        "transforms": {},
        "publish": {},
        "scene": {"meshUpAxis": "z_up", "transforms": frames},
        "cameraState": {
            "distance": AWAY * panels.radius,
            "perspective": True,
            "phi": 50,
            "thetaOffset": 35,
            "fovy": 45,
            "near": 0.001 * panels.radius,
            "far": 100.0,
            "target": [0, 0, 0],
            "targetOffset": list(panels.middle),
            "targetOrientation": [0, 0, 0, 1],
        },
        "topics": {panels.markers: {"visible": True}} if panels.markers else {},
        "layers": {
            "grid": {
                "layerId": "foxglove.Grid",
                "instanceId": "grid",
                "frameId": panels.frame,  # else it goes with what is followed
                "size": 6 * panels.radius,
            }
        },
    }


def _foxglove_plot(plot: Plot) -> dict:
    """Curves over time; points where the plot has a number, which is the X axis once "message path" is chosen there.

    Lichtblick 1.28 draws nothing of a file where both axes are fields of one topic.
    """
    over = {"xAxisPath": {"value": _dotted(plot.number), "enabled": True}} if plot.number else {}
    return {
        **dict.fromkeys(TITLES, plot.title),
        "paths": [
            {
                "value": _dotted(curve),
                "label": curve.label,
                "enabled": True,
                "timestampMethod": "receiveTime",
                "showLine": plot.number is None,
                "color": color,
            }
            for curve, color in _colored(plot)
        ],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": len(plot.curves) > 1,
        "legendDisplay": "left",
        "sidebarDimension": LEGEND_PIXELS,
        "isSynced": plot.number is None,
        "xAxisVal": "timestamp",
        **over,
    }


def _dotted(curve: Curve) -> str:
    return f"{curve.topic}{curve.dotted()}"


def _halved(names: Sequence[str], direction: str = "column"):
    """Panels one below the other, as Foxglove nests them: in halves."""
    if len(names) == 1:
        return names[0]
    middle = len(names) // 2
    other = "row" if direction == "column" and len(names) <= 2 * PLOTS_IN_A_ROW else direction
    first, second = _halved(names[:middle], other), _halved(names[middle:], other)
    return {"first": first, "second": second, "direction": direction, "splitPercentage": 50}


def plotjuggler(panels: Panels) -> bytes:
    """One tab of plots, two in a row; the sign in `orientation` is that of the line between what it splits."""
    root = ElementTree.Element("root")
    window = ElementTree.SubElement(root, "tabbed_widget", parent="main_window", name="Main Window")
    tab = ElementTree.SubElement(window, "Tab", containers="1", tab_name=panels.name)
    columns = ElementTree.SubElement(ElementTree.SubElement(tab, "Container"), "DockSplitter")
    shares = min(PLOTS_IN_A_ROW, len(panels.plots))
    columns.attrib.update({"orientation": "|", "count": str(shares), "sizes": _equal(shares)})
    for column in range(shares):
        plots = panels.plots[column::shares]
        rows = ElementTree.SubElement(columns, "DockSplitter")
        rows.attrib.update({"orientation": "-", "count": str(len(plots)), "sizes": _equal(len(plots))})
        for plot in plots:
            _plotjuggler_plot(ElementTree.SubElement(rows, "DockArea", name=plot.title), plot)
    ElementTree.SubElement(window, "currentTabIndex", index="0")
    ElementTree.SubElement(root, "use_relative_time_offset", enabled="1")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _plotjuggler_plot(area: ElementTree.Element, plot: Plot) -> None:
    mode, style = ("XYPlot", "Dots") if plot.number else ("TimeSeries", "Lines")
    axes = ElementTree.SubElement(area, "plot", mode=mode, style=style, flip_x="false", flip_y="false")
    ElementTree.SubElement(axes, "limitY")
    for curve, color in _colored(plot):
        name = _slashed(curve)
        over = {"curve_x": _slashed(plot.number), "curve_y": name} if plot.number else {}
        ElementTree.SubElement(axes, "curve", name=f"{name} [XY]" if over else name, color=color, **over)


def _slashed(curve: Curve) -> str:
    return curve.topic + "".join(f"[{part}]" if isinstance(part, int) else f"/{part}" for part in curve.path)


def _equal(count: int) -> str:
    return ";".join([f"{1 / max(count, 1):.6g}"] * count)


def _colored(plot: Plot):
    return [(curve, COLORS[number % len(COLORS)]) for number, curve in enumerate(plot.curves)]


LAYOUTS = {
    "rviz": ViewerLayout(".rviz", rviz, "rviz2 -d {file}"),
    "foxglove": ViewerLayout(".foxglove.json", foxglove, "in Foxglove: Layouts, import from file"),
    "plotjuggler": ViewerLayout(
        ".plotjuggler.xml", plotjuggler, "plotjuggler {data}--layout {file}", "--datafile {log} "
    ),
}
