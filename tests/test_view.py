"""Pages for the browser without a browser: numbers that come back, thinning, hostile texts, damage, every kind."""

import base64
import json
import math
import re
import sys
import zlib

import numpy as np
import pytest
import toy_kind  # noqa: F401  (a kind without a view of its own)
from runs import made_up_block, made_up_run, made_up_scene

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.kinds.views import plain_view
from bearing_twin.log.run_log import write_log
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study
from bearing_twin.view import page as pages
from bearing_twin.view.page import STEPS, write_page
from bearing_twin.view.run_page import log_document, run_document
from bearing_twin.view.study_page import study_document
from bearing_twin.view.study_picture import study_sheet
from bearing_twin.view.tables import page_tables

SHORT = {  # a short run of each kind
    "bearing": ("bearing_6203_loose", "run.duration=0.02"),
    "shaft": ("shaft_angular_pair", "run.duration=0.01"),
    "two_spheres": ("two_spheres",),
    "two_discs": ("two_discs",),
    "sphere_on_beam": ("sphere_on_beam", "run.duration=5e-4"),
    "ellipsoid_on_plane": ("ellipsoid_on_plane", "run.duration=0.5"),
    "two_bodies": ("two_bodies_superellipsoid", "run.duration=0.01"),
    "soft_discs": ("soft_discs_fast", "mesh.divisions=12", "run.duration=1e-3"),
    "toy": ({"kind": "toy", "name": "swinging"},),
}


def unpack(packed):
    """Times and series of a packed run, as its page reads them."""
    content, offset = zlib.decompress(base64.b64decode(packed["data"])), 0

    def read(kind, count):
        nonlocal offset
        numbers = np.frombuffer(content, kind, count, offset)
        offset += numbers.nbytes
        return numbers

    count, values = int(read("<f8", 1)[0]), {}
    time = read("<f8", count)
    assert count == packed.get("frames", count)
    for series in packed["series"]:
        width = math.prod(series["shape"])
        least, greatest = read("<f8", width), read("<f8", width)
        low, high = (read(np.uint8, count * width) for _ in range(2))
        steps = low.astype(np.int64) + 256 * high.astype(np.int64)
        codes = np.cumsum(steps.reshape(width, count), axis=1).T % 65536
        values[series["name"]] = np.where(codes == 65535, np.nan, least + (greatest - least) / STEPS * codes)
    assert offset == len(content)
    return time, values


HOSTILE = "</script><script>alert(1)</script><img src=http://example.org/x onerror=alert(2)>"


def test_a_page_asks_no_network_and_its_texts_are_no_markup(tmp_path):
    document = {"title": HOSTILE, "kind": "run", "notes": [HOSTILE, "<!--"], "figures": [{"words": HOSTILE}]}
    page = write_page(document, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "default-src 'none'" in page
    assert page.count("</script>") == len(re.findall("^<script", page, re.MULTILINE))
    text = re.search(r'<script type="application/json" id="document">(.*?)</script>', page, re.DOTALL)[1]
    assert json.loads(text)["notes"] == [HOSTILE, "<!--"]
    assert HOSTILE not in page
    page = re.sub(r"<title>.*?</title>", "", page).replace(text, "")  # there it is text
    assert not re.search(r"(src|href)\s*=\s*[\"']?https?:", page)
    assert "MIT License" in page
    assert "@@" not in page.replace("@@iterator", "")


@pytest.fixture(scope="module", params=SHORT)
def shown(request):
    """(kind, scene, document) of a short run of each kind."""
    source, *overrides = SHORT[request.param]
    scene = load_scene(source, overrides) if isinstance(source, str) else parse_scene(source, "a test")
    return request.param, scene, run_document(simulate(scene)).document


def test_every_kind_has_a_view_whose_names_are_its_series(shown, tmp_path):
    kind, _, document = shown
    view, series = document["view"], {item["name"]: item for item in document["packed"]["series"]}
    names_used = {line["series"] for panel in view["panels"] for line in panel["lines"]}
    fields = (
        *("position", "deviation", "orientation", "turn", "tilt", "vector", "size", "point", "normal", "semi_major"),
        *("semi_minor", "pressure", "major_axis", "nodes", "values", "deflection"),
    )
    names_used |= {item[field] for item in (*view["solids"], *view["marks"]) for field in fields if item.get(field)}
    names_used |= {*view["look"]["around"], *((view["enlarged"] or {}).get("series", ()))}
    assert names_used <= set(series)
    assert len(view["panels"]) >= 2
    for panel in view["panels"]:
        for line in panel["lines"]:
            assert line["column"] < math.prod(series[line["series"]]["shape"])
    assert bool(view["solids"] or view["marks"]) == (kind != "toy")
    assert {item["on"] for item in view["marks"] if item.get("on")} <= {item["name"] for item in view["solids"]}
    assert document["packed"]["frames"] > 10
    assert write_page(document, tmp_path / "page.html").stat().st_size


def test_a_page_shows_the_numbers_of_the_run(shown):
    """Each series that is a channel too has the run's values, to the step of the page."""
    _, scene, document = shown
    blocks = list(simulate(scene).blocks())
    time, series = unpack(document["packed"])
    assert np.allclose(time, np.concatenate([block.time_ns for block in blocks]) * 1e-9, rtol=0, atol=1e-15)
    compared = 0
    for name in set(series) & {channel.name for channel in scene.channels}:
        values = np.concatenate([np.reshape(block.values[name], (len(block), -1)) for block in blocks])
        span = np.ptp(values) if values.shape[1] > 64 else np.ptp(values, axis=0)
        assert (np.abs(series[name] - values) <= span / STEPS + 1e-6 * np.abs(values).max()).all(), name
        compared += 1
    assert compared >= 3


def test_what_happened_one_after_the_other_is_a_table():
    contacts = [{"start_s": 1e-3 * k, "peak_force_n": 2.0 * k, "restitution": None} for k in range(300)]
    figures = {"contacts": contacts, "peak_force_n": 600.0}
    shown = page_tables(figures, {}, {"contacts": "one by one"})
    assert [row["words"] for row in shown["figures"]] == ["peak force"]
    (table,) = shown["tables"]
    assert [column[:2] for column in table["header"]] == [("start", "ms"), ("peak force", "N"), ("restitution", "")]
    assert table["rows"][3] == ["3", "6", "-"]
    assert len(table["rows"]) == 200
    assert table["title"] == "one by one; the first 200 of 300"


@pytest.fixture
def log_path(tmp_path, monkeypatch):
    """A log of 400 made up samples in several chunks, with a topic that no kind has."""
    monkeypatch.setattr("bearing_twin.log.mcap_write.CHUNK_BYTES", 60_000)
    scene = made_up_scene(balls=1)
    write_log(made_up_run(scene, [made_up_block(scene, 400)]), tmp_path / "run.mcap", run_record=False)
    return tmp_path / "run.mcap"


def test_a_damaged_log_shows_what_can_be_saved(log_path):
    all_times = unpack(log_document(log_path)["packed"])[0]
    data = bytearray(log_path.read_bytes())
    for cut, note in ((True, "has no end"), (False, "bearing_twin recover run.mcap")):
        damaged = data[: len(data) // 2] if cut else data
        damaged[len(damaged) // 2] ^= not cut
        log_path.write_bytes(damaged)
        document = log_document(log_path)
        time, _ = unpack(document["packed"])
        assert 50 < len(time) < 390
        assert set(time) < set(all_times)
        assert cut == bool((time == all_times[: len(time)]).all())
        assert note in document["notes"][0]
        assert cut or f"the {len(time)} outputs that can be saved" in document["notes"][0]
    log_path.write_bytes(data[:20])
    with pytest.raises(LogError):
        log_document(log_path)


def test_a_recording_without_its_scene_shows_its_channels():
    scene = made_up_scene(balls=1)
    view = plain_view(None, scene.channels)
    assert {line.series for panel in view.panels for line in panel.lines} == {
        channel.name for channel in scene.channels
    }


@pytest.fixture(scope="module")
def study():
    return run_study(load_study("spheres_alpha_4e-5", ["samples=400", "sweep=null"]))


def test_a_study_shows_densities_with_their_quantiles(study, tmp_path):
    panels = [panel for row in study_sheet(study, study.study.quantities, ()).rows for panel in row]
    panel = next(part for part in panels if part.title == "Contact duration")
    bars, smoothed, *parts = panel.parts
    assert np.isclose(bars.high[:-1] @ np.diff(bars.x), 1.0)
    assert np.isclose(np.trapezoid(smoothed.y, smoothed.x), 1.0, atol=0.03)
    quantiles = [part.x[0] for part in parts if part.name.startswith("5, 50, 95 %")]
    intervals = [part.x for part in parts if hasattr(part, "low")]
    assert len(quantiles) == len(intervals) == 3
    assert all(low <= part <= high for part, (low, high) in zip(quantiles, intervals, strict=True))
    document = study_document(study)
    rows = {row["words"]: row for row in document["statistics"][0]["rows"]}
    assert np.isclose(float(rows["50 % quantile"]["value"]), 1e6 * quantiles[1], rtol=1e-3)
    assert rows["mean"]["interval"]
    assert write_page(document, tmp_path / "page.html").stat().st_size


def test_view_of_a_scene_says_what_it_wrote(tmp_path, run_cli):
    out = tmp_path / "page.html"
    captured = run_cli("view", "two_spheres", "--out", out, "--json")
    reported = json.loads(captured.out)
    assert (reported["view"], reported["bytes"], reported["shows"]) == (str(out), out.stat().st_size, "two_spheres")
    assert "is run for 7.848e-05 s" in captured.err
    assert "<title>two_spheres" in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["two_spheres", "--out", "x.png"], "not the name of a page"),
        (["two_spheres", "--gif", "x.mp4"], "not the name of a"),
        (["two_spheres", "--mp4", "x.mp4"], "give --gif"),
        (["two_spheres", "--out", "none/x.html"], "none is not a folder"),
        (["no_such.mcap"], "no_such.mcap"),
        (["no_such_scene"], "no scene 'no_such_scene'"),
        (["run.mcap", "--duration", "1"], "a log cannot be changed"),
        (["spheres_alpha_4e-5", "--duration", "1"], "a study has no --duration"),
        (["two_spheres", "--topic", "/left/samples"], "give --topic and --run with a log"),
    ],
)
def test_what_view_cannot_do_is_said_in_one_sentence(tmp_path, monkeypatch, arguments, sentence, refused):
    monkeypatch.chdir(tmp_path)
    assert sentence in refused("view", *arguments)
    assert list(tmp_path.iterdir()) == []


def test_an_animation_without_its_library_says_what_to_install_before_a_run(tmp_path, monkeypatch, refused):
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    monkeypatch.chdir(tmp_path)
    assert "animations need the package playwright; install it with: pip install '.[view]'" in refused(
        "view", "two_spheres", "--gif", "film.gif"
    )
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(BearingTwinError, match=r"pip install '\.\[view\]'"), pages.browser_page(9, 9):
        pass
