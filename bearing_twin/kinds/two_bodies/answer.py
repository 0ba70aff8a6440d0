"""One pair of bodies as it stands, answered in full: opposing points, gap, overlap, and the load by every law."""

import dataclasses
from typing import Any

import numpy as np

from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import ellipse, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.two_bodies.derived import (
    DEEPEST,
    modulus_of,
    size_of,
    start_body,
    start_opposition,
    start_unknowns,
)
from bearing_twin.kinds.two_bodies.parameters import OVERLAP, TRACKINGS, TwoBodiesScene
from bearing_twin.shapes.implicit import (
    FOUND,
    closed_form_known,
    opposing_error,
    opposing_rates,
    opposition_of,
    overlap_of,
    projected,
    settled,
    tangent_axes,
)

AHEAD = 1e-6  # of the least size: how far the bodies move where the differential form is compared


def pressed(parameters: TwoBodiesScene, approach: float) -> TwoBodiesScene:
    """The scene with its first body moved along its normal until it presses by `approach` [m]."""
    at = start_opposition(parameters)
    moved = tuple((np.array(parameters.first.position) + (approach - at.approach) * at.normal).tolist())
    return dataclasses.replace(parameters, first=dataclasses.replace(parameters.first, position=moved))


def answer(parameters: TwoBodiesScene) -> dict[str, Any]:
    """Figures of a pair by SI-suffixed keys; `laws` and `tracking` hold one row each; raises SceneError.

    `flags` says where the bodies press deeper than the laws hold for, and where the overlap has no outline.
    """
    a, b = start_body(parameters.first), start_body(parameters.second)
    unknowns, modulus = start_unknowns(parameters), modulus_of(parameters)
    at = opposition_of(a, b, unknowns)
    normal, approach = at.normal, at.approach
    contact = at if at.kind == FOUND else None  # flat: only the overlap has a load
    rates, spin = opposing_rates(a, b, unknowns) or (None, None)
    found = {
        "bodies": [parameters.first.shape, parameters.second.shape],
        "effective_modulus_pa": modulus,
        "approach_m": approach,
        "point_first_m": unknowns[:3].tolist(),
        "point_second_m": unknowns[3:6].tolist(),
        "normal": normal.tolist(),
        "point_first_rate_m_s": None if rates is None else rates[:3].tolist(),
        "frame_spin_rad_s": None if spin is None else spin.tolist(),
        "curvature_small_per_m": contact.curvature_small if contact else None,
        "curvature_large_per_m": contact.curvature_large if contact else None,
        "major_axis": contact.major_axis.tolist() if contact and not contact.circular else None,
        "tracking": _trackings(parameters, a, b, unknowns, rates),
    }
    found |= _loads(parameters, contact, (a, b, unknowns, normal, approach))
    return found | {"flags": _flags(approach, size_of(parameters), found["overlap"])}


def _flags(approach, size, overlap) -> list[str]:
    """What is doubtful about a pair that presses, one sentence each."""
    flags = []
    if approach > DEEPEST * size:
        flags.append(
            f"the bodies press {approach:.3g} m into each other, more than {DEEPEST:g} of the least size {size:.3g} m: "
            "all laws are for small deformations; press less"
        )
    if approach > 0.0 and overlap is None:
        flags.append(
            "the overlap leaves the region around the opposing points, where its outline is one closed curve whose "
            "normals are near the contact's, so that it has no load; press less, or turn one of the bodies"
        )
    return flags


def _trackings(parameters, a, b, unknowns, rates) -> dict[str, Any]:
    """By every method: how far [m] its opposing points are from meeting equations (1), None where it finds none.

    Newton's method begins a little beside; the differential form is followed there over a small motion, then put right.
    """
    known = closed_form_known(a.surface.kind, b.surface.kind)
    size = size_of(parameters)
    beside = unknowns.copy()
    beside[:6] += AHEAD * size
    points = {"closed": unknowns if known else None, "algebraic": settled(a, b, beside), "differential": None}
    if rates is not None:
        step = AHEAD * size / max(float(np.linalg.norm(rates[:3])), 1e-9)
        ahead = tuple(one._replace(position=one.position + step * one.velocity) for one in (a, b))
        points["differential"] = projected(*ahead, unknowns + step * rates)
    rows = {}
    for name in TRACKINGS:
        where = ahead if name == "differential" and rates is not None else (a, b)
        rows[name] = None if points[name] is None else {"error_m": opposing_error(*where, points[name])}
    return rows


def _loads(parameters, contact, pair) -> dict[str, Any]:
    """The ellipse by Hertz, the overlap, and the load by each law; zero while there is a gap."""
    a, b, unknowns, normal, approach = pair
    modulus, laws, found = modulus_of(parameters), {}, {"overlap": None, "semi_major_m": None, "semi_minor_m": None}
    exact = None
    if approach <= 0.0:
        return {**found, "peak_pressure_pa": None, "laws": laws}
    if contact:
        small, large = contact.curvature_small, contact.curvature_large
        exact = hertz_coefficient(small, large, modulus) * approach**1.5
        spot = ellipse(small, large, modulus, exact)
        found |= {"semi_major_m": spot.semi_major, "semi_minor_m": spot.semi_minor}
        for name, row in LAWS.items():
            if row.fits == "point" and row.follows:
                laws[name] = coefficient_of(name, small, large, modulus) * approach**1.5
        axes = np.array([contact.major_axis, np.cross(normal, contact.major_axis)])
    else:
        axes = tangent_axes(normal)
    middle = 0.5 * (unknowns[:3] + unknowns[3:6])
    over = overlap_of(a, b, middle, axes, normal, approach, size_of(parameters), modulus)
    if over.found:
        laws[OVERLAP] = over.load
        found["overlap"] = {"volume_m3": over.volume, "area_m2": over.area, "perimeter_m": over.perimeter}
    rows = {
        name: {"normal_load_n": load, "error": load / exact - 1.0 if exact else None} for name, load in laws.items()
    }
    return {**found, "peak_pressure_pa": spot.peak_pressure if contact else None, "laws": rows}
