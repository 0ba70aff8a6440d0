"""A soft disc on a wall by finite elasticity: patches, balances, published numbers, and where it breaks."""

import numpy as np
import pytest
from runs import reported

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.kinds.soft_discs.derived import disc_mass, seen_from_other
from bearing_twin.kinds.soft_discs.figures import second_divisions
from bearing_twin.kinds.soft_discs.mesh import ORDERS, energy_density, half_disc
from bearing_twin.kinds.soft_discs.motion import bodies_in_units, elastic_forces, solve, stable_step
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.simulation import simulate

FORMULATIONS = ("stvk", "neo_hookean", "linear")
COARSE = ("mesh.divisions=16", "mesh.order=1")
SMALL = ("mesh.divisions=8", "mesh.order=2")
TIMES = np.linspace(0.0, 0.07, 1401)


def scene_of(*overrides):
    """The parameters of the mean problem, changed."""
    return load_scene("soft_discs_mean", overrides).parameters


def deviation(force, reference):
    return float(np.sqrt(np.mean((force - reference) ** 2) / np.mean(reference**2)))


def forces_and_energy(parameters, gradient):
    """Forces (2, n) and energy of half the disc of radius and modulus 1 under u = (F - 1) x."""
    body, mesh = bodies_in_units(parameters)[0], parameters.mesh
    mesh = half_disc(mesh)
    displacement = (np.asarray(gradient) - np.eye(2)) @ np.stack([mesh.across, mesh.height])
    displacement[:, -1] = 0.0
    load, extremes = elastic_forces(body, displacement)
    return load[:, :-1], extremes, mesh


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_patch_test(order, formulation):
    """A uniform gradient meets no force at nodes inside, and its energy is that of the law written another way."""
    gradient = np.array([[1.08, 0.03], [-0.05, 0.9]])
    for plane in ("strain", "stress"):
        parameters = scene_of("mesh.divisions=8", f"mesh.order={order}", f"formulation={formulation}", f"plane={plane}")
        load, (energy, det, stretch), mesh = forces_and_energy(parameters, gradient)
        inside = (np.hypot(mesh.across[:-1], mesh.height[:-1] - 1.0) < 0.99) & (mesh.across[:-1] > 0.0)
        assert np.abs(load[:, ~inside]).max() > 1e-3
        assert np.abs(load[:, inside]).max() < 1e-13
        density = energy_density(parameters, gradient) / parameters.disc.material.young_modulus
        area = mesh.weights[:, : mesh.full**2].sum()
        assert energy == pytest.approx(density * area, rel=1e-9)
        assert det == pytest.approx(np.linalg.det(gradient), rel=1e-12)
        assert stretch == pytest.approx(np.linalg.svd(gradient)[1].min(), rel=1e-12)


@pytest.mark.parametrize("formulation", ["stvk", "neo_hookean"])
def test_a_turned_disc_is_without_stress(formulation):
    turned = np.array([[np.cos(1.1), -np.sin(1.1)], [np.sin(1.1), np.cos(1.1)]])
    load, (energy, _, stretch), _ = forces_and_energy(scene_of(*SMALL, f"formulation={formulation}"), turned)
    assert np.abs(load).max() < 1e-14
    assert abs(energy) < 1e-14
    assert stretch == pytest.approx(1.0, abs=1e-14)


def test_the_mean_problem_of_paper_3():
    """Section 5.2: converged by two programs; here with the mesh that its tolerance chooses."""
    solved = reported("soft_discs_mean")
    figures = solved.figures
    assert solved.status == "done"
    assert solved.flags == ()
    assert figures["peak_force_n"] == pytest.approx(14.86, rel=3e-3)
    assert figures["contact_duration_s"] == pytest.approx(0.0631, rel=2e-3)
    assert figures["restitution"] == pytest.approx(0.977, abs=5e-4)
    assert abs(figures["energy_closure"]) < 1e-4
    assert figures["force_balance"] < 1e-13
    assert figures["touches"] == 1
    mass = 960.0 * np.pi * 0.1**2 * 0.01
    assert figures["impulse_ns"] == pytest.approx(mass * (1.0 + figures["restitution"]), rel=1e-6)
    assert 0.03 < figures["peak_time_s"] < 0.035


def test_the_mean_problem_in_plane_stress():
    figures = reported("soft_discs_mean", "plane=stress", "mesh.order=2", "mesh.divisions=24").figures
    assert figures["peak_force_n"] == pytest.approx(14.605, rel=4e-3)
    assert figures["contact_duration_s"] == pytest.approx(0.06488, rel=2e-3)


def test_energy_and_momentum_close():
    """The energy's drift falls with the square of the step; momentum is round-off alone, whatever the step."""
    drifts = []
    for share in (0.8, 0.4):
        solved = solve(scene_of(*COARSE, f"solver.step_share={share}"), frames=2)
        total = solved.column("kinetic_energy") + solved.column("elastic_energy") + solved.column("contact_energy")
        drifts.append(np.abs(total / total[0] - 1.0).max())
        momentum = solved.column("velocity") * 960.0 * np.pi * 0.1**2 * 0.01
        gained = momentum[-1] - momentum[0]
        # The polygon of bilinear elements has 0.16 % less mass than the disc.
        assert solved.column("normal_load").sum() * solved.step == pytest.approx(gained, rel=2e-3)
        assert np.abs(solved.column("balance")).max() < 1e-13 * solved.column("normal_load").max()
    assert drifts[1] < 1e-4
    assert np.log2(drifts[0] / drifts[1]) == pytest.approx(2.0, abs=0.4)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_step_is_below_the_bound_and_not_far(exponent):
    """At the whole bound the disc runs; at twice it, an instability ends it."""
    overrides = (*COARSE, f"contact.exponent={exponent}")
    solved = solve(scene_of(*overrides, "solver.step_share=1.0"), frames=2)
    assert solved.column("velocity")[-1] == pytest.approx(0.977, abs=0.02)
    step = stable_step(scene_of(*overrides))
    full = scene_of(*overrides)
    assert step * 2.0 * 16.0 < 2.0
    unstable = full.__class__(**{**vars(full), "solver": full.solver.__class__(step_share=2.0)})
    with pytest.raises(IntegrationError):
        solve(unstable, frames=2)


def test_full_integration_locks_and_selective_does_not():
    """At a Poisson's ratio of 0.499: 14.444 N and 0.05956 s; bilinear elements in full give 16.4 N and 0.056 s."""
    near = ("disc.material.poisson_ratio=0.499", *COARSE, "solver.step_share=0.9")
    selective, locked = (
        solve(scene_of(*near, f"mesh.integration={first}"), frames=2) for first in ("selective", "full")
    )
    assert selective.column("normal_load").max() == pytest.approx(14.444, rel=5e-3)
    assert locked.column("normal_load").max() > 1.1 * 14.444
    spans = [first.step * np.flatnonzero(first.column("normal_load"))[-1] for first in (selective, locked)]
    assert spans[0] == pytest.approx(0.05956, rel=2e-2)
    assert spans[1] < 0.95 * 0.05956
    with pytest.raises(SceneError, match=r"mesh\.integration = full .* 0\.499, and it holds up to 0\.45 .* lock"):
        choose(load_scene("soft_discs_mean", (*near, "mesh.integration=full")))


def test_a_collapse_is_caught():
    """St. Venant-Kirchhoff gives way at 2 m/s; the neo-Hookean disc does not."""
    with pytest.raises(IntegrationError, match="collapses") as caught:
        reported("soft_discs_mean", "motion.first_velocity=2.0", *COARSE)
    assert caught.value.reason == "collapsed"
    assert 0.0 < caught.value.seconds < 0.05
    solved = reported("soft_discs_mean", "motion.first_velocity=2.0", "formulation=neo_hookean", *COARSE)
    assert not solved.status.startswith("failed")
    assert solved.figures["least_stretch"] > 0.5


def test_a_ratio_near_one_half_is_capped_and_said():
    solved = reported("soft_discs_mean", "disc.material.poisson_ratio=0.4999", *SMALL)
    assert any("capped" in flag for flag in solved.flags)
    same = reported("soft_discs_mean", "disc.material.poisson_ratio=0.4995", *SMALL)
    assert not any("capped" in flag for flag in same.flags)
    assert solved.figures["peak_force_n"] == same.figures["peak_force_n"]


def test_two_equal_discs_are_a_disc_on_a_wall():
    """At twice the speed: each meets the plane between them at half of it."""
    wall = reported("soft_discs_mean", *SMALL).figures
    discs = reported("soft_discs_mean", *SMALL, "against=disc", "motion.first_velocity=2.0").figures
    assert discs == wall


def test_two_meshed_equal_discs_are_each_others_mirror_image():
    """The contact of two meshes against the plane of symmetry that needs none; also where the penalty is no line."""
    for further, share in (((), 1e-9), (("contact.exponent=1.5",), 2e-3)):  # the latter with another step
        mirrored = reported("soft_discs_mean", *SMALL, "against=disc", "motion.first_velocity=2.0", *further).figures
        meshed = reported(
            "soft_discs_mean", *SMALL, "against=other_disc", "motion.first_velocity=2.0", *further
        ).figures
        for key in (
            "peak_force_n",
            "contact_duration_s",
            "impulse_ns",
            "restitution",
            "least_stretch",
            "wall_speed_m_s",
        ):
            assert meshed[key] == pytest.approx(mirrored[key], rel=share), key
        assert meshed["greatest_penetration_m"] == pytest.approx(2.0 * mirrored["greatest_penetration_m"], rel=share)


UNEQUAL = ("mesh.divisions=16", "mesh.order=2", "wanted.tolerance=0.01")


def test_two_unequal_discs_keep_energy_and_momentum():
    parameters = load_scene("soft_discs_unequal", UNEQUAL).parameters
    solved = solve(parameters, frames=2)
    total = sum(solved.column(name) for name in ("kinetic_energy", "elastic_energy", "contact_energy"))
    assert np.abs(total / total[0] - 1.0).max() < 1e-4
    masses = disc_mass(parameters), disc_mass(seen_from_other(parameters))
    assert masses[1] == pytest.approx(4.0 * masses[0])
    first, second = masses[0] * solved.column("velocity"), masses[1] * solved.column("other_velocity")
    assert first == pytest.approx(
        second, abs=1e-11 * np.abs(first).max()
    )  # each in a frame that looks away from the other
    assert solved.column("balance").max() < 1e-12 * solved.column("normal_load").max()
    impulse = solved.column("normal_load").sum() * solved.step
    assert impulse == pytest.approx(first[-1] - first[0], rel=1e-5)  # half a step at the first touch
    assert (solved.column("velocity") - solved.column("other_velocity"))[0] == pytest.approx(-0.8 + 0.2)
    finer = solve(load_scene("soft_discs_unequal", ["mesh.divisions=24", "mesh.order=2"]).parameters, frames=2)
    assert deviation(solved.column_at("normal_load", TIMES), finer.column_at("normal_load", TIMES)) < 6e-3


def test_a_hard_flat_disc_is_a_wall():
    """Half the radius of a disc of 2 m is little: the force comes near that on a wall, from below."""
    wall = solve(scene_of(*SMALL), frames=2).column("normal_load").max()
    hard = ("against=other_disc", "other.radius=2.0", "other.material.young_modulus=1e8")
    peak = solve(scene_of(*SMALL, *hard), frames=2).column("normal_load").max()
    assert 0.97 * wall < peak < wall


def test_the_second_run_estimates_the_error_of_a_stiff_penalty():
    """Its rate is lower than that of a soft one: the estimate was half of the error."""

    def run_of(divisions, check):
        run = simulate(load_scene("soft_discs_fast", [f"mesh.divisions={divisions}", f"solver.check={check}"]))
        force = np.concatenate([block.values["normal_load"] for block in run.blocks()])
        return force, run.report.errors["wanted_errors"]["forces"]["error"]

    (solved, estimate), (exact, _) = run_of(48, "second_run"), run_of(72, "none")
    error = np.linalg.norm(solved - exact) / np.linalg.norm(exact)
    assert 0.65 * error < estimate < 1.5 * error


def test_units_scale():
    """Force as E r thickness, time as r sqrt(rho/E), at the same speed over sqrt(E/rho)."""
    first = reported("soft_discs_mean", *SMALL).figures
    second = reported(
        "soft_discs_mean", *SMALL, "disc.radius=0.2", "disc.thickness=0.05", "disc.material.young_modulus=4e5",
        "motion.first_velocity=2.0",
    ).figures  # fmt: skip
    assert second["peak_force_n"] == pytest.approx(first["peak_force_n"] * 4.0 * 2.0 * 5.0, rel=1e-9)
    assert second["contact_duration_s"] == pytest.approx(first["contact_duration_s"], rel=1e-9)
    assert second["restitution"] == pytest.approx(first["restitution"], rel=1e-9)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("motion.first_velocity=20", "above the speed of waves"),
        ("solver.step_share=1e-6", "hours"),
        ("run.output_rate=1e7", "lower one of them"),
        ("other.radius=100", "differ by more than a factor of 20"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(override, sentence):
    with pytest.raises(SceneError, match=sentence):
        load_scene("soft_discs_mean", [override, *(["against=other_disc"] if override.startswith("other") else [])])


def test_the_second_mesh_is_coarser_where_there_is_a_coarser_one():
    assert [second_divisions(count, 3) for count in (6, 12, 24, 48)] == [12, 6, 12, 24]
