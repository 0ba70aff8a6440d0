"""An inner ring with mass, and a cage: rings, balances, pockets, lands, loads from tables and commands."""

import json
import math

import numpy as np
import pytest
from bearings import AXIAL_PRELOAD, FREE, advanced, motion, stored_energy
from runs import reported, run_all

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.base.paths import restrict_reading
from bearing_twin.charts.scenes import last_overrides
from bearing_twin.kinds.bearing.equilibrium import solver_of, support_of
from bearing_twin.kinds.bearing.rings import land_radius
from bearing_twin.kinds.bearing.system import CAGE, CAGE_X, CAGE_Y, LAND_WORK, POSITIONS
from bearing_twin.kinds.contract import Output
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

RIG = "bearing_6203_rig_1000N"
ROLLING = 0.5 * 157.0796 * (1.0 - 6.75 / 28.55)
AT_REST = ("gravity=[0,0,0]", "contact.friction_coefficient=0.0", "drive.speed=0")
POCKETS = ("cage.kind=pockets", "cage.pocket_clearance=2e-4")


WORKS = (
    "kinetic_energy", "elastic_energy", "potential_energy", "dissipated", "gross_work", "inner_ring_load_work",
    "inner_ring_angle",
)  # fmt: skip


def fields_of(scene, block, name):
    """Fields of the messages of a topic at all outputs of a block."""
    [topic] = (topic_of_scene for topic_of_scene in topics(scene) if topic_of_scene.name == name)
    return topic.fields(Output(scene.parameters, "hertz", block.sample_rows(range(len(block)))))


def closure(out):
    """Energy made by the numbers over the work moved."""
    stored = stored_energy(out)
    numerical = np.ptp(stored[[0, -1]]) * np.sign(stored[-1] - stored[0])
    numerical += (out.dissipated - out.drive_work)[-1] - (out.dissipated - out.drive_work)[0]
    return numerical / (out.gross_work[-1] - out.gross_work[0])


def frequency(time, values):
    """Of an oscillation about its mean, by its crossings upwards [Hz]."""
    deviation = values - values.mean()
    before = np.flatnonzero((deviation[:-1] < 0.0) & (deviation[1:] >= 0.0))
    crossings = time[before] - deviation[before] * (time[before + 1] - time[before]) / (
        deviation[before + 1] - deviation[before]
    )
    return (len(crossings) - 1) / (crossings[-1] - crossings[0])


@pytest.mark.parametrize(
    ("step", "channel", "rate", "axis", "expected"),
    [
        ("load: [0,0,0.05]", "inner_ring_offset", "inner_ring_velocity", 2, 289.77),
        ("moment: [1.0e-5,0]", "inner_ring_tilt", "inner_ring_tilt_rate", 0, 192.83),
    ],
)
def test_a_shaft_rings_after_a_step_of_load(step, channel, rate, axis, expected):
    """0.5 kg and 1e-4 kg m^2 on the preloaded bearing, within 0.5 % of what the stiffness gives [Hz]."""
    moving = motion(
        *FREE, *AT_REST, "rings.inner.inertia=[1.0e-4,0]", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
        f"rings.inner.change={{time: 1e-4, {step}}}", "wanted.tolerance=1e-5",
    )  # fmt: skip
    out = advanced(moving, 2e-5, 2000)
    values = getattr(out, channel)[10:, axis]
    assert frequency(2e-5 * np.arange(10, 2000), values) == pytest.approx(expected, rel=5e-3)
    slope = np.gradient(values, 2e-5)[1:-1]
    assert getattr(out, rate)[11:-1, axis] == pytest.approx(slope, abs=2e-2 * np.abs(slope).max())
    if channel == "inner_ring_tilt":
        assert np.ptp(values) == pytest.approx(2.0 * 1e-5 / 147.4, rel=0.03)  # 172.4 - 4.78e4^2 / 9.137e7 N m/rad


@pytest.fixture(scope="module")
def rig():
    moving = motion(scene=RIG)
    return moving, advanced(moving, 1e-3, 60)


def test_the_rig_runs_in_balance(rig):
    """1000 N and the weight of 0.5 kg, within 1e-3 on average; balls evenly spaced, within 0.5 % of rolling."""
    _, out = rig
    expected = [0.0, 1000.0 + 0.5 * 9.80665, 0.0]
    assert out.inner_ring_force.mean(axis=0) == pytest.approx(expected, abs=1.0)
    assert np.diff(out.orbit_angle, axis=1) == pytest.approx(math.pi / 4.0, abs=1e-12)
    assert (out.orbit_angle[-1] - out.orbit_angle[0]) / 0.059 == pytest.approx(np.full(8, ROLLING), rel=5e-3)
    assert abs(closure(out)) < 1e-5
    assert out.cage_angle == pytest.approx(out.orbit_angle[:, 0], abs=1e-12)
    assert out.cage_slip == pytest.approx(1.0 - out.cage_speed / ROLLING, abs=1e-12)
    assert out.inner_ring_load[-1] == pytest.approx([0.0, -1000.0, 0.0])
    sag = -out.inner_ring_offset[:, 1]  # by statics 21.853 to 22.118 um under 1000 N, here 1004.9
    assert 21.85e-6 < sag.min() < sag.max() < 22.25e-6


def test_the_force_of_an_even_cage_is_what_turns_it(rig):
    """The pocket forces change the angular momentum of the cage, of inertia J_c, and of nothing else."""
    moving, _ = rig
    out = advanced(moving, 1e-6, 9)
    turning = moving.bodies.mass[5] * np.gradient(out.cage_speed, 1e-6)[1:-1]
    torque = (np.hypot(out.position[..., 0], out.position[..., 1]) * out.pocket_force).sum(axis=1)[1:-1]
    assert np.abs(torque + turning).max() < 0.05 * np.abs(torque).max()
    assert np.abs(out.pocket_force).max() > 1e-3


@pytest.mark.parametrize(
    ("scene", "overrides"), [(RIG, ()), (RIG, ("cage.kind=pockets",)), ("bearing_6203_unbalance", ())]
)
def test_the_torque_of_the_drive_is_what_is_lost_and_stored_less_the_work_of_the_loads(scene, overrides):
    """Over the last 50 outputs of 101: work over angle, which the noise of single outputs leaves alone."""
    report, block = run_all(scene, "run.duration=0.05", "run.output_rate=2000", *overrides)
    values = block.values
    change = {name: values[name][-1] - values[name][50] for name in WORKS}
    stored = change["kinetic_energy"] + change["elastic_energy"] + change["potential_energy"]
    turning = change["dissipated"] + stored - change["inner_ring_load_work"]
    torque = report.figures["drive_torque_nm"]
    tolerance = 1e-6 * (values["gross_work"][-1] - values["gross_work"][0])
    assert torque * change["inner_ring_angle"] == pytest.approx(turning, abs=tolerance)
    assert abs(change["inner_ring_load_work"]) > 1e-7


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("table", "[[0,0,0,0,0,0],[0.001,0,0,0,0,0],[0.0011,0,-1e9,0,0,0]]"),
        ("change", "{time: 0.001, load: [0,-1e6,0]}"),
    ],
)
def test_a_load_beyond_what_the_bearing_carries_ends_with_time_load_and_limit(key, value):
    """The limit is that of `bearing_twin bearing`, 2.44e4 N on the rig."""
    moving = motion(f"rings.inner.{key}={value}", scene=RIG)
    message = r"^at 0.001\d* s a load of \(0, -.*\) N pushes the ring through"
    with pytest.raises(IntegrationError, match=message) as caught:
        advanced(moving, 1e-4, 40)
    assert (caught.value.reason, caught.value.body) == ("overload", "inner ring")
    limit = float(str(caught.value).rsplit("(", 1)[1].split(",")[1])
    assert limit == pytest.approx(-2.44e4, rel=5e-3)


def test_pockets_keep_balls_within_their_clearance():
    moving = motion(*POCKETS, scene=RIG)
    out = advanced(moving, 1e-3, 60)
    room = 2e-4 / 28.55e-3  # half a clearance on either side, each over the pitch radius
    ahead = out.orbit_angle - out.cage_angle[:, None] - math.pi / 4.0 * np.arange(8)
    assert 0.5 * room < np.abs(ahead).max() < 1.05 * room
    assert np.abs(out.pocket_force).max() > 0.01
    assert out.inner_ring_force.mean(axis=0) == pytest.approx([0.0, 1004.9, 0.0], abs=1.0)
    assert (out.cage_angle[-1] - out.cage_angle[0]) / 0.059 == pytest.approx(ROLLING, rel=5e-3)
    assert abs(closure(out)) < 1e-5


def test_the_cage_says_its_angle_speed_and_torque():
    """On its topic; the torque is what changes its speed, but for the friction of the pockets."""
    assert "cage/state" not in {topic.name for topic in topics(load_scene("bearing_6203"))}
    scene = load_scene(RIG, ["cage.kind=pockets", "run.output_rate=1e5"])
    block, parameters = Simulation(scene).advance(800), scene.parameters
    fields = fields_of(scene, block, "cage/state")
    assert fields["name"] == ["cage_joint"]
    angle, speed, torque = (fields[name][:, 0] for name in ("position", "velocity", "effort"))
    assert np.array_equal(angle, block.values["cage_angle"])
    assert np.array_equal(speed, block.values["cage_speed"])
    inertia = parameters.cage.mass * (0.5 * parameters.geometry.pitch_diameter) ** 2  # of a thin ring
    momentum_rate = inertia * np.gradient(speed, 1e-5)
    assert np.abs(torque).max() > 1e-3
    assert np.corrcoef(momentum_rate, torque)[0, 1] > 0.99
    assert momentum_rate @ torque / (torque @ torque) == pytest.approx(1.0, rel=0.03)


def test_pockets_without_clearance_and_mass_are_an_even_cage():
    tight = ("cage.kind=pockets", "cage.mass=1e-5", "cage.pocket_clearance=0", "cage.friction=0", "cage.stiffness=1e7")
    tight_cage = advanced(motion(*tight, scene=RIG), 1e-3, 20)
    even = advanced(motion("cage.mass=0", scene=RIG), 1e-3, 20)
    assert tight_cage.inner_ring_offset == pytest.approx(even.inner_ring_offset, abs=1e-8)
    assert tight_cage.cage_speed[-1] == pytest.approx(even.cage_speed[-1], rel=1e-4)
    assert tight_cage.orbit_angle[-1] == pytest.approx(even.orbit_angle[-1], abs=1e-4)


def test_a_held_ring_with_a_cage_feels_balls_pass():
    """Held at -21.853 um without gravity: 974.7 to 1001.6 N, 988.2 N on average over a ball's passing."""
    held = ("model.dimension=prescribed", "rings.inner.load=[0,0,0]", "drive.offset=[0,-21.853e-6,0]")
    moving = motion(*held, "gravity=[0,0,0]", scene=RIG)
    advanced(moving, 5e-3, 4)
    count = 56
    force = advanced(moving, 2.0 * math.pi / 8.0 / ROLLING / count * 2.0, count).inner_ring_force[:, 1]
    assert force.mean() == pytest.approx(988.2, rel=1e-3)
    assert force.min() == pytest.approx(974.7, rel=1.5e-3)
    assert force.max() == pytest.approx(1001.6, rel=3e-3)


def test_moments_of_balls_hold_the_moment_on_a_ring_that_tilts():
    """Published moments are those by which its tilts move; at the contacts' own places they are 4 % off that."""
    ring = "rings.inner={free: all, mass: 0.5, inertia: [1e-4,1e-4], load: [0,-60,100], moment: [0.1,0.05]}"
    report, block = run_all("bearing_6203", "model.dimension=free", "cage.kind=even", "gravity=[0,0,0]", ring)
    assert np.abs(block[-1]["inner_ring_tilt"]).max() > 1e-4
    assert report.figures["ring_moment_nm"] == pytest.approx([-0.1, -0.05], rel=1e-3)


def test_loads_come_from_a_table(tmp_path):
    path = tmp_path / "loads.csv"
    path.write_text("time,x,y,z,mx,my\n0,0,-1000,0,0,0\n0.004,0,-1000,0,0,0\n0.006,0,-900,0,0,0\n")
    moving = motion("rings.inner.load=[0,0,0]", f"rings.inner.table={path}", scene=RIG)
    out = advanced(moving, 1e-3, 12)
    assert out.inner_ring_load[:, 1] == pytest.approx([-1000.0] * 4 + [-950.0] + [-900.0] * 7)
    assert out.inner_ring_force[-4:, 1].mean() == pytest.approx(904.9, rel=5e-3)
    assert abs(closure(out)) < 1e-5


def test_rows_of_a_table_however_near_are_a_jump():
    rows = "[0,0,-400,0,0,0],[0.004,0,-400,0,0,0]"
    near, distant = (
        advanced(motion(f"rings.inner.table=[{rows},[{time},0,-900,0,0,0]]", scene=RIG), 1e-3, 12)
        for time in ("0.004000000001", "0.00400001")
    )
    assert near.normal_load == pytest.approx(distant.normal_load, abs=1e-2 * distant.normal_load.max())
    assert near.inner_ring_load[-1, 1] == distant.inner_ring_load[-1, 1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,0,-1,0,0,0\n0,0,-2,0,0,0\n", "time must grow from row to row; 0 s follows 0 s"),
        ("0,0,-1,0,0,0\n1,0,nan,0,0,0\n", r"table\[1\]: y = 'nan' must be a number"),
        ("0,0,-1\n", "6 numbers a row, none left out"),
        ("", "it holds no row"),
        ("time [ms],x,y,z,mx,my\n10,0,-1,0,0,0\n", r"column 1 is named 'time \[ms\]', and is time in s"),
        ("time,y,x,z,mx,my\n10,0,-1,0,0,0\n", "column 2 is named 'y', and is x: the order is time, x, y, z, about x"),
        ("0;0;-1;0;0;0\n", "numbers are parted by commas, and have a point before their decimals"),
    ],
)
def test_a_table_that_is_not_one_is_refused(text, message, tmp_path):
    path = tmp_path / "loads.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=message) as caught:
        load_scene(RIG, [f"rings.inner.table={path}"])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "scene", [{"scene": RIG}, {"law": "hertz_differential"}], ids=["ring and cage", "a law with states"]
)
def test_a_motion_goes_on_from_a_snapshot_to_the_bit(scene):
    moving, resumed = motion(**scene), motion(**scene)
    if scene.get("scene") == RIG:
        moving.set_load((0.0, -900.0, 0.0), (0.0, 0.0))
    advanced(moving, 1e-3, 2)
    resumed.resume(json.loads(json.dumps(moving.snapshot())))
    assert advanced(moving, 1e-3, 2).numbers.tobytes() == advanced(resumed, 1e-3, 2).numbers.tobytes()


def test_tables_are_read_from_regular_files_and_never_for_somebody_else(tmp_path):
    path = tmp_path / "loads.csv"
    path.write_text("0,0,-1,0,0,0\n")
    with (
        restrict_reading([tmp_path], "the folders"),
        pytest.raises(SceneError, match="not read for this; give the rows"),
    ):
        load_scene(RIG, [f"rings.inner.table={path}"])
    with pytest.raises(SceneError, match="it is no file of at most"):
        load_scene(RIG, ["rings.inner.table=/dev/zero"])
    path.write_text("0,0,-1,0,0,0\n", encoding="utf-16")
    with pytest.raises(SceneError, match="it is not UTF-8 text; save it as CSV in UTF-8"):
        load_scene(RIG, [f"rings.inner.table={path}"])
    path.write_text("0,0,-1,0,0,0\n", encoding="utf-8-sig")
    assert load_scene(RIG, [f"rings.inner.table={path}"]).parameters.rings.inner.table == ((0, 0, -1, 0, 0, 0),)


def test_a_bearing_at_rest_in_a_cage_gains_no_energy():
    """Nothing moves: rounding was measured against the work of nothing, and the run was said to have failed."""
    report = reported("bearing_6203", "run.duration=0.02", "cage.kind=even", "drive.speed=0")
    assert "energy" not in report.status
    assert abs(report.figures["energy_closure"]) < 5e-3


def test_a_ring_free_to_tilt_settles_where_load_and_moment_balance():
    """Mean tilt and displacement over a ball's passing, against equilibria with the balls on their way.

    Without friction, which equilibria leave out: balls whose contact angle changes on their way slip along the axis.
    """
    keys = (
        "gravity=[0,0,0]", "contact.friction_coefficient=0",
        "rings.inner.free=all", "rings.inner.load=[0,-400,150]", "rings.inner.moment=[0.8,0.3]",
        "rings.inner.support={damping: [300,300,300], tilt_damping: 0.05}",
    )  # fmt: skip
    moving, count = motion(*keys, scene=RIG), 48
    advanced(moving, 5e-3, 8)
    passing = 2.0 * math.pi / 8.0 / ROLLING
    out = advanced(moving, 2.0 * passing / count, count)
    parameters = load_scene(RIG, keys).parameters
    coordinates = [
        solver_of(parameters, "hertz", float(angle)).solve(support_of(parameters)).coordinates
        for angle in out.orbit_angle[:, 0]
    ]
    mean = np.mean(coordinates, axis=0)
    assert np.abs(mean[3:]).min() > 1e-5
    assert out.inner_ring_tilt.mean(axis=0) == pytest.approx(mean[3:], rel=1e-3)
    assert out.inner_ring_offset.mean(axis=0) == pytest.approx(mean[:3], abs=5e-4 * np.abs(mean[:3]).max())


WEIGHT = 5e-3 * 9.80665  # N, of the cage
BY_LAND = ("cage.kind=pockets", "gravity=[0,-9.80665,0]")
# Balls that thrust holds, in the middle of pockets that they do not reach.
WITHOUT_BALLS = ("cage.pocket_clearance=3e-3", "rings.inner.load=[0,0,800]")


def caged(*overrides):
    return motion(*BY_LAND, *overrides, scene=RIG)


def test_a_cage_falls_onto_its_land_and_sags_by_its_weight_over_the_stiffness():
    moving = caged("cage.guidance=outer", *WITHOUT_BALLS, "drive.speed=0", "cage.friction=0", "cage.stiffness=1e5")
    moving.body_state[CAGE_Y] = 0.0  # it starts at rest in its land
    out = advanced(moving, 1e-3, 300)
    fallen = out.cage_offset[3, 1]
    assert fallen == pytest.approx(-0.5 * 9.80665 * 4e-3**2, rel=1e-6)
    assert out.cage_offset[-1] == pytest.approx([0.0, -(1e-4 + WEIGHT / 1e5)], abs=1e-9)
    assert out.land_force[-1] == pytest.approx([0.0, WEIGHT], abs=1e-4 * WEIGHT)


@pytest.mark.parametrize(("guidance", "side"), [("inner", 1.0), ("outer", -1.0)])
def test_sliding_on_its_land_turns_or_brakes_a_cage_by_coulomb_friction(guidance, side):
    """Torque mu m g times lever on the cage, mu m g R back on the ring; times its turn the work of the drive."""
    at_rest = ("initial.motion=rest", "contact.friction_coefficient=0", f"drive.speed={157.0796 if side > 0 else 0}")
    heavy = "cage.mass=0.5", "cage.inertia=1e-4"  # so that little else shakes it in its land
    moving = caged(f"cage.guidance={guidance}", *WITHOUT_BALLS, *at_rest, *heavy)
    moving.body_state[POSITIONS + CAGE] = 0.0 if side > 0 else 50.0
    first, out = moving.first_outputs(), advanced(moving, 1e-4, 10)
    radius, friction = land_radius(moving.parameters), 0.05
    assert radius == pytest.approx(0.5 * 28.55e-3 - side * 0.3 * 6.75e-3)
    torque = friction * 100.0 * WEIGHT * radius
    lever = radius + side * (1e-4 + 100.0 * WEIGHT / 1e6)  # to where they touch, from the cage's centre
    change = moving.body_state[POSITIONS + CAGE] - (0.0 if side > 0 else 50.0)
    assert change == pytest.approx(side * torque * lever / radius / 1e-4 * 1e-3, rel=2e-3)
    ring = first.inner_ring_torque[0, 2] if side > 0 else first.outer_ring_torque[0, 2]
    assert ring == pytest.approx(-side * torque, rel=1e-4)
    if side > 0:
        assert moving.body_state[LAND_WORK] == pytest.approx(torque * 157.0796 * 1e-3, rel=2e-3)
        turning = out.drive_work[-1] - out.inner_ring_load_work[-1]
        assert turning == pytest.approx(moving.body_state[LAND_WORK], rel=1e-9)
    else:
        assert moving.body_state[LAND_WORK] == 0.0


@pytest.mark.parametrize("guidance", ["inner", "outer", "balls"])
def test_energy_closes_and_forces_balance(guidance):
    """With all works and losses, after an unbalanced start: the cage falls, is hit by balls and whirls."""
    moving = caged(f"cage.guidance={guidance}", "wanted.tolerance=1e-6")
    moving.body_state[[POSITIONS + CAGE_X, POSITIONS + CAGE_Y]] = 0.02, 0.03
    out = advanced(moving, 2e-4, 250)
    stored = stored_energy(out)
    numerical = (stored + out.dissipated - out.drive_work)[[0, -1]]
    assert abs(numerical[1] - numerical[0]) <= 1e-5 * (out.gross_work[-1] - out.gross_work[0])
    residual = out.raceway_force.sum(axis=1) + out.inner_ring_force + out.outer_ring_force
    residual[:, :2] += out.land_force
    assert np.abs(residual).max() < 1e-9
    if guidance == "balls":
        assert not out.land_force.any()
        return
    assert np.abs(out.land_force).max() > WEIGHT
    middle = out.cage_offset - (out.inner_ring_offset[:, :2] if guidance == "inner" else 0.0)
    assert np.hypot(*middle.T).max() < 1e-4 + 2e-6


def test_balls_alone_carry_a_cage():
    """Under thrust, which holds all balls, the cage hangs by half the clearance of the pockets beside it."""
    moving = caged("cage.guidance=balls", "cage.pocket_clearance=1e-4", "rings.inner.load=[0,0,800]")
    out = advanced(moving, 1e-3, 100)
    assert out.cage_offset[20:, 1].mean() == pytest.approx(-0.5e-4, rel=0.2)


@pytest.mark.parametrize("guidance", ["inner", "outer", "balls"])
def test_wrenches_on_balls_and_rings_add_up_to_what_the_cage_does_to_its_land(guidance):
    """As the messages have it; contacts alone cancel, and those on the other ring are its wrench."""
    scene = load_scene("bearing_6203_guided_cage", ("cage.kind=pockets", f"cage.guidance={guidance}"))
    block = Simulation(scene).advance(20)
    names = [topic.name for topic in topics(scene) if topic.name.endswith("/wrench")]
    forces = {name: fields_of(scene, block, name)["wrench"]["force"] for name in names}
    land = np.pad(fields_of(scene, block, "cage/state")["effort"][:, 1:], ((0, 0), (0, 1)))
    assert sum(forces.values()) == pytest.approx(-land, abs=1e-10)
    assert (np.abs(land).max() > 0.0) == (guidance != "balls")
    contacts = fields_of(scene, block, "contacts")
    load, normal, friction = (contacts[name][:, 1:16:2] for name in ("normal_load", "normal", "friction_force"))
    outer = (load[..., None] * normal + friction).sum(axis=1)
    missing = -land if guidance == "outer" else 0.0 * land
    assert forces["outer_ring/wrench"] + outer == pytest.approx(missing, abs=1e-10)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("cage.kind=even", "cage.guidance=outer"), "set cage.kind: pockets"),
        (("cage.guidance=outer", "rings.inner.free=all"), "not built for a ring that tilts"),
        (("cage.guidance=outer", "cage.mass=0", "cage.inertia=1e-6"), "give cage.mass above 0 kg"),
        (("cage.guidance=inner", "cage.land_radius=15e-3"), "inside the pitch circle"),
    ],
)
def test_guidance_that_cannot_be_is_refused(overrides, message):
    with pytest.raises(SceneError, match=message):
        load_scene(RIG, last_overrides(("cage.kind=pockets", *overrides)))
