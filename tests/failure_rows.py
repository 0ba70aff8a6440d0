"""Ways in which methods fail, the command that provokes each, and what the software answers: a table of the docs."""

from typing import NamedTuple

FROM_JUMP = "--set drive.change.time=1e-4 --set drive.change.offset=[0,-4e-5,0]"
SHORT = "--duration 0.001"


class Failure(NamedTuple):
    """What fails; what the software does; the command, its exit code, words of its answer; the chart that shows it."""

    fails: str
    does: str
    command: str
    code: int
    words: str
    chart: str


FAILURES = (
    Failure(
        "few steps a contact make or lose speed: 3 of symplectic Euler up to 7 %",
        "fewer than 8 are refused, fewer than 16 warned of; explicit Euler is not offered",
        "simulate two_spheres --set solver.stepper=symplectic_euler --set solver.step=2e-5",
        2,
        "needs at least 8 steps",
        "pairs",
    ),
    Failure(
        "a step goes past a whole impact",
        "the instant of touch is looked for on the step",
        "simulate ellipsoid_on_plane --set run.duration=0.6",
        0,
        "peak force",
        "bounces",
    ),
    Failure(
        "numbers stop being finite, and an integrator goes on",
        "states are checked; the error names time and ball",
        'chart stability --cell "regularisation rk4 5e-05 0.1"',
        0,
        "ball 0",
        "stability",
    ),
    Failure(
        "an explicit step gives right loads and wrong friction, in silence",
        "`rk4` is refused above 2.78 over the rate of friction",
        "simulate bearing_6203 --set solver.stepper=rk4 --set solver.step=4e-6",
        2,
        "friction answers at",
        "stability",
    ),
    Failure(
        "leapfrog grows above 2/w of the contact",
        "`imex` is refused there",
        "simulate bearing_6203 --set solver.stepper=imex --set solver.step=8e-6",
        2,
        "rings between its contacts",
        "stability",
    ),
    Failure(
        "a step far below the limit is refused",
        "refusal stands at the limit: 7 us runs where 7.47 us is the limit",
        f"simulate bearing_6203 --set solver.stepper=imex --set solver.step=7e-6 {SHORT}",
        0,
        "status",
        "stability",
    ),
    Failure(
        "slip of a sliding ball goes to and fro under `imex`",
        "refused above 3 sqrt(3) over the rate of friction where balls start at rest",
        "simulate bearing_6203_start --set solver.stepper=imex --set contact.friction_regularisation=1e-4 "
        "--set solver.step=7e-7",
        2,
        "friction answers at",
        "stability",
    ),
    Failure(
        "a fixed step is judged at the start, then the ring jumps",
        "a step that was chosen follows, a given one ends the run",
        f"simulate bearing_6203 --set solver.stepper=imex --set solver.step=1e-6 {FROM_JUMP} {SHORT}",
        2,
        "use 2.7e-08 s or less",
        "stability",
    ),
    Failure(
        "lift-off: error control misses where contacts end",
        "steps adapt to the error of the state, whose scale is that of loads and friction",
        "simulate bearing_6203_loose --duration 0.005",
        0,
        "status",
        "newcomers",
    ),
    Failure(
        "no cage: balls drift together",
        "the run says so before it begins",
        f"simulate bearing_6203_loose {SHORT}",
        0,
        "a cage prevents",
        "cages",
    ),
    Failure(
        "an ellipse near a circle: differences of elliptic integrals lose all digits",
        "a series takes over",
        'chart stability --cell "law hertz 1 0.9999999"',
        0,
        "done",
        "laws",
    ),
    Failure(
        "an ellipse near a line: the rational form of `hertz` ends at b/a = 0.01",
        "`hertz_exact`, solved within a bracket, takes its place",
        f"simulate bearing_6203 --set geometry.inner_conformity=0.50001 {SHORT}",
        0,
        "hertz_exact",
        "stability",
    ),
    Failure(
        "integrals that are carried along drift without end",
        "one Newton step after each step; the form without it is warned of",
        f"simulate bearing_6203 --set contact.normal=hertz_unprojected {SHORT}",
        0,
        "nothing pulls the errors",
        "laws",
    ),
    Failure(
        "the volumetric law is 0.5 % off, more for narrow ellipses",
        "the error at the scene's own contacts is told",
        f"simulate bearing_6203 --set contact.normal=volumetric {SHORT}",
        0,
        "off exact Hertz here",
        "bearing_laws",
    ),
    Failure(
        "a Poisson's ratio near 0.5 locks bilinear elements",
        "selective integration; the ratio is capped, and the run says so",
        "simulate soft_discs_mean --set disc.material.poisson_ratio=0.4999 --set mesh.divisions=8",
        0,
        "is capped at",
        "stability",
    ),
    Failure(
        "soft discs of St. Venant-Kirchhoff collapse, here all of a study",
        "counted and left out of all statistics; where none is left, the study says so",
        "study soft_discs_case1 --samples 8 --workers 1 "
        "--set set=[mesh.divisions=8,mesh.order=1,wanted.tolerance=0.1,motion.first_velocity=5]",
        0,
        "so that there are no statistics",
        "discs",
    ),
    Failure(
        "an overlap runs over the rims of a groove",
        "it has no load, and a sentence says why; a run ends with one",
        "contact --shapes two_bodies_groove --approach 1e-3",
        0,
        "the overlap leaves the region",
        "two_bodies",
    ),
    Failure(
        "long steps of Volterra's equation break the bound on the impulse",
        "fewer than 500 a contact are warned of",
        "simulate sphere_on_beam --set solver.stepper=volterra --set solver.steps=12",
        0,
        "is coarse for volterra",
        "beams",
    ),
    Failure(
        "too few steps on a beam make false contacts",
        "fewer than 8 of Volterra's equation are refused, fewer than 2 of modes",
        "simulate sphere_on_beam --set solver.stepper=volterra --set solver.steps=4",
        2,
        "falls apart into false ones",
        "stability",
    ),
    Failure(
        "an assumed force brings energy from nowhere",
        "the energy balance ends the run as failed",
        "simulate sphere_on_beam --set solver.stepper=sinusoidal",
        0,
        "failed: energy",
        "beams",
    ),
    Failure(
        "Euler's beam under a short blow, or a second one",
        "both theories are tried; the run says by how much Euler's errs",
        "simulate sphere_on_beam_drop_50mm --set beam.theory=euler",
        0,
        "needs shear",
        "stability",
    ),
    Failure(
        "Newton's method on the equation of the ellipse, from any start, leaves it for long ellipses",
        "the root is bracketed before it is polished: b/a from 1e-6 to 1, and below a sentence",
        "contact --curvature-small 1e-3 --curvature-large 1e6 --load 100",
        0,
        "hertz_exact 100",
        "laws",
    ),
    Failure(
        "an ellipse is a line: elliptic integrals overflow",
        "refused below b/a = 1e-6",
        "contact --curvature-small 1e-20 --curvature-large 100 --load 100",
        2,
        "this is a line",
        "laws",
    ),
    Failure(
        "a quaternion leaves unit length in steps that are long for the spin",
        "it is put right after each step; a drift above 1e-6 in one is told",
        "simulate ellipsoid_on_plane --set start.angular_velocity=[5e5,0,0] --set solver.stepper=rk4 "
        "--set start.height=-1e-5 --set run.output_rate=1e5 --set run.publish_rate=1e5 --duration 0.0003",
        0,
        "norm drifted by",
        "stability",
    ),
    Failure(
        "the axis of a round spot is noise",
        "below (Q - P)/(Q + P) = 1e-9 none is given, and the spot is called circular",
        'chart stability --cell "axis gap 0.5 1e-14"',
        0,
        "the spot is circular",
        "stability",
    ),
    Failure(
        "a body that rolls by `rk4`: slip goes to and fro where friction answers faster than the step",
        "refused above 2.785 over the rate of friction under the body's weight",
        "simulate ellipsoid_on_plane --set solver.stepper=rk4 --set solver.step=2e-5 "
        "--set contact.friction_coefficient=0.1 --set contact.friction_regularisation=1e-5",
        2,
        "slip would not die out",
        "stability",
    ),
    Failure(
        "a hard penalty on a coarse boundary: contact chatters",
        "touches are counted and told; the error of the mesh is told too",
        "simulate soft_discs_mean --set contact.stiffness_ratio=100 --set mesh.divisions=8 --set mesh.order=1",
        0,
        "contact chatters",
        "stability",
    ),
    Failure(
        "a mean or a deviation that does not exist: tails of a gamma variable are too heavy",
        "refused with the power of the tail, and quantiles are given",
        "study spheres_alpha_4e-5 --set inputs.contact.measured_alpha.std=1.3e-4 --samples 300",
        0,
        "the mean does not exist",
        "coverage",
    ),
    Failure(
        "a density estimate shows modes that are none, and mass where there can be none",
        "reflected at bounds; the number of modes comes with the p-value of a bootstrap",
        "study discs_small_10 --samples 300",
        0,
        "1 mode; that there is only one has p =",
        "studies",
    ),
    Failure(
        "a tolerance is not kept: balls bounce after a hard jump",
        "a companion by other steps measures the error, and the run says doubtful",
        "simulate bearing_6203_sudden --set run.duration=0.04 --set drive.change.offset=[2e-6,-5e-6,1e-6] "
        "--set wanted.tolerance=0.1",
        0,
        "doubtful: friction",
        "tolerance",
    ),
    Failure(
        "a figure is smaller than its error: the drive torque of a bearing that sticks",
        "each figure carries its error; one above 10 % is told",
        "simulate bearing_6203_sticking --duration 0.002",
        0,
        "the error is over 10 % of the figure: drive torque",
        "output_rate",
    ),
    Failure(
        "an error divided by a residual: the torque of a ball that rolls is the difference of two frictions",
        "errors of friction are over mu N of a contact and mu N R of a ball",
        f"simulate bearing_6203 {SHORT}",
        0,
        "over mu N of a contact",
        "steppers",
    ),
    Failure(
        "bands of histories from the first realisations alone",
        "quantiles of histories are those of all realisations, and their number is told",
        "study spheres_alpha_4e-5 --set histories=[normal_load] --set history_points=20 --samples 4200",
        0,
        "the statistics of 4200 realisations",
        "studies",
    ),
    Failure(
        "a solver of a library at its defaults",
        "not the product's; what it costs and errs by is charted",
        "chart newcomers --read --out docs",
        0,
        "solve_ivp RK45 as first tried",
        "newcomers",
    ),
    Failure(
        "intervals that hold the truth less often than they say",
        "counted for each sampler and statistic; unsafe ones are marked in a study",
        "study spheres_alpha_4e-5 --set inputs.contact.measured_alpha.std=4.2e-5 --samples 128",
        0,
        "the interval of the std is unsafe",
        "coverage",
    ),
    Failure(
        "friction over a spot: a quadrature sees kinks",
        "its greatest error over all directions, found by search, is part of the error of each figure",
        f"simulate bearing_6203 --set contact.friction=spot {SHORT}",
        0,
        "mostly friction model",
        "friction",
    ),
)
