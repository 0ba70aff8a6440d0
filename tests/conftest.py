"""Settings for all tests, and the choice of those that fit into a time."""

import gc
import json
import multiprocessing
import os
import signal
import subprocess
import sys

import processes  # noqa: F401 - what forks do not collect
import pytest
from hypothesis import settings
from processes import own_domain

from bearing_twin.base.process import AT_END, limit_blas_threads
from bearing_twin.command import cli
from bearing_twin.command.commands import COMMANDS
from bearing_twin.command.outcome import Outcome

limit_blas_threads()
gc.disable()  # until all tests are collected: what modules hold is no garbage
# Each process that a test starts would compile every module of Python for itself, 0.3 s.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ["LANGUAGE"] = "C"  # words of argparse are not translated, nor looked for, which was half of a parser's time
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background of a shell; what tests start would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)

# How long examples take says nothing about right or wrong.
settings.register_profile("bearing_twin", deadline=None)
settings.load_profile("bearing_twin")

SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP  # what executables take over
# Files that fork most: first, while there is little to copy.
FORKING = "test_workers", "test_ensemble", "test_model_error", "test_study", "test_kinds"
DRAWN: set[tuple] = set()  # titles and labels of the panels of pictures drawn


@pytest.fixture(autouse=True)
def ended():
    """What a command leaves to the end of its process, as a node of ROS, ends with the test."""
    yield
    while AT_END:
        AT_END.pop()(cli.BAD_INPUT)


@pytest.fixture(scope="session", autouse=True)
def domain():
    """Messages of ROS by this process and those it starts reach no other run of tests."""
    with own_domain() as number:
        os.environ["ROS_DOMAIN_ID"] = str(number)
        yield


@pytest.fixture
def quick_workers(monkeypatch):
    """Worker processes are forks of this one, which saves the seconds that a new one takes to import what it needs.

    That they work as new ones is what tests without this show.
    """
    context = multiprocessing.get_context
    monkeypatch.setattr(
        multiprocessing, "get_context", lambda method=None: context("fork" if method == "spawn" else method)
    )


@pytest.fixture
def quick_diagnostics(monkeypatch):
    """Nodes tell of themselves five times a second, for tests that wait for their word while they compute."""
    import ros  # noqa: F401 - skips where there is no ROS

    for node in ("sim_node", "uq_node"):
        monkeypatch.setattr(f"bearing_twin.nodes.{node}.DIAGNOSTICS_PERIOD", 0.2)


@pytest.fixture
def quick_pictures(monkeypatch):
    """Pictures are drawn whole, but once, small, without a search for a layout and with ticks at the ends.

    That is a small part of what they cost. Numbers at ticks are drawn where the package says how. For tests of what is
    drawn and reported; where things stand is looked at by eye.
    """
    from matplotlib import rcParams
    from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, LogFormatter, NullFormatter, ScalarFormatter

    def saved(figure, path, **_):
        figure.set_layout_engine("none")
        figure.dpi = 40
        for axes in figure.axes:
            axes.minorticks_off()
            for axis in (axes.xaxis, axes.yaxis):
                if not isinstance(axis.get_major_locator(), FixedLocator):  # whose ticks the picture names
                    axis.set_major_locator(FixedLocator(axis.get_view_interval()))
                if isinstance(axis.get_major_formatter(), (LogFormatter, ScalarFormatter)):  # Matplotlib's own
                    axis.set_major_formatter(NullFormatter())
        FigureCanvasAgg(figure).print_png(path, pil_kwargs={"compress_level": 1})

    measured = RendererAgg.get_text_width_height_descent

    def size(renderer, text, font, ismath):
        """About that of words, which are set letter by letter as they are drawn, not before, too."""
        points = font.get_size_in_points()
        return measured(renderer, text, font, ismath) if ismath else (0.3 * points * len(text), 0.4 * points, 0.1)

    monkeypatch.setitem(rcParams, "axes.titley", 1.0)  # which else makes room for ticks above
    monkeypatch.setattr(Figure, "savefig", saved)
    monkeypatch.setattr(RendererAgg, "get_text_width_height_descent", size)


@pytest.fixture
def pictures_once(quick_pictures, monkeypatch):
    """As quick_pictures, but a picture whose panels have been drawn in this process already is left white."""
    from matplotlib.figure import Figure
    from PIL import Image

    drawn = Figure.savefig

    def saved(figure, path, **_):
        panels = tuple((axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes)
        if panels in DRAWN:
            Image.new("RGB", tuple(figure.bbox.size.astype(int)), "white").save(path, format="png")
        else:
            DRAWN.add(panels)
            drawn(figure, path)

    monkeypatch.setattr(Figure, "savefig", saved)


@pytest.fixture
def run_cli(capsys):
    """A function that runs a command and returns what it prints, `out` and `err`; `code`: its exit code."""

    def run(*arguments, code=cli.DONE):
        capsys.readouterr()
        ended = cli.main([*map(str, arguments)])
        printed = capsys.readouterr()
        assert ended == code, printed.err
        return printed

    return run


@pytest.fixture
def run_json(run_cli):
    """A function that runs a command and returns the object that it prints as one line of JSON."""

    def run(*arguments, code=cli.DONE):
        out = run_cli(*arguments, "--json", code=code).out
        assert out.count("\n") == 1
        return json.loads(out, parse_constant=lambda constant: pytest.fail(f"{constant} is not JSON"))

    return run


@pytest.fixture
def shown(run_cli, monkeypatch):
    """A function that returns what a command prints of this result."""

    def show(result):
        monkeypatch.setitem(COMMANDS, "scenes", COMMANDS["scenes"]._replace(run=lambda _: Outcome(result, [])))
        return run_cli("scenes").out

    return show


@pytest.fixture
def refused(run_cli):
    """A function that runs a command and returns the sentence with which it refuses its arguments."""

    def run(*arguments):
        out, err = run_cli(*arguments, code=cli.BAD_INPUT)
        assert out == ""
        assert err.startswith("bearing_twin: ")
        assert len(err.splitlines()) == 1
        return err

    return run


@pytest.fixture
def here(monkeypatch, capfd):
    """An executable called in this process, which saves the seconds that another one imports; as a process tells it."""
    from ros import rclpy  # skips where there is no ROS

    from bearing_twin.base import process
    from bearing_twin.nodes import entry

    handlers, environment = [signal.getsignal(number) for number in SIGNALS], dict(os.environ)

    monkeypatch.setattr(process, "exit_process", lambda code: None)  # which would end the tests, too
    monkeypatch.setattr(process, "prepare_streams", lambda: None)  # streams are those of the tests

    def call(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        code = getattr(entry, name)()
        rclpy.try_shutdown()
        return subprocess.CompletedProcess(name, code, *capfd.readouterr())

    yield call
    for number, handler in zip(SIGNALS, handlers, strict=True):
        signal.signal(number, handler)
    for name in {*os.environ} - {*environment}:
        del os.environ[name]
    os.environ.update(environment)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Side by side, one process takes files from the front, the other from the back.

    Files that stand together use the same: the process that forks programs, what is cached. Each process has
    it for itself, so that files dealt in turn made both have all of it.
    """
    from xdist.scheduler import LoadFileScheduling

    class FromBothEnds(LoadFileScheduling):
        def _assign_work_unit(self, node):
            if self.nodes.index(node) % 2:
                self.workqueue.move_to_end(next(reversed(self.workqueue)), last=False)
            super()._assign_work_unit(node)

    return FromBothEnds(config, log)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """Begins with what forks most."""
    first = {name: index for index, name in enumerate(FORKING)}
    items.sort(key=lambda item: first.get(item.path.stem, len(first)))


def pytest_collection_finish():
    # What modules hold stays to the end: to look through it again and again for garbage took a tenth of the time.
    gc.freeze()
    gc.set_threshold(1_000_000, 20, 1000)
    gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_configure(config):
    config.pluginmanager.register(Named(config), "names of what fails")


class Named:
    """Says at once what failed: of a run that is cut off, nothing else would tell."""

    def __init__(self, config):
        self.terminal = None if hasattr(config, "workerinput") else config.pluginmanager.get_plugin("terminalreporter")

    def pytest_runtest_logreport(self, report):
        if report.failed and self.terminal:
            self.terminal.ensure_newline()
            self.terminal.write_line(f"failed: {report.nodeid} ({report.when}, {report.duration:.0f} s)")
            self.terminal.write_line(str(report.longreprtext)[-2000:])
