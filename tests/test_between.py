"""Methods between explicit and implicit ones, which `bench/between.py` charts: their tables, their order, a run.

What compiles their loops, which no user needs, is for the environments.
"""

import functools
import itertools

import between
import numpy as np
import pytest
from between_steps import ARK3, ARK4, METHODS, ROS34PW2

from bearing_twin.charts.table import DONE, read_table
from bearing_twin.charts.work_precision import CASES, WANTED

ROUNDING = 1e-14


@pytest.mark.parametrize("pair", [ARK4, ARK3], ids=["ARK4", "ARK3"])
def test_additive_tables_meet_the_conditions_of_their_order_together(pair):
    """For every mixture of both tables, whose stages are at the same instants: Kennedy and Carpenter, section 2."""
    tables, nodes = (pair.explicit, pair.implicit), pair.explicit.sum(axis=1)
    assert pair.implicit.sum(axis=1) == pytest.approx(nodes, abs=ROUNDING)
    for weights, order in ((pair.weights, pair.order), (pair.embedded, pair.order - 1)):
        conditions = [[weights.sum() - 1.0], [weights @ nodes - 1 / 2]]
        conditions.append([weights @ nodes**2 - 1 / 3, *(weights @ one @ nodes - 1 / 6 for one in tables)])
        conditions.append([weights @ nodes**3 - 1 / 4])
        for one in tables:
            conditions[3] += [(weights * nodes) @ one @ nodes - 1 / 8, weights @ one @ nodes**2 - 1 / 12]
        conditions[3] += [weights @ a @ b @ nodes - 1 / 24 for a, b in itertools.product(tables, tables)]
        assert np.abs(np.concatenate(conditions[:order])).max() < ROUNDING
        assert order == 4 or np.abs(conditions[order]).max() > 1e-3


def test_the_w_method_meets_the_conditions_of_its_order_whatever_the_jacobian():
    """Those of Hairer and Wanner, section IV.7, for W-methods."""
    alpha, gamma = ROS34PW2.explicit, ROS34PW2.implicit
    nodes, sums = alpha.sum(axis=1), gamma.sum(axis=1)
    for weights, order in ((ROS34PW2.weights, 3), (ROS34PW2.embedded, 2)):
        conditions = [[weights.sum() - 1.0], [weights @ nodes - 1 / 2, weights @ sums]]
        conditions.append([weights @ nodes**2 - 1 / 3, weights @ alpha @ nodes - 1 / 6])
        conditions[2] += [weights @ alpha @ sums, weights @ gamma @ nodes, weights @ gamma @ sums]
        assert np.abs(np.concatenate(conditions[:order])).max() < ROUNDING
        assert order == 3 or np.abs(conditions[order]).max() > 1e-3


@pytest.mark.environment
@pytest.mark.parametrize("method", list(METHODS))
def test_balls_that_ring_have_the_order_of_the_method(method):
    assert between.observed_order(method) == pytest.approx((METHODS[method].order,) * 2, abs=0.25)


@pytest.mark.environment
@pytest.mark.parametrize("method", list(METHODS))
def test_friction_however_stiff_does_not_shorten_steps(method, monkeypatch):
    """Regularised at 0.1 mm/s it has dopri5 evaluate rates 500 times as often; contacts are as stiff in both."""
    monkeypatch.setitem(between.PROBLEMS, "sticking", CASES["sticking"])
    stiff, soft = (between.judge(name, method, WANTED, enough=0.0) for name in ("sticking", "settled"))
    each = [row.evaluations / between.PROBLEMS[row.problem].seconds for row in (stiff, soft)]
    assert stiff.status == soft.status == DONE
    assert each[0] < 1.3 * each[1]


@pytest.mark.environment
def test_a_run_is_judged_as_the_product_and_charted(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(between, "LADDER", (1e-3,))
    monkeypatch.setattr(between, "judge", functools.partial(between.judge, enough=0.0))
    between.main(str(tmp_path), "sliding")
    rows = read_table(tmp_path / "between.csv")
    assert [row.method for row in rows] == [*METHODS, "rodas4", "rodas3", "dopri5"]
    assert all(row.status == DONE and 1e-7 < row.error < 3e-3 for row in rows)
    assert (tmp_path / "between.png").stat().st_size > 1e4
    assert "the cheapest method between takes so many times what the product does" in capsys.readouterr().out


@pytest.mark.parametrize("words", [("nowhere",), ("docs", "nothing")])
def test_bad_input_gets_a_sentence_before_anything_runs(words, monkeypatch, capsys):
    monkeypatch.chdir(between.Path(between.__file__).parents[1])
    with pytest.raises(SystemExit) as ended:
        between.main(*words)
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith("give a folder that exists, then some of sudden,")
