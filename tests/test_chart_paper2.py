"""The sheets of paper 2: every figure has its place, what is drawn is what runs give, conclusions are weighed."""

import json
import math
import re

import numpy as np
import pytest
from test_chart_studies import curves, is_whole

from bearing_twin.charts import paper2
from bearing_twin.charts.paper2 import SHEETS
from bearing_twin.command.cli import main
from bearing_twin.reference.struck_beam import strike

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")


@pytest.fixture(scope="module")
def sheets():
    return {name: row.make(lambda share: None) for name, row in SHEETS.rows.items()}


def test_every_figure_is_on_one_sheet(sheets):
    assert sorted(figure for row in SHEETS.rows.values() for figure in row.figures) == [1, 2, 3, 4, 5]
    for name, sheet in sheets.items():
        is_whole(sheet)
        titles = " ".join(panel.title for panel in sheet.panels)
        assert {int(one) for one in re.findall(r"Figure (\d)", titles)} == set(SHEETS.rows[name].figures)


def test_the_drawing_is_to_scale_and_the_beam_bends_as_told(sheets):
    drawn = curves(sheets["drops"])
    across, up = drawn["figure 2a", "sphere, radius 10 mm"]
    assert (across.max() - across.min(), up.max() - up.min()) == pytest.approx((0.02, 0.02), rel=1e-3)
    assert up.min() == pytest.approx(0.05, rel=1e-3)
    assert drawn["figure 3a", "sphere, radius 10 mm"][1].min() == pytest.approx(0.6, rel=1e-3)
    depths = {
        (panel, theory): -up.min()
        for (panel, name), (_, up) in drawn.items()
        for theory in ("Euler", "Timoshenko")
        if name.startswith(f"greatest deflection, {theory}")
    }
    assert depths["figure 2b, c", "Euler"] == pytest.approx(98.86e-6, rel=1e-3)
    assert depths["figure 3b, c", "Timoshenko"] == pytest.approx(317.8e-6, rel=1e-3)


def test_quarters_are_alike_and_stress_is_that_of_the_bent_line(sheets):
    """By symmetry; and the stress is E h/2 times the curvature where no shear bends the line (Euler), by statics."""
    _, _, watch = paper2.motion(50, "timoshenko")
    deflection, stress = watch.at_points(np.linspace(0.0, 1e-3, 50))
    assert deflection[:, 1] == pytest.approx(deflection[:, 3], abs=1e-12)
    assert stress[:, 1] == pytest.approx(stress[:, 3], abs=1.0)
    assert deflection[:, 0] == pytest.approx(deflection[:, 2], abs=1e-15)
    drawn = curves(sheets["histories"])
    for figure, (first, second) in {4: (98.9e-6, 97.6e-6), 5: (328.2e-6, 317.8e-6)}.items():
        assert drawn[f"figure {figure}a", "impact, Euler"][1].max() == pytest.approx(first, rel=2e-3)
        assert drawn[f"figure {figure}a", "impact, Timoshenko"][1].max() == pytest.approx(second, rel=2e-3)
    assert drawn["figure 4b", "impact, Timoshenko"][1].max() == pytest.approx(70.73e6, rel=2e-3)


@pytest.mark.parametrize("height", paper2.HEIGHTS)
def test_local_deformation_lengthens_the_contact_and_lowers_its_force(height):
    soft, rigid = paper2.first_contacts(height)
    assert soft.duration > rigid.contacts[-1, 1] > rigid.contacts[0, 1]
    assert soft.peak_force < 0.3 * paper2.rigid_force(height)


def test_a_rigid_contact_is_relieved_by_shear_waves():
    """Until the section turns, the force is v Z exp(-Z t / m), Z the waves' impedance; finer cells keep the contact."""
    _, found, _ = paper2.motion(50, "timoshenko")
    speed, sphere = float(found.motions[0, 1]), found.sphere
    contacts = []
    for cells in (400, 800):
        blow = strike(found.beam, sphere.mass, math.inf, speed, 0.5, 6e-5, cells)
        contacts.append(blow.contacts[:, 1])
        early = (blow.time > 2e-7) & (blow.time < 6e-7)
        slowed = np.exp(-paper2.rigid_force(50) / speed * blow.time[early] / sphere.mass)
        assert blow.force[early].mean() == pytest.approx(paper2.rigid_force(50) * slowed.mean(), rel=0.02)
    assert contacts[0] == pytest.approx(contacts[1], rel=2e-3)


def test_the_stress_does_not_die_down_faster_for_the_smaller_height(sheets):
    """Undamped not at all; damped, the harder blow holds more of its stress in high modes, which die first."""
    for height in paper2.HEIGHTS:
        shares, _ = paper2.stress_after(height, "timoshenko", 0.0)
        assert shares == pytest.approx(np.ones(paper2.PERIODS), abs=0.06)
    small, large = (paper2.stress_after(height, "timoshenko", paper2.DAMPING)[0] for height in paper2.HEIGHTS)
    assert (small[1:] > large[1:]).all()
    assert sum("claim holds" in one for one in sheets["claims"].reading) == 2
    assert "does not hold" in sheets["claims"].reading[-1]


def test_the_command_writes_the_sheet_that_is_asked_for(tmp_path, capsys):
    assert main(["chart", "paper2", "--only", "4", "--out", str(tmp_path), "--json"]) == 0
    (sheet,) = json.loads(capsys.readouterr().out)["sheets"]
    assert sheet["name"] == "histories"
    assert {path.name for path in tmp_path.iterdir()} == {"paper2_histories.png", "paper2_histories.csv"}
    assert main(["chart", "paper2", "--only", "9", "--out", str(tmp_path)]) == 2
    assert main(["chart", "laws", "--only", "4", "--out", str(tmp_path)]) == 2
    assert "goes with the chart studies or paper2" in capsys.readouterr().err
