"""Error estimates beside true errors, `python bench/second_run.py [scene ...]`: a table for docs/accuracy.md.

The true error is the difference from a run that is refined three times as a second run is (1e-3 of the tolerance; an
eighth of a fixed step), or on a mesh three times as fine, in the same norm, up to the horizon. Without scenes: every
shipped scene that moves, cut to SPAN, and `--drawn` more drawn by chance from `--seed` (by default the hash of
the commit). `--cost` gives instead CPU time of a checked run over that of both runs alone, and its wall time over that
of the dearer one, for a processor with two free cores; `--span 5` makes runs long enough to be timed.
"""

import argparse
import dataclasses
import random
import subprocess
import time

import numpy as np

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.sample import join_blocks
from bearing_twin.kinds import KINDS, error_estimates
from bearing_twin.run.scene import choose, load_scene, scene_names
from bearing_twin.run.second_run import Differences, difference, has_second_run
from bearing_twin.run.simulation import Simulation

SPAN, KNOWABLE, TIMES, REPEATED = 0.05, 1e-8, 3, 3
DRAWN_FROM = ("bearing_6203", "bearing_6203_loose", "bearing_6203_tilted", "bearing_6205", "bearing_6203_rig_400N")
DRAWN_FROM += ("bearing_6203_sudden", "ellipsoid_rocking", "two_spheres", "shaft_angular_pair", "sphere_on_beam_long")
OF_KIND = {
    "bearing": (
        ("drive.speed", 50.0, 1500.0),
        ("contact.friction_coefficient", 0.01, 0.2),
        ("geometry.radial_clearance", -1e-5, 1e-5),
        ("wanted.tolerance", 1e-5, 1e-2),
    )
}
"""Keys that are drawn, evenly in value where they may be negative, else in the logarithm."""
OTHERS = (("wanted.tolerance", 1e-5, 1e-2),)


def drawn(seed: str, count: int):
    """(scene, overrides) drawn by chance."""
    chance, names = random.Random(seed), set(scene_names())
    for _ in range(count):
        name = chance.choice([scene for scene in DRAWN_FROM if scene in names])
        overrides = []
        for key, low, high in OF_KIND.get(load_scene(name).kind, OTHERS):
            if chance.random() < 0.6:
                value = chance.uniform(low, high) if low <= 0.0 else low * (high / low) ** chance.random()
                overrides.append(f"{key}={value:.3g}")
        yield name, tuple(overrides)


def refined(kind, parameters, choice, times: int):
    """Parameters and choice refined so many times, as far as that is finer."""
    for _ in range(times):
        finer = kind.comparison(parameters, choice).refined()
        if finer[0].wanted.tolerance > parameters.wanted.tolerance or finer[1].setting > choice.setting:
            break
        parameters, choice = finer
    return parameters, choice


def outputs_of(scene, parameters, choice):
    """All outputs of a motion of these parameters as blocks in the cut of a run, and its figures."""
    kind = KINDS[scene.kind]
    figures, blocks = kind.figures_of(scene.parameters, choice), []
    for block in advanced(alone(scene, parameters, choice), scene.outputs):
        figures.add(block)
        blocks.append(block)
    return blocks, figures


def alone(scene, parameters, choice) -> Simulation:
    """A run of the scene with the motion of these parameters."""
    run = Simulation(dataclasses.replace(scene, parameters=parameters))
    run._motion = KINDS[scene.kind].motion(parameters, choice)
    return run


def advanced(run: Simulation, outputs: int):
    """The blocks of a run."""
    while run.sequence + 1 < outputs:
        yield run.advance(min(run.chunk_outputs, outputs - run.sequence - 1))


def truth(scene, kind, choice):
    """As `outputs_of`, of a run that is far finer."""
    if scene.kind != "soft_discs":
        return outputs_of(scene, *refined(kind, scene.parameters, choice, TIMES))
    parameters = scene.parameters.resolve()
    mesh = dataclasses.replace(parameters.mesh, divisions=TIMES * parameters.mesh.divisions)
    return outputs_of(scene, dataclasses.replace(parameters, mesh=mesh), choice)


def errors(scene):
    """(of outputs, of figures): name to (estimate, true error); the horizon [s] or None."""
    kind, choice = KINDS[scene.kind], choose(scene)
    checked = Simulation(scene)
    while checked.sequence + 1 < scene.outputs:
        checked.advance(min(checked.chunk_outputs, scene.outputs - checked.sequence - 1))
    report = checked.report(last=True)
    plain = load_scene(scene.resolved(), ("solver.check=none",))
    blocks, figures = outputs_of(plain, scene.parameters, choice)
    exact_blocks, exact = truth(plain, kind, choice)
    comparison, differences = kind.comparison(scene.parameters, choice), Differences(scene.parameters.wanted.tolerance)
    horizon = report.errors.get("horizon_s")
    run, exact_run = join_blocks(blocks), join_blocks(exact_blocks)  # as a finer mesh has chunks of other lengths
    until = int(np.sum(run.time_ns <= 1e9 * (horizon if horizon is not None else np.inf) + 0.5))
    if until:
        pair = run.part(0, until), exact_run.part(0, until)
        differences.add(1e-9 * pair[0].time_ns, comparison.differences(*pair))
    for name, (time_s, *pair) in comparison.events(figures, exact).items():
        early = np.asarray(time_s, float) <= (np.inf if horizon is None else horizon)
        values = tuple(np.asarray(column, float)[early] for column in pair)
        differences.add(np.asarray(time_s, float)[early], {name: values})
    estimates = report.errors["wanted_errors"]
    key = "error" if horizon is None else "error_up_to_horizon"
    worst = differences.worst
    outputs = {name: (entry.get(key), worst[name].error) for name, entry in estimates.items() if name in worst}
    values, exact_values, of_figures = figures.figures(), exact.figures(), {}
    for name, value in report.errors.items():
        key = name.removesuffix("_error")
        if name != key and value is not None and key in values:
            estimate = max(value) if isinstance(value, list) else value
            of_figures[key] = estimate, difference(values[key], exact_values[key])
    return outputs, of_figures, horizon


def cost(scene) -> str:
    """Cells of a row: CPU and wall time of a checked run beside those of the run and of the second run alone."""
    kind, choice = KINDS[scene.kind], choose(scene)
    plain = load_scene(scene.resolved(), ("solver.check=none",))
    second = kind.comparison(scene.parameters, choice).refined()
    least = np.full((3, 2), np.inf)
    for _ in range(REPEATED):
        runs = Simulation(scene), alone(plain, scene.parameters, choice), alone(plain, *second)
        for row, run in enumerate(runs):
            began = time.process_time(), time.perf_counter()
            for _block in advanced(run, scene.outputs):
                pass
            taken = time.process_time() - began[0], time.perf_counter() - began[1]
            least[row] = np.minimum(least[row], taken)
    (checked, wall), *alone_times = least
    both, dearer = sum(cpu for cpu, _ in alone_times), max(elapsed for _, elapsed in alone_times)
    return f"{checked:.3f} | {both:.3f} | {checked / both:.2f} | {wall:.3f} | {dearer:.3f} | {wall / dearer:.2f}"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="*")
    parser.add_argument("--drawn", type=int, default=0)
    parser.add_argument("--seed", default=None)
    parser.add_argument("--span", type=float, default=SPAN)
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--factor", type=float, default=1.0 / error_estimates.TOLERANCE, help="of the tolerances")
    arguments = parser.parse_args()
    error_estimates.TOLERANCE = 1.0 / arguments.factor
    seed = arguments.seed or subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True).stdout.strip()
    rows = [(name, ()) for name in arguments.scene or ([] if arguments.drawn else scene_names())]
    ratios, within = {}, {}  # by kind: estimates over true errors, and whether figures are within a factor of 3
    head = (
        "checked run [CPU s] | both alone | ratio | checked run [wall s] | dearer alone | ratio"
        if arguments.cost
        else "output | estimated | true | ratio | horizon [s]"
    )
    print(f"| scene | {head} |\n|---|{'---|' * (head.count('|') + 1)}")
    for name, overrides in [*rows, *drawn(seed, arguments.drawn)]:
        try:
            scene = load_scene(name, overrides)
            moves = scene.kind in ("bearing", "shaft")
            span = arguments.span if arguments.cost else min(scene.parameters.run.duration, arguments.span)
            scene = load_scene(name, (*overrides, f"run.duration={span}")) if moves else scene
            if not has_second_run(KINDS[scene.kind], scene.parameters, choose(scene)):
                continue
            label = " ".join((name, *overrides))
            if arguments.cost:
                print(f"| {label} | {cost(scene)} |", flush=True)
                continue
            outputs, figures, horizon = errors(scene)
        except BearingTwinError as error:
            print(f"| {name} {' '.join(overrides)} | {str(error)[:60]} |")
            continue
        for output, (estimate, true) in outputs.items():
            ratio = estimate / true if true and estimate is not None else float("nan")
            ratios.setdefault(scene.kind, []).extend([ratio] if true > KNOWABLE else [])
            until = "" if horizon is None else f"{horizon:.3g}"
            print(f"| {label} | {output} | {estimate:.2g} | {true:.2g} | {ratio:.2f} | {until} |", flush=True)
        pairs = [(estimate, true) for estimate, true in figures.values() if true > 0.0 and estimate > 0.0]
        within.setdefault(scene.kind, []).extend(1.0 / 3.0 <= estimate / true <= 3.0 for estimate, true in pairs)
    if arguments.cost:
        return
    print(
        "\n|kind|outputs|estimate over true error|within 0.5 to 2|figures within a factor of 3|\n|---|---|---|---|---|"
    )
    for by_kind in (ratios, within):
        by_kind["all"] = [entry for entries in by_kind.values() for entry in entries]
    for kind, of_kind in ratios.items():
        near = sum(0.5 <= ratio <= 2.0 for ratio in of_kind)
        span = f"{min(of_kind):.2f} to {max(of_kind):.2f}" if of_kind else ""
        print(f"|{kind}|{len(of_kind)}|{span}|{near}|{sum(within[kind])} of {len(within[kind])}|")
    print(f"\nSeed: {seed}.")


if __name__ == "__main__":
    main()
