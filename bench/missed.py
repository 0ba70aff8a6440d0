"""What windows of a companion miss, and so what `MISSED` stands for: `python bench/missed.py [part of a scene ...]`.

The scenes of `bearing_twin chart tolerance`, at its tolerances, without that factor: the medians of what windows say
over the true error, of load and of friction, apart for runs in which every contact bears load throughout and for those
in which contacts come and go. Each for every second scene and for the others, which nobody looked at to choose it.
Estimates that do not come from windows (copies, what is inherited, inside steps) are left out, and so are runs that the
chart's table says were stopped. Then what `spread_of` stands for: how many times what is told, with that factor, 97 of
100 true errors are within, and what share of them is within the spread that runs tell, where that is over a tenth of
the tolerance: by windows of single balls, of all, by what a ring carries on, and what else is told but known exactly.
Many minutes.
"""

import sys
from datetime import date
from pathlib import Path

import numpy as np

from bearing_twin.charts import tolerance as chart
from bearing_twin.charts.bearing_variants import DRAWN
from bearing_twin.charts.table import read_table
from bearing_twin.kinds.bearing.companion import windows, worst

TABLE = Path(__file__).parent.parent / "docs" / "tolerance.csv"
OTHERS = tuple(windows.WHOSE[ball] for ball in windows.WHOSE if ball != windows.ALL)
SURE = windows.WHOSE[windows.BETWEEN]
OUTPUTS = {"loads": "load", "friction": "friction"}
TELLING, MOST = 0.1, 0.97  # share of the tolerance from which on spreads count; the quantile told
ALONE, TOGETHER, CARRIED, TOLD = KINDS = "single balls", "all balls", "carried on by a ring", "told otherwise"


def ratios_of(case, asked, factor):
    """Whether contacts come and go, of outputs that windows tell of what they say over the true error, and spreads.

    Spreads are true errors over what is told, with what windows miss: that `factor`.
    """
    run, found = chart._run(*chart.words_of(case), f"wanted.tolerance={asked!r}")
    exact, rougher = chart._exact(*chart.words_of(case))
    if "horizon_s" in run.report.errors:
        return False, {}, {}
    told, wanted = chart.compared(run, found, exact, rougher), run.report.errors["wanted_errors"]
    come_and_go, ratios, spreads = float(found["normal_load"].min()) <= 0.0, {}, {}
    for name, short in OUTPUTS.items():
        said, true, where = told[f"{short}_estimate"], told[f"{short}_error"], wanted[name].get("where", "")
        if not true > told[f"{short}_known"]:
            continue
        seen = not where.startswith(OTHERS)
        if seen:
            ratios[short] = said / true
        said *= factor if seen and come_and_go else 1.0
        if said > TELLING * asked and not where.startswith(SURE):
            carried = CARRIED if windows.carries(run.scene.parameters) else TOLD
            kind = carried if not seen else TOGETHER if where.startswith(windows.WHOSE[windows.ALL]) else ALONE
            spreads.setdefault(kind, []).append(true / said)
    return come_and_go, ratios, spreads


def studied(cases, factor):
    """Ratios by (come and go, output, half of the scenes), spreads with their kind for an output."""
    gathered = {}
    rows = [row for row in read_table(TABLE, chart.ToleranceRow) if row.method == chart.METHOD]
    stopped = {(row.problem, row.setting) for row in rows if row.status != chart.DONE}
    for number, case in enumerate(cases):
        print(f"{number + 1} of {len(cases)}: {case}", file=sys.stderr)
        for asked in chart.TOLERANCES:
            if (case, asked) in stopped:
                continue
            try:
                come_and_go, ratios, spreads = ratios_of(case, asked, factor)
            except chart.IntegrationError:
                continue
            for output, ratio in ratios.items():
                gathered.setdefault((come_and_go, output, number % 2), []).append(ratio)
            for kind, those in spreads.items():
                gathered.setdefault((come_and_go, kind, number % 2), []).extend(those)
    return gathered


def main(words):
    """Prints medians and spreads."""
    cases = [case for case in chart.ALL_CASES if case not in DRAWN]  # by which nothing is chosen
    cases = [case for case in cases if not words or any(word in case for word in words)]
    factor, worst.MISSED = worst.MISSED, 1.0
    gathered = studied(cases, factor)
    print(f"{len(cases)} scenes; MISSED is {factor:g}; {date.today()}")
    for come_and_go, name in ((False, "all contacts bear load"), (True, "contacts come and go")):
        for output in (*OUTPUTS.values(), *KINDS):
            halves = [gathered.get((come_and_go, output, half), []) for half in (0, 1)]
            if output in KINDS:
                whole = np.array(halves[0] + halves[1])
                spread = worst.spread_of(come_and_go, output == CARRIED)
                most = {ALONE: spread.alone, TOGETHER: spread.together}.get(output, spread.told)
                share = f"; {100.0 * np.mean(whole <= most):.3g} % within {most:g}" if len(whole) else ""
                said = f"97 % within {_each([*halves, whole], MOST)}{share}"
            else:
                said = f"median {_each(halves, 0.5)}"
            print(f"{name}: {output}: {said}")


def _each(lists, quantile):
    """The quantile of each of these lists, and how many it is of."""
    return ", ".join(f"{np.quantile(one, quantile):.3g} of {len(one)}" if len(one) else "none" for one in lists)


if __name__ == "__main__":
    main(sys.argv[1:])
