"""The figures of paper 3, 1 to 24, on nine sheets, with the numbers drawn."""

from bearing_twin.charts.sheets import Row, Sheets
from bearing_twin.charts.study_convergence import convergence
from bearing_twin.charts.study_discs import discs
from bearing_twin.charts.study_forces import forces
from bearing_twin.charts.study_soft import soft_case1, soft_case2, soft_fast, soft_run
from bearing_twin.charts.study_spheres import densities, speeds

SHEETS = Sheets(
    "study",
    {
        "densities": Row((1, 2, 10, 11), densities),
        "speeds": Row((3, 4, 5, 6, 7), speeds),
        "forces": Row((8,), forces),
        "convergence": Row((9,), convergence),
        "discs": Row((13, 14), discs),
        "soft_run": Row((12,), soft_run),
        "soft_fast": Row((15, 16), soft_fast),
        "soft_case1": Row((17, 18, 19, 20), soft_case1),
        "soft_case2": Row((21, 22, 23, 24), soft_case2),
    },
)
