"""A ball bearing: the names that other rooms and tests use, by module.

They are imported when they are first used, so that reading a scene loads no arrays. The modules, in the order in which
each imports earlier ones:

* `geometry`, `rings`, `catalogue`, `lubricant`, `defects`, `parameters`: a scene, without arrays;
* `ratings`: ratings, lives and what catalogues print; `friction_torque`: that of lubricated contacts;
* `system`: the numbers of the equations of motion for the core;
* `outputs`: channels, wrenches, contacts; `accelerometer`: what a sensor on the housing measures;
* `equilibrium`, `equilibrium_motion`: balls and ring in equilibrium, and runs of it;
* `integrate`, `motion`: balls that move;
* `models`: errors of the model's laws, its choice by rules, warnings;
* `quantities`, `figures`, `model_error`, `equilibrium_report`: results of runs and equilibria, and their errors;
* `display`, `picture`: what others see of it.

`BEARING` is the row in the table of kinds.
"""

import importlib

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

FACE = {  # module: names that others may use
    "geometry": "operating_geometry clearance_parts nominal_curvatures cage_speed roll_rate Fits Temperatures",
    "rings": """
        CONTROLS land_radius Cage Drive LoadChange Model SpeedChange load_table steady_load steady_moment EVEN
        QUASI_STATIC SPEED
    """,
    "catalogue": """
        FOUND DEEP_GROOVE ANGULAR_CONTACT Entry entries designations catalogue_scenes add_file read_entries by_rule
        row_of completed
    """,
    "lubricant": "viscosity_of film_lubricant film_numbers films",
    "parameters": """
        Geometry LAW_NEEDS BearingContact GivenRatings Materials RELAXATION_TIME GREATEST_ANGLE GREATEST_SQUEEZE
    """,
    "ratings": """
        catalogue_sheet frequency_errors row_in_use Ratings ratings_of basic_dynamic_rating basic_static_rating
        equivalent_load static_load reference_life lives_of hours_of LIMITING LIMITING_SCATTER limiting_speeds
        BASE_VISCOSITY TORQUE_SCATTER palmgren_torque command_warning
    """,
    "friction_torque": "contact_torque skf_torque",
    "system": """
        bearing_of RingDrive Loading AXIS_DISTANCE ORBIT_ANGLE HEIGHT VELOCITY RADIAL_VELOCITY TANGENTIAL_VELOCITY
        SPIN AXIAL_SPIN MOTION COLUMNS BODY_COLUMNS POSITIONS CAGE CAGE_X CAGE_Y LAND_WORK SHAFT_ANGLE SHAFT_SPEED
        method_numbers SAME distinct_times
    """,
    "outputs": "ring_attitude update_contact_angles contact_details contacts origins wrenches",
    "equilibrium": """
        Support Setting Equilibrium EquilibriumSolver Equilibria solve_scenes azimuths_on setting_of support_of
        solver_of azimuths_of load_line controlled_equilibrium control_reason scene_equilibrium loose_directions
        equilibrium_error Contacts COORDINATES SPEED_COLUMN STOP UNLOADED_SHARE GREATEST_COORDINATE OVERLOAD
        TRIAL_POSITIONS trial_azimuth commanded_loads check_goal limit_ratios load_weighted_mean ellipses_of
    """,
    "integrate": "rates stability_limits",
    "motion": "bearing_motion BearingMotion start_state",
    "models": "cage_needed choose mend_of_method nominal_law_error",
    "quantities": "missing",
    "figures": "contact_flags BearingFigures",
    "model_error": "response_of response_to_tilt half_space_error",
    "equilibrium_report": "answer_of natural_frequencies curves_of",
    "picture": "draw_equilibrium draw_sweep BearingPicture",
}
_HOMES = {name: module for module, names in FACE.items() for name in names.split()}
__all__ = ["BEARING", "BearingScene", *_HOMES]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
