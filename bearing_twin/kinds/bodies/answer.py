"""One pair of bodies as it stands, answered in full: opposing points, gap, overlap, and the load by every law."""

import dataclasses
from typing import Any

import numpy as np

from bearing_twin.contact.elasticity import coefficient_of, ellipse, hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bodies.derived import DEEPEST, has_closed_form, size_of, start_points
from bearing_twin.kinds.bodies.parameters import OVERLAP, TRACKINGS, TwoBodiesScene
from bearing_twin.shapes import (
    FOUND,
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
    at = opposition_of(*start_points(parameters))
    moved = tuple((np.array(parameters.first.position) + (approach - at.approach) * at.normal).tolist())
    return dataclasses.replace(parameters, first=dataclasses.replace(parameters.first, position=moved))


def answer(parameters: TwoBodiesScene) -> dict[str, Any]:
    """Figures of a pair by SI-suffixed keys; `laws` and `tracking` hold one row each; raises SceneError.

    `flags` says where the bodies press deeper than the laws hold for, and where the overlap has no outline.
    """
    a, b, unknowns = start_points(parameters)
    at, size, flags = opposition_of(a, b, unknowns), size_of(parameters), []
    contact = at if at.kind == FOUND else None  # flat: only the overlap has a load
    rates, spin = opposing_rates(a, b, unknowns) or (None, None)
    found = {
        "bodies": [parameters.first.shape, parameters.second.shape],
        "effective_modulus_pa": parameters.modulus,
        "approach_m": at.approach,
        "point_first_m": unknowns[:3].tolist(),
        "point_second_m": unknowns[3:6].tolist(),
        "normal": at.normal.tolist(),
        "point_first_rate_m_s": None if rates is None else rates[:3].tolist(),
        "frame_spin_rad_s": None if spin is None else spin.tolist(),
        "curvature_small_per_m": contact.curvature_small if contact else None,
        "curvature_large_per_m": contact.curvature_large if contact else None,
        "major_axis": contact.major_axis.tolist() if contact and not contact.circular else None,
        "tracking": _trackings(has_closed_form(parameters), a, b, unknowns, rates, size),
        **_loads(parameters.modulus, contact, a, b, unknowns, at, size),
    }
    if at.approach > DEEPEST * size:
        flags.append(
            f"the bodies press {at.approach:.3g} m into each other, more than {DEEPEST:g} of the least size "
            f"{size:.3g} m: all laws are for small deformations; press less"
        )
    if at.approach > 0.0 and found["overlap"] is None:
        flags.append(
            "the overlap leaves the region around the opposing points, where its outline is one closed curve whose "
            "normals are near the contact's, so that it has no load; press less, or turn one of the bodies"
        )
    return found | {"flags": flags}


def _trackings(known: bool, a, b, unknowns, rates, size: float) -> dict[str, Any]:
    """By every method: how far [m] its opposing points are from meeting equations (1), None where it finds none.

    Newton's method begins a little beside; the differential form is followed there over a small motion, then put right.
    """
    beside = unknowns.copy()
    beside[:6] += AHEAD * size
    points = {"closed": (a, b, unknowns if known else None), "algebraic": (a, b, settled(a, b, beside))}
    if rates is not None:
        step = AHEAD * size / max(float(np.linalg.norm(rates[:3])), 1e-9)
        ahead = tuple(one._replace(position=one.position + step * one.velocity) for one in (a, b))
        points["differential"] = (*ahead, projected(*ahead, unknowns + step * rates))
    rows = dict.fromkeys(TRACKINGS)
    return rows | {name: {"error_m": opposing_error(*at)} for name, at in points.items() if at[2] is not None}


def _loads(modulus: float, contact, a, b, unknowns, at, size: float) -> dict[str, Any]:
    """The ellipse by Hertz, the overlap, and the load by each law; zero while there is a gap."""
    found = dict.fromkeys(("overlap", "semi_major_m", "semi_minor_m", "peak_pressure_pa")) | {"laws": {}}
    approach, laws, exact = at.approach, {}, None
    if approach <= 0.0:
        return found
    axes = tangent_axes(at.normal)
    if contact:
        curvatures = contact.curvature_small, contact.curvature_large, modulus
        exact = hertz_coefficient(*curvatures) * approach**1.5
        patch = ellipse(*curvatures, exact)
        found |= {f"{name}_m": getattr(patch, name) for name in ("semi_major", "semi_minor")}
        found["peak_pressure_pa"] = patch.peak_pressure
        for name, row in LAWS.items():
            if row.fits == "point" and row.follows:
                laws[name] = coefficient_of(name, *curvatures) * approach**1.5
        axes = np.array([contact.major_axis, np.cross(at.normal, contact.major_axis)])
    middle = 0.5 * (unknowns[:3] + unknowns[3:6])
    over = overlap_of(a, b, middle, axes, at.normal, approach, size, modulus)
    if over.found:
        laws[OVERLAP] = over.load
        found["overlap"] = {"volume_m3": over.volume, "area_m2": over.area, "perimeter_m": over.perimeter}
    found["laws"] = {
        name: {"normal_load_n": load, "error": load / exact - 1.0 if exact else None} for name, load in laws.items()
    }
    return found
