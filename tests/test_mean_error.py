"""The error of a mean: what windows share counts in full, what is as often one way as the other falls with time."""

import numpy as np
import pytest

from bearing_twin.kinds.bearing.companion.means import MeanError
from bearing_twin.kinds.bearing.companion.windows import ALL, INHERITED, PLACE, WINDOW
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene


def means_of(errors, ball=0, seconds=1e-3):
    """Windows of so many seconds with these errors [N m] of their mean torque."""
    mean = MeanError()
    for number, error in enumerate(errors):
        row = np.zeros(len(WINDOW.columns))
        row[0], row[PLACE["begin"]] = number + seconds, number
        row[PLACE["ball"]], row[PLACE["mean_torque"]] = ball, error
        mean.add(row)
    return mean


def test_what_windows_share_does_not_fall_with_time():
    assert means_of(4 * [2e-6]).over(1e3, 1.0, 1.0) == pytest.approx(2e-6, rel=2e-3)


def test_what_windows_share_is_their_mean_over_time():
    mean = means_of([4e-6])
    mean.seen[0][0] += 3e-3  # three times as long without an error
    assert mean.over(1e9, 1.0, 1.0) == pytest.approx(1e-6, rel=1e-3)


def test_what_is_as_often_one_way_as_the_other_falls_with_the_root_of_time():
    """A thousand windows of 1 ms fit into a second."""
    mean = means_of([2e-6, -2e-6])
    assert mean.over(1.0, 1.0, 1.0) == pytest.approx(2e-6 / 1000**0.5)
    assert mean.over(4.0, 1.0, 1.0) == pytest.approx(1e-6 / 1000**0.5)


def test_no_mean_is_worse_than_its_instants_nor_better_than_what_no_window_saw():
    assert means_of([2e-6]).over(1e-3, 1.0, 3e-6) == 3e-6
    assert means_of([]).over(1.0, 1.0, 3e-6) == 3e-6
    assert means_of([np.inf, -np.inf]).over(1.0, 1.0, np.inf) == np.inf
    inherited = means_of([1e-6, -1e-6])
    inherited.whole = means_of([5e-6], INHERITED).whole
    assert inherited.over(1.0, 1.0, 9e-6) == 5e-6


def test_balls_together_count_as_often_as_their_windows_miss():
    one, all_of_them = means_of([2e-6, -2e-6]), means_of([2e-6, -2e-6], ALL)
    assert one.over(1.0, 30.0, 1.0) == one.over(1.0, 1.0, 1.0)
    assert all_of_them.over(1.0, 30.0, 1.0) == pytest.approx(30.0 * all_of_them.over(1.0, 1.0, 1.0))


@pytest.mark.parametrize(("scene", "tolerance"), [("bearing_6203", 1e-2), ("bearing_6203_loose", 1e-2)])
def test_the_error_told_of_a_mean_torque_is_that_of_a_mean(scene, tolerance):
    """Above a tenth of the true one, and a fifth at most of what an instant was off that a window saw."""

    def outcome(*differs):
        run = simulate(load_scene(scene, ("run.duration=0.2", *differs)))
        rows = [block.records.get(WINDOW.name, np.zeros((0, len(WINDOW.columns)))) for block in run.blocks()]
        return run, np.concatenate(rows)

    exact, _ = outcome("wanted.tolerance=1e-8", "solver.companion=off")
    run, rows = outcome(f"wanted.tolerance={tolerance}")
    torques = [np.array(one.report.figures["friction_torque_nm"]) for one in (run, exact)]
    true = float(np.abs(torques[0] - torques[1]).max())
    told = max(run.report.errors["errors_by_source"]["friction_torque_nm"]["method"])
    assert 0.1 * true < told < 0.2 * rows[:, PLACE["torque"]].max()
