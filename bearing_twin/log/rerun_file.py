"""A log as one file for the viewer Rerun: the messages, and how to look at them."""

import functools
from pathlib import Path

from bearing_twin.errors import BearingTwinError, LogError
from bearing_twin.extras import install
from bearing_twin.log.bag import LogReader, log_files
from bearing_twin.log.panels import Panels
from bearing_twin.paths import write_whole

APPLICATION = "bearing_twin"
TIMELINE = "message_log_time"
SHOWN_IN = 6.0  # s: what lasts less is played so slowly
MOST_NAMED = 5  # curves: a longer legend would hide them


def write_rerun(log, panels: Panels, path) -> Path:
    """Writes a log (.mcap or bag folder) with a 3-D view and plots to a new .rrd file: `rerun FILE` opens it.

    Rerun binds layouts to programs, so that a layout alone would not be used for a log. It draws the links of
    `robot_description` where `/tf` places them; of markers it knows nothing. It is made in memory. Raises LogError,
    and BearingTwinError without rerun-sdk.
    """
    try:
        import rerun
    except ImportError as error:
        raise BearingTwinError(
            f"files for Rerun are written by rerun-sdk, which is not here ({error}): {install('rerun')}"
        ) from error
    path = Path(path)
    if path.exists():
        raise LogError(f"{path} exists and is not overwritten; give another name or remove it first")
    recording = rerun.RecordingStream(APPLICATION)
    stream = recording.binary_stream()  # a sink that writes a file can wait for ever where the disk is full
    for file in log_files(log):
        recording.log_file_from_path(file)
    recording.send_blueprint(_blueprint(panels, log_span(log)))
    return write_whole(path, stream.read() or b"")


def _blueprint(panels: Panels, span: float):
    import rerun
    import rerun.blueprint as blueprint
    from rerun.blueprint import encodings

    mapped = functools.partial(encodings.VisualizerComponentMapping, "Scalars:scalars")
    source = encodings.ComponentSourceKind.SourceComponent
    plots = []
    for plot in panels.plots:
        lines = {}
        for curve in plot.curves:
            component = f"{curve.ros_type.replace('/', '.')}:message"
            mapping = mapped(source, source_component=component, selector=curve.dotted())
            line = rerun.SeriesLines(names=curve.label).visualizer(mappings=[mapping])
            lines.setdefault(curve.topic, []).append(line)
        corner = blueprint.PlotLegend(blueprint.Corner2D.LeftTop, visible=len(plot.curves) <= MOST_NAMED)
        named = {"name": plot.title, "plot_legend": corner}
        plots.append(blueprint.TimeSeriesView(origin="/", contents=sorted(lines), overrides=lines, **named))
    shown = blueprint.Grid(*plots, grid_columns=2)
    if panels.frame:
        place = blueprint.SpatialInformation(target_frame=panels.frame)
        view = blueprint.Spatial3DView(name=panels.name, origin="/", contents=["/**"], spatial_information=place)
        shown = blueprint.Horizontal(view, shown)
    # An impact lasts microseconds: at the pace of the clock it would be over before anything is drawn.
    pace = {"playback_speed": span / SHOWN_IN} if 0.0 < span < SHOWN_IN else {}
    time = blueprint.TimePanel(timeline=TIMELINE, state="collapsed", **pace)
    return blueprint.Blueprint(shown, time, collapse_panels=True)


def log_span(path) -> float:
    """The time [s] from the first to the last message of a log, by its index; raises LogError."""
    reader = LogReader(path)
    return 1e-9 * (reader.last_ns - reader.first_ns)
