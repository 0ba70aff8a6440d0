"""A ball bearing: the names that other rooms and tests use, each with its module and what it is.

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

FACE = {
    # The scene
    "Geometry": "parameters: the keys of the section geometry",
    "GIVES": "parameters: what elastic laws may depend on in a bearing",
    "CONTROLS": "rings: raceway controls of balls in equilibrium, with shares of the gyroscopic moment",
    "land_radius": "rings: radius of the land that guides a cage",
    "cage_needed": "models: why balls without a cage would bunch up",
    "choose": "models: law, dimension, friction and stepper by the rules",
    # The catalogue, ratings and geometry
    "FOUND": "catalogue: ways in which ball sets of rows were found",
    "DEEP_GROOVE": "catalogue: the rule of ball sets of deep groove bearings",
    "ANGULAR_CONTACT": "catalogue: the rule of ball sets of angular-contact bearings",
    "Entry": "catalogue: one row",
    "entries": "catalogue: all rows by designation",
    "designations": "catalogue: all designations",
    "catalogue_scenes": "catalogue: the scene of each designation",
    "add_file": "catalogue: adds the rows of a file",
    "read_entries": "catalogue: the rows of one file's data",
    "by_rule": "catalogue: number and diameter of balls by the rule",
    "row_of": "catalogue: a row as plain data",
    "catalogue_sheet": "ratings: a row with ratings and fault frequencies",
    "frequency_errors": "ratings: errors of fault frequencies by those of the ball set",
    "Ratings": "ratings: basic dynamic and static rating",
    "ratings_of": "ratings: ratings of a scene",
    "basic_dynamic_rating": "ratings: C of ISO 281",
    "basic_static_rating": "ratings: C_0 of ISO 76",
    "equivalent_load": "ratings: P of ISO 281",
    "static_load": "ratings: P_0 of ISO 76",
    "reference_life": "ratings: L_10r of ISO/TS 16281",
    "lives_of": "ratings: lives and static safety under a load",
    "hours_of": "ratings: a life in hours",
    "LIMITING": "ratings: n d_m at limiting speeds, by lubrication",
    "LIMITING_SCATTER": "ratings: relative scatter of these",
    "limiting_speeds": "ratings: limiting speeds of a bearing",
    "BASE_VISCOSITY": "ratings: viscosity that Palmgren's estimate takes by default",
    "OIL_BATH": "ratings: Palmgren's f_0 in an oil bath",
    "TORQUE_SCATTER": "ratings: relative scatter of Palmgren's estimate",
    "palmgren_torque": "ratings: friction torque by Palmgren",
    "operating_geometry": "geometry: a scene's geometry with its operating clearance",
    "clearance_of": "geometry: the operating clearance by cause",
    "nominal_curvatures": "geometry: curvatures of both contacts at contact angle zero",
    "cage_speed": "geometry: orbit speed of balls that roll",
    "roll_rate": "geometry: speed of such balls about their own centres",
    # Equilibrium
    "Support": "equilibrium: which coordinates of the ring are free, their loads, and where others are held",
    "Setting": "equilibrium: the numbers of an equilibrium",
    "EquilibriumSolver": "equilibrium: equilibria of one bearing with balls at given azimuths",
    "NOTHING_CARRIES": "equilibrium: the core's status where no ball touches both rings",
    "Equilibria": "equilibrium: equilibria under many loads",
    "solved_cases": "equilibrium: equilibria under many loads of several scenes",
    "azimuths_on": "equilibrium: azimuths of loads",
    "setting_of": "equilibrium: the numbers of a scene's equilibrium",
    "support_of": "equilibrium: the support that a scene gives its ring",
    "solver_of": "equilibrium: the solver of a scene",
    "azimuths_of": "equilibrium: azimuths of evenly spaced balls",
    "load_line": "equilibrium: azimuth of what pushes the ring",
    "controlled": "equilibrium: an equilibrium with the raceway control of the scene",
    "control_reason": "equilibrium: why it has this control",
    "scene_equilibrium": "equilibrium: the equilibrium under the scene's own load",
    "loose_directions": "equilibrium: free coordinates that nothing holds",
    "equilibrium_error": "equilibrium: difference of loads from balls that move, over the greatest load",
    "answer_of": "equilibrium_report: what `bearing_twin bearing` gives out",
    "natural_frequencies": "equilibrium_report: those of a mass on the ring's stiffness",
    "curves_of": "equilibrium_report: equilibria over a sweep",
    "response_of": "model_error: what contacts that are too stiff do to an equilibrium",
    "response_to_tilt": "model_error: what a true tilt changes against one of first order",
    "draw_equilibrium": "picture: loads, angles and pressures around the bearing",
    "draw_sweep": "picture: curves over a sweep",
    # Motion
    "bearing_motion": "motion: what moves a scene by the chosen model",
    "BearingMotion": "motion: balls that move by their equations of motion",
    "bearing_of": "system: the numbers of the equations of motion",
    "RingDrive": "system: prescribed turning of the inner ring",
    "Loading": "system: loads over time",
    "rates": "integrate: rates of all balls in a state",
    "start_state": "motion: the state from which balls start",
    "stability_limits": "integrate: longest stable steps of a fixed-step method",
    "stable_step": "integrate: a step well inside them",
    "mend_of_method": "models: what reduces the error of the method",
    # Columns of a ball's state, and of the state of ring, cage and shaft
    "AXIS_DISTANCE": "system: distance of the ball from the axis",
    "ORBIT_ANGLE": "system: its azimuth",
    "HEIGHT": "system: its place along the axis",
    "VELOCITY": "system: the first of its velocity (radial, tangential, axial)",
    "RADIAL_VELOCITY": "system: the same",
    "TANGENTIAL_VELOCITY": "system: the second of its velocity",
    "SPIN": "system: the first of its angular velocity (radial, tangential, axial)",
    "AXIAL_SPIN": "system: the third of its angular velocity",
    "MOTION": "system: how many columns are motion",
    "COLUMNS": "system: how many there are",
    "BODY_COLUMNS": "system: length of the state of ring, cage and shaft",
    "PLACES": "system: how many places of ring and cage",
    "CAGE": "system: the cage's angle",
    "CAGE_X": "system: the place of the cage's centre along x",
    "CAGE_Y": "system: the place of the cage's centre along y",
    "LAND_WORK": "system: work of the drive through the cage's land",
    "SHAFT_ANGLE": "system: angle of a shaft that a torque turns",
    "SHAFT_SPEED": "system: its speed",
    # Parts of a shaft on two bearings
    "completed": "catalogue: the data of a scene with the rows of the catalogue filled in",
    "Fits": "geometry: the keys of the section fits",
    "Temperatures": "geometry: the keys of the section temperatures",
    "BearingContact": "parameters: the keys of the section contact",
    "GivenRatings": "parameters: the keys of the section ratings",
    "Materials": "parameters: the keys of the section materials",
    "RELAXATION_TIME": "parameters: the viscous part of a contact by default",
    "GREATEST_ANGLE": "parameters: the greatest contact angle of a scene",
    "GREATEST_SQUEEZE": "parameters: the greatest approach of both contacts of a ball, in ball diameters",
    "Cage": "rings: the keys of the section cage",
    "Drive": "rings: the keys of the section drive",
    "LoadChange": "rings: the keys of a change of load",
    "Model": "rings: the keys of the section model",
    "SpeedChange": "rings: the keys of a change of speed",
    "load_table": "rings: the key of loads over time",
    "steady_load": "rings: the key of a steady force",
    "steady_moment": "rings: the key of a steady moment",
    "EVEN": "rings: the cage that spaces balls evenly",
    "QUASI_STATIC": "rings: the dimension of runs of equilibria",
    "SPEED": "rings: the drive by a prescribed speed",
    "Contacts": "equilibrium: contacts of balls in equilibrium",
    "COORDINATES": "equilibrium: number of coordinates of a ring",
    "SPEED_COLUMN": "equilibrium: place of the speed in the numbers of a ring",
    "STOP": "equilibrium: type of the flag that stops the core",
    "IDLE": "equilibrium: share of the greatest load below which the angle of a contact has no limit",
    "LONGEST": "equilibrium: greatest displacement, in ball diameters",
    "OVERLOAD": "equilibrium: the reason of a failure where nothing carries the loads",
    "TRIED_PLACES": "equilibrium: number of places of the balls at which a commanded load is tried",
    "tried_at": "equilibrium: azimuth of a ball at one of these places",
    "commanded_loads": "equilibrium: a commanded load as an array",
    "check_goal": "equilibrium: refuses a drive's goal that is none",
    "limits_used": "equilibrium: approach and contact angle over their limits",
    "shared": "equilibrium: mean over balls by their load, as of their orbit speeds",
    "ellipses_of": "equilibrium: contact ellipses of an equilibrium",
    "half_space_error": "model_error: relative error of a contact's load, since bodies are no half-spaces",
    "nominal_law_error": "models: error of a law's load at the nominal contacts",
    "command_warning": "ratings: a warning of a speed above the limiting one",
    "contact_flags": "figures: warnings of contacts",
    "ring_attitude": "outputs: orientation of a ring that is tilted and has turned",
    "method_numbers": "system: an integration method as the core takes it",
    "SAME": "system: relative difference of times below which they are one",
    "apart": "system: times that differ, in order",
    # Outputs and figures
    "renewed": "outputs: gives outputs of old logs the signs of today's",
    "contact_details": "outputs: contact ellipses and pressures of outputs",
    "contacts": "outputs: every contact as one row",
    "origins": "outputs: origins of the bodies' frames",
    "wrenches": "outputs: wrenches on balls and rings",
    "BearingFigures": "figures: the figures of a run, block by block",
    "missing": "quantities: figures that a scene lacks",
    "BearingPicture": "picture: the picture of a run",
    # Lubricant
    "viscosity_of": "lubricant: viscosity at a temperature",
    "film_lubricant": "lubricant: the numbers of a scene's lubricant",
    "film_numbers": "lubricant: the numbers of films of contacts",
    "films": "lubricant: thickness, resistance and friction of films",
    "contact_torque": "friction_torque: friction torque contact by contact",
    "skf_torque": "friction_torque: friction torque by SKF",
}

__all__ = ["BEARING", "BearingScene", *FACE]


def __getattr__(name: str):
    if name not in FACE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = FACE[name].partition(":")[0]
    return getattr(importlib.import_module(f"{__name__}.{module}"), name)
