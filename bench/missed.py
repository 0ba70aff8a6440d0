"""What windows of a companion miss, and so what `MISSED` stands for: `python bench/missed.py [part of a scene ...]`.

The scenes of `bearing_twin chart tolerance`, at its tolerances, without that factor: the medians of what windows say
over the true error, of load and of friction, apart for runs in which every contact bears load throughout and for those
in which contacts come and go. Each for every second scene and for the others, which nobody looked at to choose it.
Estimates that do not come from windows (copies, what is inherited, inside steps) are left out, and so are runs that the
chart's table says were stopped. Many minutes.
"""

import sys
from datetime import date
from pathlib import Path

import numpy as np

from bearing_twin.charts import tolerance as chart
from bearing_twin.charts.table import read_table
from bearing_twin.kinds.bearing.companion import windows, worst

TABLE = Path(__file__).parent.parent / "docs" / "tolerance.csv"
OTHERS = tuple(windows.WHOSE[ball] for ball in windows.WHOSE if ball != windows.ALL)


def ratios_of(case, asked):
    """Whether contacts come and go, and for each output that windows tell of what they say over the true error."""
    run, found = chart._run(case, f"wanted.tolerance={asked!r}")
    exact, rougher = chart._exact(case)
    if "horizon_s" in run.report.errors:
        return False, {}
    told, wanted = chart.compared(run, found, exact, rougher), run.report.errors["wanted_errors"]
    names = {"loads": "load", "friction": "friction"}
    ratios = {
        short: told[f"{short}_estimate"] / told[f"{short}_error"]
        for name, short in names.items()
        if told[f"{short}_error"] > told[f"{short}_known"] and not wanted[name].get("where", "").startswith(OTHERS)
    }
    return float(found["normal_load"].min()) <= 0.0, ratios


def studied(cases):
    """Ratios by (come and go, output, half of the scenes)."""
    gathered = {}
    stopped = {(row.problem, row.setting) for row in read_table(TABLE, chart.ToleranceRow) if row.status != chart.DONE}
    for number, case in enumerate(cases):
        print(f"{number + 1} of {len(cases)}: {case}", file=sys.stderr)
        for asked in chart.TOLERANCES:
            if (case, asked) in stopped:
                continue
            try:
                come_and_go, ratios = ratios_of(case, asked)
            except chart.IntegrationError:
                continue
            for output, ratio in ratios.items():
                gathered.setdefault((come_and_go, output, number % 2), []).append(ratio)
    return gathered


def main(words):
    """Prints the medians."""
    cases = [case for case in chart.ALL_CASES if not words or any(word in case for word in words)]
    factor, worst.MISSED = worst.MISSED, 1.0
    gathered = studied(cases)
    print(f"{len(cases)} scenes; MISSED is {factor:g}; {date.today()}")
    for come_and_go, name in ((False, "all contacts bear load"), (True, "contacts come and go")):
        for output in ("load", "friction"):
            halves = [gathered.get((come_and_go, output, half), []) for half in (0, 1)]
            said = ", ".join(f"{np.median(one):.3g} of {len(one)}" if one else "none" for one in halves)
            print(f"{name}: {output} {said}")


if __name__ == "__main__":
    main(sys.argv[1:])
