"""A ball bearing; `BEARING` is its row in the table of kinds.

Of this room others may import:

* `parameters`: the scene (`BearingScene`) and its sections `Geometry`, `Materials`, `BearingContact`, `GivenRatings`;
  what laws may need (`LAW_NEEDS`), the default `RELAXATION_TIME`, and limits (`GREATEST_ANGLE`, `GREATEST_SQUEEZE`).
* `geometry`: `operating_geometry` with `Fits` and `Temperatures`, and `nominal_curvatures` of raceways.
* `rings`: sections `Cage`, `Drive`, `LoadChange`, `SpeedChange`, `Model`, with words for them (`EVEN`, `QUASI_STATIC`,
  `SPEED`); keys of loads (`steady_load`, `steady_moment`, `load_table`).
* `catalogue`: ball sets of designations, by tables and by rule.
* `ratings`: ratings, lives, limiting speeds and what catalogues print.
* `equilibrium`: equilibria of balls and ring under loads, and their contacts.
* `equilibrium_report`: results of an equilibrium (`answer_of`), of a sweep (`curves_of`), and `natural_frequencies`.
* `models`: the choice of a model by rules, errors of laws, warnings.
* `motion`: the motion of balls, ring and cage, `BearingMotion`, by chunks of `LONGEST_CHUNK` at most.
* `integrate`: the `rates` of the state of balls.
* `system`: numbers for the core: `Loading`, `method_numbers`, `distinct_times` that differ by more than `SAME`.
* `outputs`: `wrenches` on bodies about their `origins`, `contact_details`, `ring_attitude`, and
  `update_contact_angles` of earlier logs.
* `model_error`: `half_space_error` of contacts.
* `picture`: pictures of equilibria, `draw_equilibrium` and `draw_sweep`.

Private are `lubricant` and `friction_torque` of lubricated contacts, `defects` of raceways, `accelerometer` on the
housing, `equilibrium_motion` (runs of equilibria), `quantities` of studies, and `display` (topics, the browser).
"""

from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.contract import Kind, parts_in

BEARING = Kind(
    name="bearing",
    help="balls between two grooved raceways, the inner ring turning",
    parameters=BearingScene,
    **parts_in(
        __name__,
        choose="models:choose",
        motion="motion:bearing_motion",
        topics="display:topics",
        view="display:view",
        place_of="outputs:place_of",
        channels="outputs:channels",
        figures="figures:BearingFigures",
        records="accelerometer:tables",
        meanings="quantities:MEANINGS",
        model_errors="model_error:BearingErrors",
        commands="display:commands",
        quantities="quantities:quantities",
        comparison="model_error:BearingComparison",
        picture="picture:BearingPicture",
    ),
)
