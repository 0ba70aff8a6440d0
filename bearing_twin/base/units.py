"""Units: how one is declared, how it ends the key of a figure, how people read it, and which prefixes it takes.

A channel, a quantity and a parameter declare the symbol; the keys of figures, JSON and costs end with the suffix.
"""

import functools
import math
import re
from collections.abc import Mapping
from typing import NamedTuple

CELSIUS = 273.15  # K, of 0 °C
ALL, BELOW_ONE, ABOVE_ONE = "GMkmµn", "mµn", "GMk"
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


class Limits(NamedTuple):
    """Open (`above`, `below`) and closed (`at_least`, `at_most`) bounds of a quantity; None = unbounded.

    `least` and `greatest` bound its size where it is not 0: beyond them double precision fails, not physics.
    `less` says what a number below `at_least` is, where there is a reason to name.
    """

    above: float | None = None
    below: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    least: float = 0.0
    greatest: float = math.inf
    less: str = ""

    @property
    def without_sizes(self) -> "Limits":
        """These limits without the bounds of the size."""
        return self._replace(least=0.0, greatest=math.inf)

    def allow(self, value: float) -> bool:
        """True for a value within all bounds."""
        return not (
            not (value == 0.0 or self.least <= abs(value) <= self.greatest)
            or (self.above is not None and value <= self.above)
            or (self.below is not None and value >= self.below)
            or (self.at_least is not None and value < self.at_least)
            or (self.at_most is not None and value > self.at_most)
        )

    @functools.cache  # noqa: B019 - there are few, and every number of every scene reads it
    def text(self) -> str:
        """The bounds in words; empty without any."""
        bounds = [(name, bound) for name, bound in zip(self._fields, self[:4], strict=False) if bound is not None]
        numbers = [(name, bound if isinstance(bound, int) else f"{bound:g}") for name, bound in bounds]
        phrases = [f"{name.replace('_', ' ')} {number}" for name, number in numbers]
        if self.greatest < math.inf:
            phrases.append(f"of a size up to {self.greatest:g}")
        return " and ".join(phrases)


NO_LIMITS = Limits()


class Unit(NamedTuple):
    """A row of UNITS: `suffix` of keys ("" = none is used), `shown` in tables of SI, the `prefixes` it may take.

    `engineering` is the unit that engineers read in its place and the factor into it; without one it is `shown` with a
    prefix. `zero` is the prefix where all values are 0. The size of a declared parameter without bounds of its own
    lies between `least` and `greatest`: wider than any bearing, ball or beam, and far from where products of such
    numbers leave double precision. `digits` are shown at most, however small the error of the method.
    """

    suffix: str
    shown: str
    prefixes: str = ""
    least: float = 0.0
    greatest: float = math.inf
    engineering: tuple[str, float] | None = None
    zero: str = ""
    digits: int = 5


UNITS = {  # by the symbol that declarations use
    "1": Unit("", "", least=1e-15, greatest=1e12),
    "m": Unit("m", "m", ALL, least=1e-9, greatest=1e4, zero="µ"),
    "s": Unit("s", "s", BELOW_ONE, least=1e-15, greatest=1e9),
    "kg": Unit("kg", "kg", least=1e-24, greatest=1e9),
    "rad": Unit("rad", "rad", BELOW_ONE, greatest=1e6, engineering=("°", 180.0 / math.pi)),
    "K": Unit("k", "K", least=1.0, greatest=1e5),
    "1/K": Unit("per_k", "1/K", greatest=1.0),
    "Hz": Unit("hz", "Hz", least=1e-9, greatest=1e12),
    "1/s": Unit("per_s", "1/s"),
    "W": Unit("w", "W", ALL),
    "N": Unit("n", "N", ALL, least=1e-9, greatest=1e12),
    "J": Unit("j", "J", ALL),
    "Pa": Unit("pa", "Pa", ALL, least=1e-3, greatest=1e15, engineering=("MPa", 1e-6)),
    "1/Pa": Unit("per_pa", "1/Pa", least=1e-12, greatest=1e-3),
    "dB": Unit("db", "dB", digits=3),
    "B": Unit("bytes", "B", ABOVE_ONE, least=1.0, greatest=1e15),
    "Mrev": Unit("mrev", "Mrev", digits=3),
    "h": Unit("h", "h", digits=3),
    "N m": Unit("nm", "N m", ALL, greatest=1e12, engineering=("N mm", 1e3)),
    "N s": Unit("ns", "N s", ALL),
    "N m s": Unit("nms", "N m s"),
    "kg m^2/s": Unit("", "kg m²/s"),
    "kg m": Unit("", "kg m", greatest=1e9),
    "kg m^2": Unit("", "kg m²", greatest=1e9),
    "N m/rad": Unit("", "N m/rad", greatest=1e15),
    "N s/m": Unit("", "N s/m", greatest=1e15),
    "N m s/rad": Unit("", "N m s/rad", greatest=1e15),
    "N/m": Unit("n_per_m", "N/m", least=1e-9, greatest=1e15, engineering=("N/µm", 1e-6)),
    "1/m": Unit("per_m", "1/m"),
    "m^2": Unit("m2", "m²", engineering=("mm²", 1e6)),
    "m^3": Unit("m3", "m³", engineering=("mm³", 1e9)),
    "m^2/s": Unit("m2_s", "m²/s", least=1e-9, greatest=1.0, engineering=("mm²/s", 1e6)),
    "s/m": Unit("s_per_m", "s/m", greatest=1e6),
    "m/s": Unit("m_s", "m/s", least=1e-12, greatest=1e5),
    "m/s^2": Unit("m_s2", "m/s²", greatest=1e6),
    "rad/s": Unit("rad_s", "rad/s", least=1e-12, greatest=1e6, engineering=("rpm", 30.0 / math.pi)),
    "rad/s^2": Unit("rad_s2", "rad/s²", least=1e-12, greatest=1e9),
    "kg/m^3": Unit("kg_m3", "kg/m³", least=1e-6, greatest=1e6),
    "s (m/s)^0.2": Unit("", "s (m/s)^0.2", least=1e-12, greatest=1e6),
    "N s/m^1.25": Unit("", "N s/m^1.25", greatest=1e15),
}
LONGEST = 64  # characters of a number with its unit: matching longer texts would take long
LEAST_ENGINEERING = 1e-3  # in an engineering unit: smaller values have the SI unit with a prefix
LEAST_PREFIXED = 10.0  # of kilo and above: 2000 N stay so, 20 000 N are 20 kN
NEGLIGIBLE = 0.05  # of its error: a figure below it is 0
NEAR = 4  # rows of a table: figures of one unit so near each other have the same prefix
_WITH_UNIT = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s.+-].{0,11}|1/\w{1,3})")
_SPELLINGS = {"deg": "°", "degree": "°", "degrees": "°", "1/min": "rpm", "U/min": "rpm", "min^-1": "rpm"}
_SPELLINGS |= {f"{prefix}Nm": f"{prefix}N m" for prefix in PREFIXES} | {"Nmm": "N mm"}
FURTHER_UNITS = {  # units of the field beside those of SI and its prefixes
    "1": {"%": 1e-2},
    "m": {"cm": 1e-2},
    "s": {"min": 60.0, "h": 3600.0},
    "kg": {"g": 1e-3, "mg": 1e-6},
    "kg m": {"g mm": 1e-6, "kg mm": 1e-3},
    "kg m^2": {"g mm²": 1e-9, "kg mm²": 1e-6},
    "N/m": {"N/mm": 1e3},
    "kg/m^3": {"g/cm³": 1e3},
    "m^2/s": {"cSt": 1e-6},
    "1/Pa": {"1/GPa": 1e-9},
}
_LONGEST_FIRST = sorted((unit for unit in UNITS.values() if unit.suffix), key=lambda unit: -len(unit.suffix))
_SHOWN = {unit.shown: unit for unit in UNITS.values() if unit.shown}
_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(  # a number with its unit in a sentence, also `1 ± 2 N m` and `1 to 2 rad/s`
    rf"(?<![\w.,^/-])({_NUMBER}(?:(?: ± | to ){_NUMBER})*) "
    rf"({'|'.join(map(re.escape, sorted(_SHOWN, key=len, reverse=True)))})(?![\w/^²³]|\.\w| (?:s|m)/|-\w)"
)
_SCENE_VALUE = re.compile(r"\w\.\w+ = ")  # the values of keys in such a sentence are SI


def label_and_unit(key: str) -> tuple[str, str]:
    """(label, unit as shown) of an SI-suffixed key: `normal_load_inner_n` is ("normal load inner", "N")."""
    label, unit = _label_and_row(key)
    return label, unit.shown


def digits_of(key: str) -> int:
    """Digits of an SI-suffixed key that are shown at most."""
    return _DIGITS.get(key, _label_and_row(key)[1].digits)


def unit_suffix(key: str) -> str:
    """The end of an SI-suffixed key that states its unit, as `_rad_s`; empty where there is none."""
    _, unit = _label_and_row(key)
    return f"_{unit.suffix}" if unit.suffix else ""


def readable_label(key: str, size: float) -> tuple[str, str, float]:
    """(label, engineering unit, factor into it) of an SI-suffixed key whose values are up to `size`."""
    label, unit = _label_and_row(key)
    return label, *_readable_unit(unit, size)


def readable_unit(unit: str, size: float) -> tuple[str, float]:
    """(engineering unit, factor into it) of values of up to `size` in a declared unit; itself where it is unknown."""
    return _readable_unit(UNITS[unit], size) if unit in UNITS else (unit, 1.0)


def _readable_unit(unit: Unit, size: float) -> tuple[str, float]:
    if unit.engineering and not (unit.prefixes and 0.0 < size * unit.engineering[1] < LEAST_ENGINEERING):
        return unit.engineering
    factor, shown = prefixed_unit(size or PREFIXES[unit.zero], unit.shown)
    return shown, factor


def unit_choice_sizes(sizes: Mapping[str, float]) -> dict[str, float]:
    """The size by which the unit of each SI-suffixed key is chosen: a 0 has that of a key near it of its unit."""
    keys, chosen = list(sizes), dict(sizes)
    for row, key in enumerate(keys):
        if sizes[key] == 0.0:
            near = [other for other in keys[max(row - NEAR, 0) : row + NEAR + 1] if sizes[other]]
            alike = [other for other in near if unit_suffix(other) == unit_suffix(key)]
            distances = [(abs(keys.index(other) - row), sizes[other]) for other in alike]
            chosen[key] = min(distances, default=(0, 0.0))[1]
    return chosen


LUBRICATED = "lubricant"  # among what is not known of a result: it is of films, not of dry contacts
_DRY = {"drive torque (dry contacts)": "drive torque", "dry-contact friction torque": "friction torque"}
_LABELS = {  # of keys whose names do not say enough
    "drive_torque_nm": "drive torque (dry contacts)",
    "friction_torque_nm": "dry-contact friction torque",
    "catalogue_drive_torque_nm": "drive torque (catalogue estimate, ± 50 %)",
    "begins_s": "log begins at",
    "ring_displacement_m": "ring displacement x, y, z",
    "ring_displacement_range_m": "ring displacement range x, y, z",
    "ring_force_n": "ring force x, y, z",
    "ring_force_range_n": "ring force range x, y, z",
    "ring_moment_nm": "ring moment x, y",
    **{f"{line}_over_noise_db": f"{line.upper()} over noise" for line in ("bpfo", "bpfi", "bsf")},
}
_DIGITS = {"catalogue_drive_torque_nm": 2}  # of keys whose values are estimates


@functools.lru_cache(maxsize=1024)
def _label_and_row(key: str) -> tuple[str, Unit]:
    for unit in _LONGEST_FIRST:
        if key.endswith(f"_{unit.suffix}") and len(key) > len(unit.suffix) + 1:
            return _LABELS.get(key) or key.removesuffix(f"_{unit.suffix}").replace("_", " "), unit
    return key.replace("_", " "), UNITS["1"]


def label_in_result(label: str, unknown: Mapping[str, str]) -> str:
    """The label of a key in a result with these `errors_unknown`: dry contacts are named where they have no films."""
    return _DRY.get(label, label) if LUBRICATED in unknown else label


def key_suffix(unit: str) -> str:
    """The suffix of keys whose values are in `unit`, as `_rad_s`; empty for numbers without one and for rare units."""
    row = UNITS.get(unit)
    return f"_{row.suffix}" if row and row.suffix else ""


def key_unit(key: str) -> str:
    """The symbol that declarations use for the unit of an SI-suffixed key."""
    row = _label_and_row(key)[1]
    return next(symbol for symbol, unit in UNITS.items() if unit is row)


def with_unit(unit: str) -> str:
    """A unit to append to a number or label; nothing where there is none."""
    return f" {unit}" if not _is_dimensionless(unit) else ""


def si_value(text: str, unit: str) -> float | None:
    """The value in SI of a number written with its unit, such as `3000rpm`, `13 um` or `60 °C`.

    Parameters
    ----------
    text : str
        A number and a unit: that of SI, with a prefix, or one of the field (`FURTHER_UNITS`).
    unit : str
        The SI unit in which the value is declared.

    Returns
    -------
    float or None
        None where the text has no unit, or one of another dimension.
    """
    number, symbol = _number_and_unit(text)
    if unit not in UNITS or not symbol:
        return None
    if unit == "K" and symbol in ("°C", "C"):
        return number + CELSIUS
    factors = _factors(unit)
    if symbol not in factors and symbol[0] not in "mM":  # KN is kN, but mn may be mN or MN
        symbol = next(iter(units_in_other_case(text, unit)), symbol)
    return float(f"{number * factors[symbol]:.15g}") if symbol in factors else None


def units_in_other_case(text: str, unit: str) -> list[str]:
    """Units of this dimension that differ from the one in the text in the case of letters alone."""
    symbol = _number_and_unit(text)[1].lower()
    return [name for name in _factors(unit) if name.lower() == symbol] if unit in UNITS else []


def _number_and_unit(text: str) -> tuple[float, str]:
    """The number in a text and its unit, "" without one."""
    match = _WITH_UNIT.fullmatch(text.strip()) if len(text) <= LONGEST else None
    return (float(match[1]), _canonical(match[2])) if match else (math.nan, "")


@functools.cache
def accepted_units(unit: str) -> tuple[str, ...]:
    """Units that a number declared in `unit` may be written with, the usual prefixes among them; that of SI first."""
    row = UNITS.get(unit, UNITS["1"])
    prefixed = (prefix + row.shown for prefix in "kmµ" if prefix in row.prefixes)
    names = [row.shown, *(row.engineering or ())[:1], *prefixed]
    names += ["°C"] if unit == "K" else FURTHER_UNITS.get(unit, ())
    return tuple(dict.fromkeys(name for name in names if name))


@functools.cache
def _factors(unit: str) -> dict[str, float]:
    """Factor into SI of each way to write a unit; prefixes belong to a first unit that has no power."""
    row, factors = UNITS[unit], {}
    names = {_canonical(name) for name in (unit, row.shown)} - {"", "1"}
    for name in names:
        takes_prefix = not name.startswith(("kg", "K", "1/", "h", "Mrev")) and not re.match(r"\w+[²³]", name)
        factors |= {prefix + name: factor for prefix, factor in PREFIXES.items() if takes_prefix or not prefix}
    if row.engineering:
        factors[row.engineering[0]] = 1.0 / row.engineering[1]
    return factors | FURTHER_UNITS.get(unit, {})


def _canonical(symbol: str) -> str:
    """A unit as `UNITS` shows it: micro sign, powers, products."""
    symbol = re.sub(r"\s*[·*]\s*", " ", symbol.strip().replace("μ", "µ"))
    symbol = re.sub(r"(?<=[a-z])\^?([23])\b", lambda power: {"2": "²", "3": "³"}[power[1]], symbol)
    symbol = f"µ{symbol[1:]}" if re.match(r"u[a-zA-Z]", symbol) else symbol.replace("/um", "/µm")
    return _SPELLINGS.get(symbol, symbol)


def readable_sentence(text: str) -> str:
    """A sentence with its SI numbers in engineering units, to as many digits; one with `a.key = 1` is left unchanged.

    Sentences on a run are in SI, as its figures are; this is their form beside a table in engineering units.
    """
    return text if _SCENE_VALUE.search(text) else _QUANTITY.sub(_readable_quantity, text)


def _readable_quantity(match: re.Match) -> str:
    numbers = re.findall(_NUMBER, match[1])
    shown, factor = _readable_unit(_SHOWN[match[2]], max(abs(float(number)) for number in numbers))
    if factor == 1.0:
        return match[0]
    return f"{re.sub(_NUMBER, lambda number: _to_same_digits(number[0], factor), match[1])} {shown}"


def _to_same_digits(number: str, factor: float) -> str:
    digits = len(re.sub(r"[eE].*|\D", "", number).lstrip("0"))
    exact = math.log10(factor).is_integer()
    return f"{float(f'{factor * float(number):.{max(digits, 1 if exact else 3)}g}'):.12g}"


def axis_label(label: str, unit: str) -> str:
    """The label of an axis: `load [N]`, without brackets where there is no unit."""
    return label if _is_dimensionless(unit) else f"{label} [{unit}]"


def inverse_unit(unit: str) -> str:
    """The unit of a density over this unit."""
    if _is_dimensionless(unit):
        return ""
    return f"1/({unit})" if " " in unit or "/" in unit else f"1/{unit}"


def prefixed_unit(size: float, unit: str) -> tuple[float, str]:
    """(factor, unit with prefix) by which values of up to `size` in `unit` become readable numbers."""
    row = UNITS.get(unit)
    if row is None or not row.prefixes or not 0.0 < size < math.inf:
        return 1.0, unit
    scales = {prefix: scale for prefix, scale in PREFIXES.items() if prefix in row.prefixes or not prefix}
    fitting = (prefix for prefix, scale in scales.items() if size >= scale * (LEAST_PREFIXED if scale > 1.0 else 1.0))
    prefix = next(fitting, [*scales][-1])
    return 1.0 / scales[prefix], f"{prefix}{unit}"


def rounded_to_error(value: float, error: float | None, digits: int = 6) -> str:
    """A number to the second digit of its error, and to `digits` digits of its own at most.

    Value and error are in the same unit; an error of None, 0 or without bound does not limit the digits. A value far
    below its error is 0.
    """
    if is_negligible(abs(value), error):
        return "0"
    plain = f"{float(f'{value:.{digits}g}') + 0.0:.{max(digits, 7)}g}"  # no -0, and no power of ten up to 1e7
    if not error or not math.isfinite(error) or not math.isfinite(value):
        return plain
    decimals = 1 - math.floor(math.log10(abs(error)))
    rounded = round(value, decimals) + 0.0
    if rounded and math.floor(math.log10(abs(rounded))) + decimals >= digits:
        return plain  # the error is finer than what is shown
    return f"{rounded:.{decimals}f}" if 0 <= decimals <= digits else f"{rounded:.{max(digits, 7)}g}"


def is_negligible(size: float, error: float | None) -> bool:
    """True for a figure of this size that is 0 within its error."""
    return error is not None and math.isfinite(error) and size < NEGLIGIBLE * abs(error)


def greatest_error(error) -> float | None:
    """The error of a figure, of a list the greatest; None where it is not known."""
    return max(error) if isinstance(error, (list, tuple)) else error


def two_digits(number: float) -> str:
    """A number of two digits, as for an error, written out up to a million."""
    return f"{float(f'{number:.2g}'):g}"


def _is_dimensionless(unit):
    return unit in ("", "1")
