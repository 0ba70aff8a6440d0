"""Shipped bearing scenes and variants of them, of `config/variants.yaml`: what chooser and companion are worth.

By name: the scene, and the overrides in which it differs. Then scenes drawn by chance, whose numbers were given before
anything of them was known: nothing of the companion was chosen by what they showed.
"""

from bearing_twin.charts.draws import draw_of
from bearing_twin.paths import share_path
from bearing_twin.shelf import SCENES

SPAN = 0.1  # s of a variant

_path = share_path("config", "variants.yaml")
_given = SCENES.load(SCENES.read_text(_path), _path.name)
_spans = _given.pop("spans")
_groups = {
    group: {name: (scene, tuple(differs)) for name, (scene, *differs) in rows.items()} for group, rows in _given.items()
}
CASES, VARIANTS, CHOSEN_LAST = (_groups[group] for group in ("known", "first", "chosen_last"))
_mending = {
    name: row for group, rows in _groups.items() if group not in ("known", "chosen_last") for name, row in rows.items()
}
UNSEEN = {
    name: (scene, (*differs, f"run.duration={_spans.get(name, SPAN)}"))
    for name, (scene, differs) in (_mending | CHOSEN_LAST).items()
}
FIRST_DRAWN, MANY = 20261128000, 24  # others than `chart drawn` has
OTHERWISE = ("run.duration=", "contact.normal=")  # the error of another law is told, and is in no reference of that law


def _drawn(number: int) -> tuple[str, tuple[str, ...]]:
    scene, differs, *_ = draw_of(FIRST_DRAWN + number)
    return scene, (*(word for word in differs if not word.startswith(OTHERWISE)), f"run.duration={SPAN}")


DRAWN = {f"drawn {number + 1}": _drawn(number) for number in range(MANY)}
GROUPS = {
    "Scenes known": CASES,
    "Scenes that showed what to mend": _mending,
    "Chosen last": CHOSEN_LAST,
    "Drawn by chance": DRAWN,
}
