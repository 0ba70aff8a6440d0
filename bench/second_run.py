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
from bearing_twin.base.sample import joined
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
        name = chance.choice([one for one in DRAWN_FROM if one in names])
        words = []
        for key, low, high in OF_KIND.get(load_scene(name).kind, OTHERS):
            if chance.random() < 0.6:
                value = chance.uniform(low, high) if low <= 0.0 else low * (high / low) ** chance.random()
                words.append(f"{key}={value:.3g}")
        yield name, tuple(words)


def refined(kind, parameters, choice, times: int):
    """Parameters and choice refined so many times, as far as that is finer."""
    for _ in range(times):
        finer = kind.comparison(parameters, choice).refined()
        if finer[0].wanted.tolerance > parameters.wanted.tolerance or finer[1].setting > choice.setting:
            break
        parameters, choice = finer
    return parameters, choice


def whole(scene, parameters, choice):
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
    """As `whole`, of a run that is far finer."""
    if scene.kind != "soft_discs":
        return whole(scene, *refined(kind, scene.parameters, choice, TIMES))
    parameters = scene.parameters.resolve()
    mesh = dataclasses.replace(parameters.mesh, divisions=TIMES * parameters.mesh.divisions)
    return whole(scene, dataclasses.replace(parameters, mesh=mesh), choice)


def errors(scene):
    """(of outputs, of figures): name to (estimate, true error); the horizon [s] or None."""
    kind, choice = KINDS[scene.kind], choose(scene)
    checked = Simulation(scene)
    while checked.sequence + 1 < scene.outputs:
        checked.advance(min(checked.chunk_outputs, scene.outputs - checked.sequence - 1))
    report = checked.report(last=True)
    plain = load_scene(scene.resolved(), ("solver.check=none",))
    own, figures = whole(plain, scene.parameters, choice)
    true, exact = truth(plain, kind, choice)
    comparison, found = kind.comparison(scene.parameters, choice), Differences(scene.parameters.wanted.tolerance)
    horizon = report.errors.get("horizon_s")
    for one, other in ((joined(own), joined(true)),):  # a finer mesh has chunks of other lengths
        until = int(np.sum(one.time_ns <= 1e9 * (horizon if horizon is not None else np.inf) + 0.5))
        if until:
            pair = one.part(0, until), other.part(0, until)
            found.add(1e-9 * pair[0].time_ns, comparison.differences(*pair))
    for name, (when, *pair) in comparison.events(figures, exact).items():
        early = np.asarray(when, float) <= (np.inf if horizon is None else horizon)
        found.add(np.asarray(when, float)[early], {name: tuple(np.asarray(one, float)[early] for one in pair)})
    wanted = report.errors["wanted_errors"]
    key = "error" if horizon is None else "error_up_to_horizon"
    outputs = {name: (one.get(key), found.worst[name].error) for name, one in wanted.items() if name in found.worst}
    numbers, others, of_figures = figures.figures(), exact.figures(), {}
    for name, value in report.errors.items():
        key = name.removesuffix("_error")
        if name != key and value is not None and key in numbers:
            estimate = max(value) if isinstance(value, list) else value
            of_figures[key] = estimate, difference(numbers[key], others[key])
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
    (checked, wall), *each = least
    both, dearer = sum(one[0] for one in each), max(one[1] for one in each)
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
    given = parser.parse_args()
    error_estimates.TOLERANCE = 1.0 / given.factor
    seed = given.seed or subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True).stdout.strip()
    rows = [(name, ()) for name in given.scene or ([] if given.drawn else scene_names())]
    ratios, held = {}, {}  # by kind: estimates over true errors, and whether figures are within a factor of 3
    head = (
        "checked run [CPU s] | both alone | ratio | checked run [wall s] | dearer alone | ratio"
        if given.cost
        else "output | estimated | true | ratio | horizon [s]"
    )
    print(f"| scene | {head} |\n|---|{'---|' * (head.count('|') + 1)}")
    for name, words in [*rows, *drawn(seed, given.drawn)]:
        try:
            scene = load_scene(name, words)
            moves = scene.kind in ("bearing", "shaft")
            span = given.span if given.cost else min(scene.parameters.run.duration, given.span)
            scene = load_scene(name, (*words, f"run.duration={span}")) if moves else scene
            if not has_second_run(KINDS[scene.kind], scene.parameters, choose(scene)):
                continue
            label = " ".join((name, *words))
            if given.cost:
                print(f"| {label} | {cost(scene)} |", flush=True)
                continue
            outputs, figures, horizon = errors(scene)
        except BearingTwinError as error:
            print(f"| {name} {' '.join(words)} | {str(error)[:60]} |")
            continue
        for output, (estimate, true) in outputs.items():
            ratio = estimate / true if true and estimate is not None else float("nan")
            ratios.setdefault(scene.kind, []).extend([ratio] if true > KNOWABLE else [])
            until = "" if horizon is None else f"{horizon:.3g}"
            print(f"| {label} | {output} | {estimate:.2g} | {true:.2g} | {ratio:.2f} | {until} |", flush=True)
        known = [(one, true) for one, true in figures.values() if true > 0.0 and one > 0.0]
        held.setdefault(scene.kind, []).extend(1.0 / 3.0 <= one / true <= 3.0 for one, true in known)
    if given.cost:
        return
    print(
        "\n|kind|outputs|estimate over true error|within 0.5 to 2|figures within a factor of 3|\n|---|---|---|---|---|"
    )
    for one in (ratios, held):
        one["all"] = [each for found in one.values() for each in found]
    for kind, found in ratios.items():
        near, span = sum(0.5 <= one <= 2.0 for one in found), f"{min(found):.2f} to {max(found):.2f}" if found else ""
        print(f"|{kind}|{len(found)}|{span}|{near}|{sum(held[kind])} of {len(held[kind])}|")
    print(f"\nSeed: {seed}.")


if __name__ == "__main__":
    main()
