"""The one table of units: the suffix of a key, the unit of a channel, and how people read it."""

SUFFIXES = {  # longest first, so that the first that fits is the right one
    "_rad_s": "rad/s",
    "_m_s2": "m/s^2",
    "_m_s": "m/s",
    "_nms": "N m s",
    "_nm": "N m",
    "_pa": "Pa",
    "_hz": "Hz",
    "_ns": "N s",
    "_rad": "rad",
    "_kg": "kg",
    "_n": "N",
    "_m": "m",
    "_s": "s",
    "_j": "J",
    "_w": "W",
}


def suffix_of(unit: str) -> str:
    """The suffix of keys whose values are in `unit`; empty for numbers without one and for rare units."""
    return next((suffix for suffix, known in SUFFIXES.items() if known == unit), "")
