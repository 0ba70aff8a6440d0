"""The realisations of a study as a table of pandas."""

from bearing_twin.extras import wanted
from bearing_twin.uq.quantities import quantity_of
from bearing_twin.uq.scene_keys import numeric_keys

FAILED = "failed"
WHY_FAILED = "why the realisation failed; empty where it did not"


def frame_of(result):
    """One row a realisation of a `StudyResult`: inputs, quantities [SI], `failed` (why, or nothing), as a DataFrame.

    `attrs["units"]` and `attrs["meanings"]` map columns to theirs; inputs and quantities of one name get `input.` and
    `quantity.` in front.
    Raises BearingTwinError without pandas.
    """
    pandas = wanted("pandas", "export")
    frame = pandas.DataFrame(columns_of(result))
    frame.index.name = "realisation"
    frame.attrs["units"], frame.attrs["meanings"] = units_of(result), meanings_of(result)
    return frame


def columns_of(result) -> dict:
    """The columns by name, as arrays and lists."""
    inputs, quantities = _names(result)
    columns = {name: result.values[:, place] for place, name in enumerate(inputs)}
    columns |= {name: result.quantities[:, place] for place, name in enumerate(quantities)}
    return columns | {FAILED: ["" if code == 0 else result.reasons[code - 1] for code in result.status.tolist()]}


def units_of(result) -> dict[str, str]:
    """The unit of each column that has one."""
    inputs, quantities = _names(result)
    units = [*result.input_units.values(), *result.quantity_units.values()]
    return dict(zip([*inputs, *quantities], units, strict=True))


def meanings_of(result) -> dict[str, str]:
    """What each column is: of inputs as the keys of the scene say it, of quantities as their rows."""
    inputs, quantities = _names(result)
    kind, keys = result.study.kind, numeric_keys(result.study.kind)
    told = [keys[one.key].help for one in result.study.inputs]
    told += [quantity_of(kind, name).meaning for name in result.study.quantities]
    return dict(zip([*inputs, *quantities], told, strict=True)) | {FAILED: WHY_FAILED}


def _names(result) -> tuple[list[str], list[str]]:
    inputs, quantities = [one.key for one in result.study.inputs], list(result.study.quantities)
    both = set(inputs) & set(quantities)
    return (
        [f"input.{name}" if name in both else name for name in inputs],
        [f"quantity.{name}" if name in both else name for name in quantities],
    )
