"""The figures of paper 3, 1 to 24, on nine sheets, with the numbers drawn."""

from bearing_twin.charts.sheets import SheetRow, Sheets
from bearing_twin.charts.study_convergence import convergence
from bearing_twin.charts.study_discs import discs
from bearing_twin.charts.study_forces import forces
from bearing_twin.charts.study_soft import soft_case1, soft_case2, soft_fast, soft_run
from bearing_twin.charts.study_spheres import densities, speeds

SHEETS = Sheets(
    "study",
    {
        "densities": SheetRow((1, 2, 10, 11), densities),
        "speeds": SheetRow((3, 4, 5, 6, 7), speeds),
        "forces": SheetRow((8,), forces),
        "convergence": SheetRow((9,), convergence),
        "discs": SheetRow((13, 14), discs),
        "soft_run": SheetRow((12,), soft_run),
        "soft_fast": SheetRow((15, 16), soft_fast),
        "soft_case1": SheetRow((17, 18, 19, 20), soft_case1),
        "soft_case2": SheetRow((21, 22, 23, 24), soft_case2),
    },
)
