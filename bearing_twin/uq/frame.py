"""The realisations of a study as a table of pandas."""

from bearing_twin.extras import wanted


def frame_of(result):
    """One row a realisation of a `StudyResult`: inputs, quantities [SI], `failed` (why, or nothing), as a DataFrame.

    `attrs["units"]` maps columns to units; inputs and quantities of one name get `input.` and `quantity.` in front.
    Raises BearingTwinError without pandas.
    """
    pandas = wanted("pandas", "export")
    frame = pandas.DataFrame(columns_of(result))
    frame.index.name = "realisation"
    frame.attrs["units"] = units_of(result)
    return frame


def columns_of(result) -> dict:
    """The columns by name, as arrays and lists."""
    inputs, quantities = _names(result)
    columns = {name: result.values[:, place] for place, name in enumerate(inputs)}
    columns |= {name: result.quantities[:, place] for place, name in enumerate(quantities)}
    return columns | {"failed": ["" if code == 0 else result.reasons[code - 1] for code in result.status.tolist()]}


def units_of(result) -> dict[str, str]:
    """The unit of each column that has one."""
    inputs, quantities = _names(result)
    units = [*result.input_units.values(), *result.quantity_units.values()]
    return dict(zip([*inputs, *quantities], units, strict=True))


def _names(result) -> tuple[list[str], list[str]]:
    inputs, quantities = [one.key for one in result.study.inputs], list(result.study.quantities)
    both = set(inputs) & set(quantities)
    return (
        [f"input.{name}" if name in both else name for name in inputs],
        [f"quantity.{name}" if name in both else name for name in quantities],
    )
