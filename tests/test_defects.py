"""Waviness and spalls: published displacements, waves of all orders, models and methods alike, lines of a run."""

import copy
import itertools

import numpy as np
import pytest
from runs import reported, run_all

from bearing_twin import SceneError, load_scene, simulate
from bearing_twin.kinds.bearing.equilibrium import scene_equilibrium
from bearing_twin.kinds.contract import STORED
from bearing_twin.run.scene import choose

STEEL = {"young_modulus": 207.5e9, "poisson_ratio": 0.3}
RIG = {
    "kind": "bearing",
    "name": "rig",
    "geometry": {"radial_clearance": 0.0},
    "materials": dict.fromkeys(("ball", "inner_ring", "outer_ring"), STEEL),
    "contact": {"normal": "hertz"},
    "gravity": [0, 0, 0],
    "drive": {"speed": 0.0},
    "model": {"dimension": "quasi_static"},
}


def scene_of(changes: dict, defects=()):
    mapping = copy.deepcopy(RIG) | {"defects": list(defects)}
    for key, value in changes.items():
        section, _, name = key.rpartition(".")
        mapping[section or name] = {**mapping.get(section, {}), name: value} if section else value
    return load_scene(mapping)


def equilibrium(changes, defects=()):
    scene = scene_of(changes, defects)
    return scene_equilibrium(scene.parameters, choose(scene).law)


RADIAL = {  # the public rig of a 6203: 8 balls of 6.75 mm on 28.55 mm
    "geometry": {"ball_diameter": 6.75e-3, "pitch_diameter": 28.55e-3, "radial_clearance": 0.0},
    "rings": {"inner": {"free": "radial", "load": [400.0, 0, 0]}},
}


def pit(on="outer", place=0.0, length=1.5e-3, **sizes):
    return {"on": on, "spall": {"place": place, "length": length, **sizes}}


def test_a_ring_over_a_pit_stands_where_published_programs_have_it():
    """6203, no clearance, 400 N, ball 0 on the load line: flat pits under ball 0, and one too deep to reach (m)."""
    for defects, displacement in (
        ((), 8.6461e-6),
        ((pit(depth=1e-6),), 9.1822e-6),
        ((pit(depth=4e-6),), 10.7034e-6),
        ((pit("inner", depth=4e-6),), 10.7034e-6),
        ((pit(depth=3e-6), pit("inner", depth=1e-6)), 10.7034e-6),
        ((pit(length=2e-3),), 14.5773e-6),
    ):
        rel = 2e-4 if displacement < 12e-6 else 1e-3  # their grooves do not go back beside a ball
        assert equilibrium(RADIAL, defects).coordinates[0] == pytest.approx(displacement, rel=rel), defects


def test_a_ball_drops_as_far_as_the_edges_let_it_and_no_further():
    """Under a ring that is held, of a spall of 1 mm: outer and inner raceway (m); half of it for a pit half as wide."""
    held = {"drive.offset": [0.0, 0.0, 0.0], "geometry.radial_clearance": -12e-6}
    smooth = equilibrium(held).contacts.approach[0].sum()
    for on, drop in (("outer", 30.170e-6), ("inner", 48.763e-6)):
        approaches = [
            equilibrium(held, [pit(on, length=1e-3, depth=d)]).contacts.approach[0].sum() for d in (60e-6, 1e-3)
        ]
        assert smooth - approaches[0] == pytest.approx(drop, rel=2e-3)
        assert approaches[0] == approaches[1]
    narrow, wide = (equilibrium(held, [pit(depth=1e-6, width=w)]).contacts.approach[0].sum() for w in (0.1e-3, 0.0))
    assert 0.0 < smooth - narrow < 0.6e-6 < smooth - wide


def test_waves_of_the_orders_next_to_multiples_of_the_balls_move_the_ring_sideways_and_no_others():
    """Preloaded 6203 under constant axial load, 0.2 um: 0.19987 um where the ring may tilt, 0.20013 um where not."""
    geometry = {"geometry.radial_clearance": -6e-6}
    pushed = float(equilibrium({**geometry, "drive.offset": [0, 0, 10e-6]}).loads[2])
    for free, size in (("all", 0.19987e-6), ("displacement", 0.20013e-6)):
        loaded = {**geometry, "rings": {"inner": {"free": free, "load": [0.0, 0.0, pushed]}}}
        smooth = equilibrium(loaded).coordinates
        for on, order in itertools.product(("inner", "outer"), (2, 3, 5, 6, 7, 8, 9, 10, 15, 17)):
            shift = equilibrium(loaded, [{"on": on, "waviness": [order, 0.2e-6, 0.7]}]).coordinates - smooth
            sideways, is_next = float(np.hypot(*shift[:2])), order % 8 in (1, 7)
            assert sideways == (pytest.approx(size, rel=1e-3) if is_next else pytest.approx(0.0, abs=1.2e-11)), order
            if order == 8:
                assert abs(shift[2]) > 1e-7
            else:
                assert shift[2] == pytest.approx(0.0 if is_next else -0.0063e-6, abs=1e-10)


def outputs(scene):
    return run_all(scene)[1].values


FREE = {
    "rings": {
        "inner": {
            "free": "radial",
            "load": [0.0, -400.0, 0.0],
            "mass": 0.5,
            "support": {"damping": [500.0, 500.0, 500.0]},
        }
    },
    "model.dimension": "free",
    "cage": {"kind": "even"},
    "solver": {"check": "none"},
    "wanted": {"tolerance": 1e-6},
}


def test_a_ring_creeping_over_a_pit_passes_through_equilibria():
    run = {"run": {"duration": 0.2, "output_rate": 1000.0}, "drive.speed": 1.0}
    in_equilibrium = {"rings": {"inner": {"free": "radial", "load": [0.0, -400.0, 0.0]}}}
    for on in ("outer", "inner"):
        defects = [pit(on, place=-np.pi / 2 + 0.03, length=1e-3, depth=1e-6)]
        moving, standing, smooth = (
            outputs(scene_of({**changes, **run}, with_defects))
            for changes, with_defects in ((FREE, defects), (in_equilibrium, defects), (in_equilibrium, ()))
        )
        offset, balanced, level = (values["inner_ring_offset"][:, 1] for values in (moving, standing, smooth))
        assert np.ptp(balanced - level) > 0.4e-6
        angles = (
            values["orbit_angle"][:, 0] for values in (moving, standing)
        )  # at the same places: moving balls creep
        assert np.abs(offset - np.interp(*angles, balanced)).max() < 2e-4 * 8.7e-6


def test_every_method_drives_over_defects_alike_and_energy_closes():
    defects = [pit(place=0.05, length=0.6e-3, depth=3e-6), {"on": "inner", "waviness": [9, 0.2e-6, 0.0]}]
    shared = {
        "geometry.radial_clearance": -6e-6,
        "drive.speed": 183.26,
        "model.dimension": "prescribed",
        "run": {"duration": 2e-3, "output_rate": 20_000.0},
    }
    loads_by_stepper = {}
    for stepper in ("rodas4", "rodas3", "dopri5", "imex", "dop853"):
        scene = scene_of(
            {**shared, "solver": {"stepper": stepper, "check": "none"}, "wanted": {"tolerance": 1e-6}}, defects
        )
        values = outputs(scene)
        loads_by_stepper[stepper] = values["normal_load"]
        gained = sum(values[name][-1] - values[name][0] for name in STORED)
        supplied = values["drive_work"][-1] - values["dissipated"][-1]
        assert gained == pytest.approx(supplied, abs=2e-4 * values["elastic_energy"][0]), stepper
    greatest = loads_by_stepper["dop853"].max()
    assert np.ptp(loads_by_stepper["dop853"][:, 0]) > 0.1 * greatest
    for stepper, loads in loads_by_stepper.items():
        assert np.abs(loads - loads_by_stepper["dop853"]).max() < 5e-3 * greatest, stepper


HIGH = "defects=[{on: outer, waviness: [9, 8e-6, 0.3]}, {on: inner, waviness: [17, 1e-6, 0.0]}]", "run.duration=0.02"
INCLINED = "geometry.radial_clearance=-7.5e-6", "drive.speed=54", "contact.normal=constant", "wanted.tolerance=1e-4"


@pytest.mark.parametrize(
    ("scene", "changes", "limit"),
    [
        # waves nearly as high as a contact is deep
        ("bearing_6203", HIGH, 1e-4),
        ("bearing_6203", (*HIGH, "cage.kind=even"), 1e-4),
        ("bearing_6203", (*HIGH, "drive.tilt=[1e-4,0]", "model.dimension=prescribed"), 1e-4),
        # of a ball under axial load, where its place turns by two components of the spin
        (
            "bearing_6205_spall_outer",
            ("sensor.on=none", "rings.inner.load=[0,-1000,400]", "defects=[{on: ball, waviness: [6, 5e-7, 0]}]",
             "run.duration=0.02"),
            2e-6,
        ),
        # contacts that wander off a narrow spall, as their way round the ball changes its latitude
        (
            "bearing_6203",
            (*INCLINED, "defects=[{on: ball, spall: {place: 1.0, length: 3e-4, depth: 1e-4}}]", "run.duration=0.012"),
            1e-5,
        ),
    ],
)  # fmt: skip
def test_work_over_defects_closes(scene, changes, limit):
    report = reported(scene, *changes, "solver.check=none")
    assert abs(report.figures["energy_closure"]) < limit


@pytest.mark.parametrize("changes", [(), ("cage.kind=even",)])
def test_the_energy_balance_of_balls_that_leave_a_wavy_raceway_closes_as_the_tolerance_falls(changes):
    """Loads then act no more while contacts still lose what they store, by a law whose force has a potential."""
    waves = "defects=[{on: outer, waviness: [9, 8e-6, 2.3]}]", "contact.normal=constant", "run.duration=0.002"
    missing = []
    for tolerance in (1e-4, 1e-5, 1e-6):
        settings = (*waves, *changes, "solver.check=none", f"wanted.tolerance={tolerance}")
        report = reported("bearing_6203", *settings)
        missing.append(abs(report.figures["energy_closure"]))
    assert missing[0] < 5e-5
    assert missing[2] < 0.1 * missing[0]


def test_a_ring_that_a_torque_drives_over_a_spall_has_no_energy_balance():
    spall = "defects=[{on: outer, spall: {place: -1.57, length: 0.5e-3, width: 0.5e-3, depth: 1e-5}}]"
    report = reported("bearing_6203_run_up", "run.duration=0.005", "cage.kind=even", spall)
    assert report.status == "done"
    assert report.figures["energy_closure"] is None


def test_a_ball_crosses_the_middle_of_a_pit_as_exactly_as_its_tolerance_says():
    """Where it strikes the other edge, just after the start; all balls share the steps of a ring that moves."""
    run = {"run": {"duration": 4e-4, "output_rate": 30_000.0}, "drive.speed": 24.61}
    middle = pit(place=8e-4 - np.pi / 2, length=0.5e-3, depth=1e-5)
    loads, exact = (
        outputs(scene_of({**FREE, **run, "wanted": {"tolerance": tolerance}}, [middle]))["normal_load"]
        for tolerance in (1e-5, 1e-8)
    )
    assert np.ptp(exact[:, 6, 1]) > 0.2 * exact.max()
    assert np.abs(loads - exact).max() < 2e-6 * exact.max()


SPEED, RATE = 183.26, 5000.0
AXIAL = {
    "geometry.radial_clearance": -6e-6,
    "drive": {"speed": SPEED, "offset": [0.0, 0.0, 1e-5]},
    "model.dimension": "prescribed",
    "run": {"duration": 1.0, "output_rate": RATE},
    "solver": {"check": "none"},
}


def line_of(signal, rate, frequency):
    """Amplitude at a frequency [Hz] of an array, by a Hann window."""
    window = np.hanning(len(signal))
    turned = np.exp(-2j * np.pi * frequency * np.arange(len(signal)) / rate)
    return 2.0 * abs(np.sum((signal - signal.mean()) * window * turned)) / window.sum()


def test_lines_of_spalls_and_none_of_a_sound_bearing_under_axial_load():
    per_turn = {"outer": 3.0538, "inner": 4.9462}  # of balls that roll at the contact angle of this load
    levels = {}
    for on in ("outer", "inner", ""):
        spalls = [pit(on, place=0.3, depth=1e-6, length=0.5e-3)] if on else []
        force = outputs(scene_of(AXIAL, spalls))["outer_ring_force"]
        for part, order in per_turn.items():
            frequencies = SPEED / (2 * np.pi) * order * np.linspace(0.99, 1.01, 201)
            lines = [line_of(force[:, 2], RATE, frequency) for frequency in frequencies]
            levels[on, part] = max(lines)
            if on == part:
                assert frequencies[int(np.argmax(lines))] == pytest.approx(SPEED / (2 * np.pi) * order, rel=3e-3)
    assert levels["", "outer"] < 1e-6 * levels["outer", "outer"]
    assert levels["inner", "outer"] < 0.05 * levels["inner", "inner"]


def test_from_entry_to_impact_a_ball_takes_the_time_of_kinematics():
    """Half of the length at the contact point's speed, L / (2 w_c R_o), of two lengths, whose edges are as smooth."""
    held = AXIAL | {"drive": {"speed": SPEED}, "run": {"duration": 2.2e-3, "output_rate": 1e6}}
    durations = []
    for length in (0.6e-3, 1.0e-3):
        squeezed = outputs(scene_of(held, [pit(place=0.07, length=length)]))["approach"][:, 0].sum(axis=1)
        entered = np.flatnonzero(squeezed < squeezed[0] - 0.3e-6)[0]
        durations.append(1e-6 * (np.argmin(squeezed) - entered))
    cage, radius = 0.5 * 183.26 * (1.0 - 6.746 / 28.5), 0.5 * (28.5e-3 + 6.746e-3)
    assert durations[1] - durations[0] == pytest.approx(0.4e-3 / (2.0 * cage * radius), rel=2e-2)


@pytest.mark.parametrize(
    ("defect", "message"),
    [
        ({"on": "outer"}, "waviness"),
        ({"on": "shaft", "waviness": [7, 1e-7, 0]}, "inner"),
        ({"on": "outer", "spall": {"length": 30e-3}}, "sixth"),
        ({"on": "outer", "spall": {"length": 1e-3, "width": 9e-3}}, "groove"),
        ({"on": "outer", "spall": {"length": 1e-3, "depth": -1e-3}}, "depth"),
        ({"on": "inner", "waviness": [7.5, 1e-7, 0]}, "whole"),
        ({"on": "inner", "waviness": [7, 1e-4, 0]}, "at most"),
        ({"on": "inner", "waviness": [4000, 1e-9, 0]}, "shorter"),
        ({"on": "inner", "waviness": [7, "100 rpm", 0]}, r"waviness\[1\] = '100 rpm' must be a number in m"),
        ("a pit", "list"),
    ],
)
def test_a_defect_that_no_bearing_has_is_refused(defect, message):
    with pytest.raises(SceneError, match=message):
        simulate(scene_of({"model.dimension": "prescribed", "geometry.radial_clearance": -6e-6}, [defect]))


def test_friction_on_waves_and_spalls_is_within_the_tolerance():
    wavy = "cage.kind=none", "run.duration=0.05", "defects=[{on: inner, waviness: [5, 1 um, 0]}]"
    assert reported("bearing_6203_rig_1000N", *wavy).status == "done"
    assert reported("bearing_6205_spall_inner", "run.duration=1.301").status == "done"


def test_waviness_has_the_unit_of_each_number():
    (defect,) = scene_of({}, [{"on": "inner", "waviness": [9, "0.2 um", "90 deg"]}]).parameters.defects
    assert defect.waviness == pytest.approx((9.0, 0.2e-6, 0.5 * np.pi))


def test_a_sound_bearing_under_radial_load_has_the_line_of_its_compliance():
    """6203, amplitudes of the ring's place at BPFO in line with the load and across (um), of two other programs."""
    rate = 1000.0
    for clearance, load, along, across in ((0.0, 400.0, 0.02870, 0.1378), (10e-6, 1000.0, 0.1376, 0.4674)):
        run = {"drive.speed": 20.0, "run": {"duration": 4.0, "output_rate": rate}}
        ring = {"inner": {"free": "radial", "load": [0.0, -load, 0.0]}}
        values = outputs(scene_of({"geometry.radial_clearance": clearance, "rings": ring, **run}))
        turns = np.ptp(values["orbit_angle"][:, 0]) / (2 * np.pi)
        passes = 8 * turns / (len(values["orbit_angle"]) - 1) * rate
        lines = [1e6 * line_of(values["inner_ring_offset"][:, axis], rate, passes) for axis in (1, 0)]
        assert lines == [pytest.approx(along, rel=2e-2), pytest.approx(across, rel=2e-2)]


def test_a_pit_on_a_ball_is_met_by_both_raceways_in_turn():
    axial = AXIAL | {"run": {"duration": 2.0, "output_rate": RATE}}
    force = outputs(scene_of(axial, [pit("ball", place=0.3, depth=1e-6, length=0.5e-3)]))["outer_ring_force"][:, 2]
    twice_spin = 183.26 / (2 * np.pi) * 3.98802
    frequencies = twice_spin * np.linspace(0.99, 1.01, 201)
    lines = [line_of(force, RATE, frequency) for frequency in frequencies]
    assert frequencies[int(np.argmax(lines))] == pytest.approx(twice_spin, rel=3e-3)
    assert line_of(force, 5000.0, 0.5 * twice_spin) < 0.5 * max(lines)
