"""Charts of impacts and bodies: spheres, discs, ellipsoids, tracked surfaces, a sphere on a beam, soft discs."""

from bearing_twin.charts.contest import Contest
from bearing_twin.charts.scenes import Method, SceneProblem, greatest_difference, root_mean_square, steps, tolerances

LADDER = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
ONCE = Method(("solver.stepper=closed_form",))


def pair(title: str, scene: str, contact: float, *keys: str, closed: bool = False, fixed=("rk4", "symplectic_euler")):
    """A contact of about `contact` seconds by adaptive and fixed steps, and where it exists in closed form."""
    settings_of_steps = [contact / count for count in (8, 16, 32, 64, 128, 512)]
    methods = {"dop853": tolerances(*LADDER, overrides=("solver.stepper=dop853",))}
    methods |= {name: steps(*settings_of_steps, overrides=(f"solver.stepper={name}",)) for name in fixed}
    rate = 360.0 / contact
    span = (f"run.duration={1.23 * contact:.3g}", f"run.output_rate={rate:.3g}", f"run.publish_rate={rate:.3g}")
    return SceneProblem(
        title=title,
        scene=scene,
        overrides=(*keys, *span),
        reference=("solver.stepper=dop853", "wanted.tolerance=1e-12"),
        methods=({"closed form": ONCE} if closed else {}) | methods,
        norm=greatest_difference("normal_load"),
    )


BODIES = {
    "spheres": pair("two elastic steel spheres, 20 m/s", "two_spheres", 7.13e-5, closed=True),
    "lossy spheres": pair("two steel spheres, restitution 0.8", "two_spheres", 7.13e-5, "contact.restitution=0.8"),
    "discs": pair("two discs, line contact", "two_discs", 6.49e-3, closed=True),
    "ellipsoid": pair(
        "a tri-axial ellipsoid meets a plane", "ellipsoid_tumbling", 5.1e-5, "start.height=1e-6",
        "start.velocity=[0,0,-1]", fixed=("rk4",),
    ),
    "groove": SceneProblem(
        title="a ball in a groove: opposing points",
        scene="two_bodies_groove",
        overrides=("run.duration=0.02",),
        reference=("contact.tracking=closed", "wanted.tolerance=1e-11"),
        methods={
            label: tolerances(*LADDER, overrides=(f"contact.tracking={name}",))
            for name, label in {
                "closed": "points in closed form",
                "algebraic": "points by Newton",
                "differential": "points by their differential equation",
            }.items()
        },
        norm=greatest_difference("normal_load"),
    ),
}  # fmt: skip


def beam_impact(title: str, scene: str, *keys: str) -> SceneProblem:
    """A sphere on Euler's beam."""
    counts = (12, 24, 48, 96, 192, 384)

    def with_modes(stepper: str, modes: int, settings: tuple) -> Method:
        return Method((f"solver.stepper={stepper}", f"solver.modes={modes}"), "solver.steps", settings)

    return SceneProblem(
        title=title,
        scene=scene,
        overrides=("beam.theory=euler", "run.output_rate=1e6", "run.publish_rate=1e6", *keys),
        reference=("wanted.tolerance=1e-9",),
        methods={
            "automatic, by tolerance": tolerances(1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8),
            "9 modes": with_modes("modes", 9, counts),
            "41 modes": with_modes("modes", 41, counts),
            "Volterra's equation, 301 modes": with_modes("volterra", 301, (8, 16, 30, 60, 120, 250, 500)),
            "sinusoidal force": Method(("solver.stepper=sinusoidal",)),
        },
        norm=greatest_difference("normal_load"),
    )


BEAMS = {
    "slow": beam_impact("1 cm/s, one contact", "sphere_on_beam", "run.duration=6e-4"),
    "fall": beam_impact("fall of 600 mm", "sphere_on_beam_drop_600mm", "run.duration=3e-4"),
}


def disc(title: str, methods: dict[str, Method], *keys: str, finer: str = "mesh.divisions=48") -> SceneProblem:
    """The mean problem of paper 3, section 5.2: a soft disc on a rigid wall."""
    rates = ("run.output_rate=20000", "run.publish_rate=20000", "run.duration=0.07")
    return SceneProblem(
        title=title,
        scene="soft_discs_mean",
        overrides=(*rates, *keys),
        reference=(finer, "mesh.order=4", "solver.step_share=0.9"),
        methods=methods,
        norm=root_mean_square("normal_load"),
    )


def mesh(*keys: str) -> Method:
    """A line of meshes; their divisions fit every order."""
    return Method(keys, "mesh.divisions", (8.0, 12.0, 16.0, 24.0))


NEARLY = "disc.material.poisson_ratio=0.499"
OUTSIDE = "solver.allow_invalid=on"  # a method is charted outside its range to show what happens there
DISCS = {
    "mesh": disc("meshes by order of the elements", {f"order {n}": mesh(f"mesh.order={n}") for n in (1, 2, 3, 4)}),
    "locking": disc(
        "Poisson's ratio 0.499, order 1",
        {
            f"{name} integration": mesh("mesh.order=1", f"mesh.integration={name}", OUTSIDE)
            for name in ("selective", "full")
        },
        NEARLY,
    ),
    "small strains": disc(
        "small against finite strains, order 2",
        {
            "finite strains": mesh("mesh.order=2"),
            "small strains": mesh("mesh.order=2", "formulation=linear", OUTSIDE),
        },
    ),
    "step": disc(
        "steps, order 3, 24 divisions",
        {"share of the stable step": Method(("mesh.order=3",), "solver.step_share", (1.0, 0.5, 0.25, 0.12))},
        "mesh.divisions=24",
    ),
}

CHARTS = {
    "bodies": Contest(
        problems=BODIES,
        title="Two bodies meet: closed forms, adaptive and fixed steps, opposing points",
        error="greatest error of the force, over the greatest",
        reference_methods=("dop853", "points in closed form"),
    ),
    "beams": Contest(
        problems=BEAMS,
        title="A sphere on a beam: modes, Volterra's equation, a sinusoidal force",
        error="greatest error of the force, over the greatest",
        reference_methods=("automatic, by tolerance", "9 modes", "41 modes"),
    ),
    "discs": Contest(
        problems=DISCS,
        title="A soft disc on a wall: error of the force against cost",
        error="root mean square error of the force",
        requested_error=5e-3,
    ),
}
