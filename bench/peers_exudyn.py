"""Eight balls between two grooved rings in Exudyn, run in an environment of its own by `bench/peers.py`.

Reads the problem as JSON from standard input and writes one line of JSON a run: the tightest first, then Exudyn's
methods from coarse steps to fine. The inner ring is a body too heavy to be moved; axes are those of the rings.
"""

import json
import sys
import time
import warnings

sys.exudynFast = True  # without the checks of ranges
warnings.simplefilter("ignore")

import exudyn  # noqa: E402
import numpy as np  # noqa: E402
from exudyn.utilities import (  # noqa: E402
    MarkerBodyRigid,
    NodeGenericData,
    ObjectContactSphereTorus,
    RigidBodyInertia,
    SensorBody,
    SensorObject,
)

HEAVY = 1e9  # kg and kg m^2
RESTITUTION = 0.5  # with the velocity below, which gives the damping of the problem
SLOWEST = 12.0  # CPU s a run: finer steps of a method that are likely to take longer are left out, they only cost more
IMPLICIT = (5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7, 2e-7)
EXPLICIT = (4e-6, 2e-6, 1e-6, 5e-7, 2e-7)


def damping_speed(damping):
    """The velocity [m/s] below which Exudyn's Hunt-Crossley model damps by the factor `damping` [s/m] alone."""
    return 1.5 * (1.0 - RESTITUTION) / damping


def body(system, mass, inertia, position, **options):
    """The number of a marker in the middle of a new rigid body, and that of the body."""
    inertia = RigidBodyInertia(mass=mass, inertiaTensor=np.diag([inertia] * 3))
    node = exudyn.NodeType.RotationRotationVector
    number = system.CreateRigidBody(referencePosition=position, inertia=inertia, nodeType=node, **options)
    return system.AddMarker(MarkerBodyRigid(bodyNumber=number)), number


def system_of(problem):
    """The system with its sensors: force of each contact, ball by ball, inner ring first; position of each ball."""
    system = exudyn.SystemContainer().AddSystem()
    turning = {"initialAngularVelocity": [0.0, 0.0, problem["speed"]], "gravity": [0.0, 0.0, 0.0]}
    inner, _ = body(system, HEAVY, HEAVY, problem["offset"], **turning)
    outer = system.AddMarker(MarkerBodyRigid(bodyNumber=system.CreateGround()))
    forces, positions = [], []
    stored = {"storeInternal": True, "writeToFile": False}
    for position, velocity, spin in zip(problem["position"], problem["velocity"], problem["spin"], strict=True):
        motion = {"initialVelocity": velocity, "initialAngularVelocity": spin, "gravity": problem["gravity"]}
        ball, number = body(system, problem["mass"], problem["inertia"], position, **motion)
        variable = exudyn.OutputVariableType.Position
        positions.append(system.AddSensor(SensorBody(bodyNumber=number, outputVariableType=variable, **stored)))
        for ring, marker in zip(problem["rings"], (inner, outer), strict=True):
            contact = ObjectContactSphereTorus(
                markerNumbers=[ball, marker],
                nodeNumber=system.AddNode(NodeGenericData(numberOfDataCoordinates=4, initialCoordinates=[0.0] * 4)),
                sphereRadius=problem["radius"],
                torusMajorRadius=ring["locus"],
                torusMinorRadius=ring["groove"],
                torusAxis=[0.0, 0.0, 1.0],
                dynamicFriction=problem["friction"],
                frictionProportionalZone=problem["regularisation"],
                contactStiffness=ring["coefficient"],
                contactStiffnessExponent=1.5,
                impactModel=1,
                restitutionCoefficient=RESTITUTION,
                minimumImpactVelocity=damping_speed(problem["damping"]),
            )
            number = system.AddObject(contact)
            force = exudyn.OutputVariableType.Force
            forces.append(system.AddSensor(SensorObject(objectNumber=number, outputVariableType=force, **stored)))
    system.Assemble()
    return system, forces, positions


def read(system, sensors):
    """Values that sensors kept, (T, sensors, 3), the start left out."""
    return np.stack([system.GetSensorStoredData(sensor)[1:, 1:4] for sensor in sensors], axis=1)


def run(problem, method, step, options=()):
    """Loads (T, N, 2), friction (T, N, 2, 3) and CPU seconds per simulated second; None where it fails."""
    system, forces, positions = system_of(problem)
    settings = exudyn.SimulationSettings()
    solver = settings.timeIntegration
    solver.endTime, solver.numberOfSteps = problem["end"], round(problem["end"] / step)
    solver.minimumStepSize = step / 16.0  # where Newton's method fails steps are halved, without end by default
    solver.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = problem["period"]
    for name, value in dict(options).items():
        first, _, last = name.rpartition(".")
        group = solver
        for field in filter(None, first.split(".")):
            group = getattr(group, field)
        setattr(group, last, value)
    start = time.process_time()
    try:
        system.SolveDynamic(settings, solverType=getattr(exudyn.DynamicSolverType, method), showHints=False)
    except Exception as error:
        print(f"{method} {step:g}: {str(error).splitlines()[0]}", file=sys.stderr)
        return None
    seconds = (time.process_time() - start) / problem["end"]
    force, position = read(system, forces), read(system, positions)
    force = force.reshape(len(force), -1, 2, 3)
    from_centre = np.stack([position - problem["offset"], position], axis=2)
    normal = from_centre / np.linalg.norm(from_centre, axis=-1, keepdims=True)
    along = np.sum(force * normal, axis=-1)
    return np.abs(along), force - along[..., np.newaxis] * normal, seconds


METHODS = {
    "RK44": ("RK44", EXPLICIT, {}),
    "GeneralizedAlpha 0.6, modified Newton": (
        "GeneralizedAlpha",
        IMPLICIT,
        {"newton.useModifiedNewton": True, "generalizedAlpha.spectralRadius": 0.6},
    ),
    "GeneralizedAlpha 0.9, modified Newton": ("GeneralizedAlpha", IMPLICIT, {"newton.useModifiedNewton": True}),
    "GeneralizedAlpha 0.6": ("GeneralizedAlpha", IMPLICIT, {"generalizedAlpha.spectralRadius": 0.6}),
    "TrapezoidalIndex2, modified Newton": ("TrapezoidalIndex2", IMPLICIT, {"newton.useModifiedNewton": True}),
}


def print_run(name, result):
    """Print a line of JSON."""
    load, friction, seconds = result
    line = {"name": name, "load": load.tolist(), "friction": friction.tolist(), "seconds": seconds}
    print(json.dumps(line), flush=True)


def main():
    """Every method from coarse to fine, until a step would take too long; or one run that is named."""
    problem = json.load(sys.stdin)
    only = problem.get("only")  # the name of a run that is repeated
    if not only:
        print_run("truth", run(problem, "RK44", problem["truth"]))
    for name, (method, steps, options) in METHODS.items():
        before = 0.0
        for step in steps:
            label = f"{name}, {1e6 * step:g} us"
            if step > problem["period"] or before > 0.5 * SLOWEST or only not in (None, label):
                continue
            print(label, file=sys.stderr)
            start = time.process_time()
            result = run(problem, method, step, options)
            before = time.process_time() - start
            if result is not None:
                print_run(label, result)


if __name__ == "__main__":
    main()
