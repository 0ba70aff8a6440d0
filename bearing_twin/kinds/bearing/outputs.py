"""What a bearing scene gives out: its channels, the wrenches, and the contact ellipses of published samples."""

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.forces.layout import CAGE_X, CAGE_Y, PLACES
from bearing_twin.kinds.bearing.output_border import write_border
from bearing_twin.kinds.bearing.output_lanes import OWN_WIDTHS
from bearing_twin.kinds.bearing.output_rows import write_rows
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.sample import Block, Channel, Sample

IN_PLANE = ("in_plane",)  # axes: x and y
ALIKE = 1e-3  # sines of angles by different ways differ by less
OWN = len(OWN_WIDTHS)  # channels with a ball's own numbers


def channels(parameters: BearingScene) -> tuple[Channel, ...]:
    """The channels of a bearing with N balls; vectors in `bearing_link`, contact rows ball x (inner, outer)."""
    return _channels(parameters.geometry.balls)


# The tables below know the number of balls alone: to look one up by a scene would hash all of it, for every chunk.
def _tilting(partners, borders: np.ndarray) -> np.ndarray:
    """`borders` as the ring has them: a cage whose centre moves has it in the places of a tilt, which is 0 then."""
    if not partners.land:
        return borders
    borders = borders.copy()
    borders[:, [CAGE_X, CAGE_Y, PLACES + CAGE_X, PLACES + CAGE_Y]] = 0.0
    return borders


def write_outputs(parameters, bearing, partners, drive, times, states, orientations, borders, out, first):
    """Fills the matrix `out` from row `first` with states (count, N, columns) and orientations (count, N, 4).

    They are those at `times` [s], which count from the instant the drive's angle and speed belong to; `borders`
    (count, BORDER) are those of the `partners`, ring and cage. Every column of a row is written.
    """
    places = _places(parameters.geometry.balls)
    bodies = _tilting(partners, borders)
    write_rows(bearing, drive, times, states, orientations, bodies, len(partners.shaft) > 0, places, out, first)
    if partners.active:
        pitch = parameters.geometry.ball_diameter / parameters.geometry.pitch_diameter
        write_border(bearing, partners, drive, 0.5 * (1.0 - pitch), times, states, borders, places, out, first)


@kernel
def _ellipses(moduli, small, large, load, semi_major, semi_minor, pressure):
    for k in range(load.shape[0]):
        for side in range(2):
            if load[k, side] > 0.0:
                found = ellipse(small[k, side], large[k, side], moduli[side], load[k, side])
                semi_major[k, side] = found.semi_major
                semi_minor[k, side] = found.semi_minor
                pressure[k, side] = found.peak_pressure


def moduli(materials) -> tuple[float, float]:
    """E* [Pa] of a ball on the inner and on the outer raceway."""
    ball = materials.ball
    return effective_modulus(ball, materials.inner_ring), effective_modulus(ball, materials.outer_ring)


def ellipses(moduli, small, large, load) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Semi-axes [m] and peak pressures [Pa], each (N, 2), of contacts (ball, raceway); `moduli` are the races' E*."""
    found = np.zeros_like(load), np.zeros_like(load), np.zeros_like(load)
    _ellipses(moduli, small, large, load, *found)
    return found


def contact_details(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """`in_contact` (N, 2), `semi_major`, `semi_minor` [m], `peak_pressure` [Pa] (N, 2) and `major_axis` (N, 2, 3).

    By Hertz from curvatures and normal load, whatever the elastic law. The major axis lies in the meridian plane,
    across the groove; computed only for samples that are published. All with the rows of a sample of many outputs.
    """
    load = sample["normal_load"]
    flat = load.reshape(-1, 2)
    small, large = (sample[name].reshape(-1, 2) for name in ("curvature_small", "curvature_large"))
    found = np.array(ellipses(moduli(parameters.materials), small, large, flat))
    semi_major, semi_minor, pressure = found.reshape(3, *load.shape)
    normal = sample["normal"]
    axis = np.array([0.0, 0.0, 1.0]) - normal[..., 2:] * normal
    square = axis * axis
    return {
        "in_contact": sample["approach"] > 0.0,
        "semi_major": semi_major,
        "semi_minor": semi_minor,
        "peak_pressure": pressure,
        "major_axis": axis / np.sqrt(square[..., 0:1] + square[..., 1:2] + square[..., 2:3]),
    }


def renewed(block: Block) -> None:
    """Gives inner contact angles of old logs, which counted towards +z as seen from the ball, the sign of today's."""
    angle, normal = (block.values.get(name) for name in ("contact_angle", "normal"))
    if angle is None or normal is None or angle.shape != normal.shape[:-1] or angle.shape[-1:] != (2,):
        return
    inner, rises = angle[..., 0], normal[..., 0, 2]  # the load on a ball by the inner raceway points away from the axis
    np.negative(inner, out=inner, where=np.abs(np.sin(inner) + rises) < ALIKE * np.abs(rises))
