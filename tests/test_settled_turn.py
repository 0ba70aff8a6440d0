"""The motion of a ball whose axis of spin has settled, part by part: against balances and the equations of balls."""

import math

import numpy as np
import pytest
from test_settled_axes import ACROSS, ANGULAR, LAW, THRUST, held_where, motion_of, over_a_spacing, scene_of, settled_at

from bearing_twin.kinds.bearing.axes_at_start import settle_axes
from bearing_twin.kinds.bearing.forces.equations import single_contact
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, CAGE, CAGE_X, TANGENTIAL_VELOCITY
from bearing_twin.kinds.bearing.partners import partners_of, settled_start
from bearing_twin.kinds.bearing.quasi_static import settled
from bearing_twin.kinds.bearing.quasi_static import turn_table as columns
from bearing_twin.kinds.bearing.quasi_static.in_motion import table_of
from bearing_twin.kinds.bearing.quasi_static.settled import COUNTS, Turn, off_by, settled_turn
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of, setting_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import UNKNOWNS, Surroundings
from bearing_twin.kinds.bearing.quasi_static.turn_search import Search
from bearing_twin.kinds.bearing.start import bearing_of
from bearing_twin.numerics.rotation import about_z

NO_GRAVITY = (0.0, 0.0, 0.0)


def turn_of(parameters, gravity=NO_GRAVITY, near=None):
    """(setting, coordinates, turn) of a scene whose ring is held."""
    drive = parameters.drive
    setting, ring = setting_of(parameters, LAW, drive.speed), (*drive.offset, *drive.tilt)
    return setting, ring, settled_turn(parameters, setting, ring, near, gravity)


def test_a_turn_is_a_sum_of_waves_and_so_are_its_derivatives():
    azimuths = azimuths_of(17, 0.0)
    motion = np.zeros((17, UNKNOWNS))
    motion[:, 0], motion[:, 1] = (
        2.0 + 3.0 * np.cos(azimuths),
        1.0 - np.sin(2.0 * azimuths) + 0.5 * np.cos(3.0 * azimuths),
    )
    turn, at = Turn(motion, 40.0), np.array([0.2, 1.9, 5.0])
    places, changes = turn.at(at)
    assert places[:, 0] == pytest.approx(2.0 + 3.0 * np.cos(at))
    assert changes[:, 0] == pytest.approx(-3.0 * np.sin(at))
    assert changes[:, 1] == pytest.approx(-2.0 * np.cos(2.0 * at) - 1.5 * np.sin(3.0 * at))
    curve = turn.accelerations(at) / 40.0**2
    assert curve[:, 0] == pytest.approx(-3.0 * np.cos(at))
    assert curve[:, 1] == pytest.approx(4.0 * np.sin(2.0 * at) - 4.5 * np.cos(3.0 * at))


def test_a_place_is_accelerated_as_the_orbit_speed_varies():
    """d2p/dt2 = w d(w dp/da)/da, a the azimuth and w its speed, by differences."""
    azimuths, at, step = azimuths_of(17, 0.0), np.array([0.2, 1.9, 5.0]), 1e-5
    motion = np.zeros((17, UNKNOWNS))
    motion[:, 0], motion[:, 1] = 2.0 + 3.0 * np.cos(azimuths), np.sin(2.0 * azimuths)
    turn = Turn(motion, 40.0, "", np.array([2.0, -1.0]), 8)
    assert turn.pace(at)[0] == pytest.approx(40.0 + 2.0 * np.cos(8.0 * at) - np.sin(8.0 * at))
    ahead, behind = (turn.whole(at + one)[0][:, 2:4] for one in (step, -step))
    found = turn.pace(at)[0][:, None] * (ahead - behind) / (2.0 * step)
    assert turn.accelerations(at) == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize("count", COUNTS)
def test_what_its_azimuths_do_not_resolve_is_told_to_be_off_by_more(count):
    """By the shortest wave that they hold, over the ball's distance from the groove's centre."""
    least, motion = settled.FINE if count < settled.SLIDING else settled.FINER, np.zeros((count, UNKNOWNS))
    for share, off in ((0.5, 5e-4), (2.0, 3e-2)):
        motion[:, 0] = 1.0 + share * least * np.cos(count // 2 * azimuths_of(count, 0.0))
        assert off_by(Turn(motion, 1.0)) == off
    assert off_by(Turn(motion[:1], 1.0)) == 5e-4


def test_a_ring_that_is_tilted_about_its_axis_alone_does_not_load_all_balls_alike():
    words = "model.dimension=prescribed", "model.control=settled", "drive.speed=1000"
    even, tilted = (
        turn_of(scene_of(*words, "drive.offset=[0,0,1.2e-5]", f"drive.tilt=[{tilt},0]"))[2] for tilt in (0.0, 2e-4)
    )
    assert len(even.motion) == 1
    assert np.ptp(tilted.motion[:, 0]) > 1e-8


def newton_on(parameters, setting, ring, turn, gravity, azimuths):
    """What is left of m a = F [N] (K, 3) on balls in this motion, by the equations of balls that move."""
    bearing, drive = bearing_of(parameters, LAW), parameters.drive
    (motion, _), bent, (orbits, changes) = turn.whole(azimuths), turn.accelerations(azimuths), turn.pace(azimuths)
    left = []
    for (row, height, outwards, up, *spin), (out, along_axis), orbit, change, azimuth in zip(
        motion, bent, orbits, changes, azimuths, strict=True
    ):
        radius, back = setting.outer.locus_radius + row, (math.cos(azimuth), -math.sin(azimuth))
        place, velocity = (radius, 0.0, height), (outwards, radius * orbit, up)
        total = setting.ball_mass * np.array(about_z(*back, gravity))
        for raceway, middle, speed in (
            (bearing.inner, about_z(*back, drive.offset), drive.speed),
            (bearing.outer, NO_GRAVITY, 0.0),
        ):
            total = total + single_contact(bearing, raceway, middle, speed, place, velocity, tuple(spin)).force
        acceleration = out - radius * orbit**2, 2.0 * outwards * orbit + radius * orbit * change, along_axis
        left.append(total - setting.ball_mass * np.array(acceleration))
    return np.array(left)


def test_a_ball_with_weight_is_in_balance_all_round_under_thrust():
    """A ring that loads all balls alike, and gravity across: at every azimuth by the equations of balls that move."""
    gravity = (300.0, -800.0, 0.0)
    parameters = scene_of(
        "model.dimension=prescribed", "model.control=settled", "drive.speed=900", "drive.offset=[0,0,1.2e-5]"
    )
    setting, ring, turn = turn_of(parameters, gravity)
    assert not turn.why
    weight = setting.ball_mass * 800.0
    assert weight > 0.5
    left = newton_on(parameters, setting, ring, turn, gravity, np.array([0.4, 1.7, 3.3, 5.1]))
    assert np.abs(left[:, [0, 2]]).max() < 2e-3 * weight
    assert len(turn.motion) > 1
    azimuths = azimuths_of(len(turn.motion), 0.0)
    there = Surroundings(parameters, setting, ring, azimuths, gravity)
    along = about_z_all(azimuths, gravity)[:, 1] * setting.ball_mass
    assert there.weight[:, 1] == pytest.approx(along, abs=1e-12)


def about_z_all(azimuths, vector):
    return np.array([about_z(math.cos(one), -math.sin(one), vector) for one in azimuths])


def test_where_weight_lifts_a_ball_off_on_part_of_its_way_there_is_no_turn():
    """Two contacts alike that are pressed by delta, N = C delta^1.5, let go at C (2 delta)^1.5 = 2.83 N."""
    parameters = scene_of(
        "model.dimension=prescribed", "model.control=settled", "drive.speed=300", "drive.offset=[0,0,1.2e-5]"
    )
    setting = setting_of(parameters, LAW, 300.0)
    contacts = settled_at(parameters, np.zeros(1)).found.contacts
    lifting = 2.0**1.5 * contacts.load.mean() * math.cos(contacts.angle.mean()) / setting.ball_mass
    reasons = [turn_of(parameters, (0.0, -share * lifting, 0.0))[2].why for share in (0.0, 0.5, 0.9, 1.1, 1.3)]
    assert reasons[:3] == [""] * 3
    assert all("comes to bear next to nothing" in why for why in reasons[3:])


def test_axes_that_do_not_settle_from_rolling_are_looked_for_from_one_parallel_to_the_bearings():
    """As fast as in rolling, and the same way round."""
    parameters = held_where(THRUST, words=("drive.speed=3000", ANGULAR))
    setting, ring = setting_of(parameters, LAW, 3000.0), (*parameters.drive.offset, *parameters.drive.tilt)
    place, contacts = settled.balanced_on_the_way(setting, ring, azimuths_of(COUNTS[-1], 0.0))
    begun = []

    class NoWay:
        count, waves = 1, np.ones((1, 1))

        def found(self, begin):
            begun.append(begin)

    assert settled._first(NoWay(), place, contacts) is None
    rolling, parallel = (begin[2:5] for begin in begun)
    assert abs(rolling[0]) > 0.05 * abs(rolling[2])
    assert rolling[2] < 0.0  # against the ring
    assert parallel == pytest.approx([0.0, 0.0, -np.linalg.norm(rolling)])


def test_a_turn_nearby_is_where_one_is_looked_for_first(monkeypatch):
    parameters, nearby = (held_where(ACROSS, words=(f"drive.speed={speed}",)) for speed in (1500, 1510))
    _, _, near = turn_of(nearby)
    _, _, alone = turn_of(parameters)

    def never(*_):
        raise AssertionError("the way from rolling is gone again")

    monkeypatch.setattr(Search, "found", never)
    _, _, turn = turn_of(parameters, near=near.quicker(1500.0 / 1510.0))
    assert turn.motion == pytest.approx(alone.motion, rel=1e-6, abs=1e-12)
    assert turn.orbit == pytest.approx(alone.orbit, rel=1e-9)


@pytest.mark.parametrize("quick", [-40.0, 40.0])
def test_a_contact_never_pulls(quick):
    """A ball that leaves fast: viscous terms take its load to 0 and no further, as of balls that move."""
    parameters = scene_of("drive.offset=[0,0,1.2e-5]", "drive.speed=700", "contact.relaxation_time=2e-4")
    setting, bearing = setting_of(parameters, LAW, 700.0), bearing_of(parameters, LAW)
    acting = Surroundings(parameters, setting, (*parameters.drive.offset, 0.0, 0.0), np.zeros(1))
    motion = np.array([[1.364e-4, 1.6e-5, quick, -3e-4, 60.0, 4.0, -1150.0]])
    found = acting.wrench(motion, 280.0)
    assert found.contacts.load.min() > 1.0
    loads = found.contacts.load[0] + [one[0] for one in found.viscous]
    assert loads.min() == 0.0 < loads.max()
    radius = setting.outer.locus_radius + motion[0, 0]
    place, velocity = (radius, 0.0, motion[0, 1]), (quick, radius * 280.0, motion[0, 3])
    for load, raceway, middle, speed in zip(
        loads, (bearing.inner, bearing.outer), (parameters.drive.offset, NO_GRAVITY), (700.0, 0.0), strict=True
    ):
        one = single_contact(bearing, raceway, middle, speed, place, velocity, tuple(motion[0, 4:]))
        assert load == pytest.approx(one.normal_load, rel=1e-4)


def test_what_goes_along_the_orbit_counts_by_its_moment_about_the_axis():
    parameters = scene_of("drive.offset=[2e-6,-1e-6,1.2e-5]", "drive.speed=700")
    setting, azimuths = setting_of(parameters, LAW, 700.0), np.array([0.3, 2.0])
    there = Surroundings(parameters, setting, (*parameters.drive.offset, 0.0, 0.0), azimuths)
    motion = np.array([[1.3e-4, 1.6e-5, 2e-4, -3e-4, 60.0, 4.0, -1150.0]] * 2)
    radius = setting.outer.locus_radius + motion[:, 0]
    force = there.wrench(motion, 280.0).force()
    assert np.abs(force[:, 1]).min() > 1e-3
    assert there.balance(motion, 280.0)[:, 5] == pytest.approx(radius * force[:, 1])


@pytest.mark.parametrize("words", [("drive.speed=3000",), ("drive.speed=-1500", "contact.relaxation_time=2e-4")])
def test_a_table_holds_all_that_balls_in_motion_add_to_their_balance(words):
    """Elastic loads along the normals, the table's forces and its inertia: no force is left in the meridian plane.

    At the azimuths of the search, where its equations hold.
    """
    parameters = held_where(ACROSS, words=words)
    setting, ring, turn = turn_of(parameters)
    azimuths = azimuths_of(columns.LOOKS, 0.0)
    table = table_of(parameters, setting, ring, turn)
    acting = Surroundings(parameters, setting, ring, azimuths).wrench(*turn.whole(azimuths))
    elastic = sum(acting.normal_of(side, acting.contacts.load[:, side]) for side in range(2))[:, [0, 2]]
    left = elastic + table[:, 0:2] + table[:, 2:4] + table[:, columns.INERTIA : columns.INERTIA + 2]
    viscous = np.abs(table[:, columns.VISCOUS :][:, :2]).max()
    assert np.abs(left).max() < 0.02 * max(viscous, 1.0) * 1e-1
    assert viscous > (1.0 if len(words) > 1 else 0.0)


def test_balls_of_a_settled_equilibrium_turn_as_those_of_a_run():
    """Orbit and roll rate, with their signs."""
    parameters = held_where(ACROSS, words=("drive.speed=3000",))
    outputs = over_a_spacing(parameters, motion_of(parameters))
    for azimuths, rolls, speed in zip(outputs.orbit_angle, outputs.roll_rate, outputs.cage_speed, strict=True):
        contacts = settled_at(parameters, azimuths).found.contacts
        assert contacts.roll == pytest.approx(rolls, rel=1e-3)
        assert contacts.orbit == pytest.approx(np.full(8, speed), rel=1e-4)


def test_derivatives_by_the_orbit_and_of_the_moment_along_it_are_those_of_what_is_left():
    """Column and row of their own, which all others outweigh, by differences far from a solution."""
    parameters = held_where(ACROSS, words=("drive.speed=3000", "contact.relaxation_time=2e-5"))
    setting, ring, turn = turn_of(parameters)
    search = Search(parameters, setting, ring, len(turn.motion), 100.0)
    at, random, size = settled._unknowns(turn, search), np.random.default_rng(5), turn.motion.size
    places = at[:size].reshape(-1, UNKNOWNS)
    places[:, :2] += 1e-7 * random.normal(size=places[:, :2].shape)
    matrix = search.derivatives(at)

    def slope(towards, step):
        return (search.left(at + step * towards) - search.left(at - step * towards)) / (2.0 * step)

    for orbit in range(size, len(at)):  # the mean, and waves
        by_orbit = slope(np.eye(len(at))[orbit], 1e-4)
        assert np.abs(matrix[:, orbit] - by_orbit).max() < 1e-3 * np.abs(by_orbit).max()
        of_places = matrix[:size, orbit].reshape(-1, UNKNOWNS)[:, :2]
        wanted = by_orbit[:size].reshape(-1, UNKNOWNS)[:, :2]
        assert of_places == pytest.approx(wanted, abs=1e-3 * np.abs(wanted).max())
    for column in range(UNKNOWNS):
        towards = np.zeros(len(at))
        towards[column:size:UNKNOWNS] = search.columns[column:size:UNKNOWNS] * random.normal(size=len(turn.motion))
        exact = slope(towards, 1e-5)[size:]
        for row, one in zip(matrix[size:], exact, strict=True):
            assert row @ towards == pytest.approx(one, abs=2e-3 * (np.abs(row) @ np.abs(towards)))


def test_a_cage_whose_centre_moves_keeps_its_place_where_axes_settle():
    words = "contact.friction=point", "rings.inner.load=[0,-100,100]", "model.control=settled"
    parameters = scene_of(*words, "gravity=[0,-9.81,0]", "cage.kind=pockets", scene="bearing_6203_guided_cage")
    partners = partners_of(parameters)
    state, border = settled_start(parameters, LAW, partners)
    begun, rests = state.copy(), border[CAGE_X:CAGE].copy()
    settle_axes(parameters, LAW, partners, state, border)
    assert not np.array_equal(state, begun)
    assert abs(rests[1]) > 5e-5
    assert np.array_equal(border[CAGE_X:CAGE], rests)


def test_the_orbit_acts_on_a_place_by_what_it_takes_outwards_and_swings():
    """Without friction the force left over grows with the orbit by 2 m O (r - r''), the place along the axis by r''."""
    words = (
        "model.dimension=prescribed",
        "drive.offset=[0,0,1.2e-5]",
        "contact.friction_coefficient=1e-12",
        "contact.relaxation_time=0",
    )
    parameters = scene_of(*words, "drive.speed=900")
    setting, count = setting_of(parameters, LAW, 900.0), 17
    search = Search(parameters, setting, (*parameters.drive.offset, 0.0, 0.0), count, 100.0)
    azimuths, orbit = azimuths_of(count, 0.0), 350.0
    motion = np.zeros((count, UNKNOWNS))
    motion[:, 0], motion[:, 1] = 1.364e-4 + 3e-6 * np.cos(7.0 * azimuths), 1.6e-5 + 2e-6 * np.sin(8.0 * azimuths)
    at = np.append(motion.ravel(), [orbit, *np.zeros(search.waves.shape[1] - 1)])
    found = search.derivatives(at)[: motion.size, motion.size].reshape(count, UNKNOWNS)
    twice, radius = 2.0 * setting.ball_mass * orbit, setting.outer.locus_radius + motion[:, 0]
    outwards = twice * (radius + 49.0 * 3e-6 * np.cos(7.0 * azimuths))
    assert found[:, 0] == pytest.approx(outwards, rel=1e-5)
    assert found[:, 1] == pytest.approx(twice * 64.0 * 2e-6 * np.sin(8.0 * azimuths), abs=1e-5 * twice * 64.0 * 2e-6)


def begun(parameters):
    """States of balls before and behind `settle_axes`, which keep to what `settled_start` gives them."""
    partners = partners_of(parameters)
    state, border = settled_start(parameters, LAW, partners)
    before = state.copy()
    settle_axes(parameters, LAW, partners, state, border)
    return before, state


def test_balls_without_a_cage_begin_at_the_orbit_speed_of_their_motion():
    words = "rings.inner.load=[0,-60,100]", "rings.inner.mass=0.2", "drive.speed=2000", "model.dimension=free"
    _, state = begun(scene_of(*words, "model.control=settled", "cage.kind=none"))
    orbits = state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE]
    assert orbits == pytest.approx(np.full(8, orbits[0]), rel=1e-14)
    assert np.ptp(state[:, AXIS_DISTANCE]) > 1e-8


def test_a_ring_that_springs_hold_begins_as_it_did():
    words = "rings.inner.load=[0,-60,100]", "rings.inner.mass=0.2", "drive.speed=2000", "model.dimension=free"
    words = (*words, "model.control=settled", "cage.kind=even")
    before, state = begun(scene_of(*words, "rings.inner.support.stiffness=[1e6,1e6,1e6]"))
    assert np.array_equal(before, state)
    before, state = begun(scene_of(*words))
    assert not np.array_equal(before, state)


def test_balls_begin_with_their_weight():
    """As the turn with gravity says, which is not the one without."""
    words = "model.dimension=prescribed", "model.control=settled", "drive.speed=900", "drive.offset=[0,0,1.2e-5]"
    gravity = (0.0, -800.0, 0.0)
    found = motion_of(scene_of(*words, "gravity=[0,-800,0]")).first_outputs()
    _, _, turn = turn_of(scene_of(*words), gravity)
    distances = np.hypot(*found.position[0, :, :2].T)
    setting = setting_of(scene_of(*words), LAW, 900.0)
    azimuths = azimuths_of(8, 0.0)
    assert distances == pytest.approx(setting.outer.locus_radius + turn.at(azimuths)[0][:, 0], abs=1e-12)
    assert np.ptp(distances) > 1e-9
