"""What figures are worth, below the picture of a run: what its rows say and where they stand."""

import pytest
from matplotlib.figure import Figure

from bearing_twin.pictures.worth import JudgedFigure, draw_worth
from bearing_twin.report import Report
from bearing_twin.run.picture import worth_of


def reporting(key, value, error):
    """A report of one figure with an error."""
    figures, errors = {key: value}, {"errors_by_source": {key: {"method": error}}}
    return Report("a scene", "", "", "", (), (), "done", 1.0, 1.0, 1, {}, figures, errors)


@pytest.mark.parametrize(
    ("key", "value", "error", "words", "text", "share"),
    [
        ("drive_work_j", -984.302e-6, 1e-9, "drive work", "-984.302 ± 0.001 µJ", 1e-9 / 984.302e-6),
        ("force_n", [-606.0, 574.0, 0], [0.1, 0.5, 0.1], "force (3 values)", "-606.00 to 574.00 ± 0.5 N", 0.5 / 606.0),
        ("force_n", [-3.0, -5.0], [0.1, 0.1], "force (2 values)", "-5.00 to -3.00 ± 0.1 N", 0.1 / 5.0),
        ("force_n", [2.0, 2.0, 2.0], 0.1, "force (3 values)", "2.00 ± 0.1 N", 0.1 / 2.0),
        ("contact_count", 24, 2.0, "contact count", "24 ± 2", 2.0 / 24.0),
        ("force_n", [-2.0], [0.1], "force", "-2.00 ± 0.1 N", 0.1 / 2.0),
    ],
)  # fmt: skip
def test_a_row_has_the_signs_of_its_figure_and_both_ends_of_several_values(key, value, error, words, text, share):
    (row,) = worth_of(reporting(key, value, error))
    assert (row.words, row.text) == (words, text)
    assert row.parts == {"method": pytest.approx(share)}


def test_the_longest_label_stays_inside_the_picture():
    figure = Figure(figsize=(16.0, 5.0))
    long = JudgedFigure(
        "angular momentum change vertical (3 values)", "-0.000214188 to 0.00021419 ± 1.3e-12 N m s", {"law": 1.0}
    )
    draw_worth(figure, [long, JudgedFigure("peak force", "1 N", {"law": 1.0})])
    left = min(label.get_window_extent().x0 for label in figure.axes[0].get_yticklabels())
    assert left > 0.0
