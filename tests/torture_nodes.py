"""Tortures of nodes: hostile goals, hundreds at once, cancels, minutes of running, signals."""

import contextlib
import itertools
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import numpy as np
from processes import own_domain
from ros import ActionClient, Float64, GoalStatus, RunStudy, SetBool, plain_node, ros_executor
from torture_rows import Found, Row, memory_of, part_of, until

from bearing_twin.log.run_log import read_log
from bearing_twin.nodes.entry import node_command, started
from bearing_twin.nodes.messages import SERVICE

QUICK = {"study": "spheres_alpha_4e-5", "overrides": ["sweep=", "histories=[]", "modality=no"], "samples": 500}
ENDLESS = QUICK | {"samples": 12_000_000, "overrides": [*QUICK["overrides"], "batch=1000000"]}
WITH_HISTORIES = ENDLESS | {"overrides": ["sweep=", "modality=no", "batch=1000000"], "samples": 500_000}
BY_WORKERS = {"study": "bearing_6203_tolerances", "overrides": ["run.duration=20000.0"]}
KEEPS_ALL = {"goal_service_qos_profile": SERVICE, "result_service_qos_profile": SERVICE}
ANSWERED, ACKNOWLEDGED, ENDED = 1.0, 0.1, 0.5  # s
IMPORTED = 1.0  # s of processor time, in which a program has loaded its modules
STARTED, KILLED = 60.0, 60.0  # s after which what does not begin, or does not end, is given up
SOAK = 120.0  # s
GROWN = 2.0  # MB in half a soak, beyond the rounding of pages
BEGUN = 20_000  # bytes of a log of a node that is at work


@contextlib.contextmanager
def running(name: str, executor, parameters: dict, folder: Path) -> Iterator[subprocess.Popen]:
    """A node as a process in the executor's domain, its output in `folder`; ended at the end if it still is there."""
    domain = {"ROS_DOMAIN_ID": str(executor.context.get_domain_id())}
    with patch.dict(os.environ, domain), started(name, node_command(name, parameters), folder) as node:
        yield node


def spun(executor, done, seconds: float) -> bool:
    """Spins until `done()`; False where it does not come in time."""
    end = time.monotonic() + seconds
    while not done():
        executor.spin_once(timeout_sec=0.05)
        if time.monotonic() > end:
            return False
    return True


@contextlib.contextmanager
def asking(folder: Path, **parameters) -> Iterator[tuple]:
    """(executor, client, process) of a uq_node and of a client that keeps all answers."""
    with ros_executor() as executor, running("uq_node", executor, parameters, folder) as node:
        client = ActionClient(plain_node(executor, "asker"), RunStudy, "/bearing/run_study", **KEEPS_ALL)
        if not spun(executor, client.server_is_ready, 120.0):
            raise RuntimeError((folder / "uq_node.txt").read_text())
        answer(executor, client, QUICK)  # what is loaded with the first goal counts for none
        yield executor, client, node


def answer(executor, client, goal: dict, seconds: float = 30.0) -> tuple[float, int]:
    """(seconds until a goal was answered, inf if never; how it ended, -1 where it was refused)."""
    began = time.monotonic()
    sent = client.send_goal_async(RunStudy.Goal(**goal))
    if not spun(executor, sent.done, seconds):
        return float("inf"), -1
    if not sent.result().accepted:
        return time.monotonic() - began, -1
    result = sent.result().get_result_async()
    done = spun(executor, result.done, seconds)
    return (time.monotonic() - began, result.result().status) if done else (float("inf"), -1)


def hostile_goals(folder: Path) -> list[dict]:
    """Devices, pipes, links, secrets, malformed and huge texts, other machines, absurd sizes."""
    room = folder / "room"
    room.mkdir()
    secret = folder / "secret.yaml"
    secret.write_text("password: 12345")
    (room / "link.yaml").symlink_to(secret)
    (room / "junk.yaml").write_bytes(random.Random(1).randbytes(100_000))
    (room / "long.yaml").write_text("a: 1\n" * 200_000)
    (room / "hole.yaml").touch()
    os.truncate(room / "hole.yaml", 1 << 40)
    os.mkfifo(room / "pipe.yaml")
    paths = (
        "/dev/ptmx", "/dev/zero", "/dev/stdin", "/proc/self/mem", "/proc/kmsg", str(secret),
        *(str(room / f"{name}.yaml") for name in ("link", "junk", "long", "hole", "pipe")),
    )  # fmt: skip
    texts = (
        "[" * 50_000, "!!python/object/apply:os.system [sleep 100]", "x" * 1_000_000, "a: " + "1" * 50_000,
        f"scene: {room / 'pipe.yaml'}\nquantities: [a]\ninputs: {{}}\n", "- " * 20_000,
    )  # fmt: skip
    settings = (
        "executor=dask://127.0.0.1:1", "workers=512", "samples=9000000000000000000", "memory=1e300",
        "scene.run.duration=1e308",
    )  # fmt: skip
    goals = [{"study": path} for path in paths] + [{"study": text} for text in texts]
    return goals + [QUICK | {"overrides": [*QUICK["overrides"], setting]} for setting in settings]


def hostile(share: float, folder: Path) -> Found:
    """Goals of a peer that means ill: each answered in time, and a normal goal after them."""
    survived = attempts = silent = 0
    worst = delayed = 0.0
    with asking(folder, log_folder="", study_folders=[str(folder / "room")]) as (executor, client, node):
        goals = hostile_goals(folder)
        for goal in goals[:: max(1, round(1.0 / share))]:
            seconds, _ = answer(executor, client, goal)
            after, status = answer(executor, client, QUICK)
            attempts += 1
            survived += seconds < ANSWERED and after < ANSWERED and status == GoalStatus.STATUS_SUCCEEDED
            worst, delayed = max(worst, seconds), max(delayed, after)
        silent = int(node.poll() is not None) + (folder / "uq_node.txt").read_text().count("Traceback")
        silent += "12345" in (folder / "uq_node.txt").read_text()
    return Found(attempts, survived, 0, silent, f"greatest {worst:.2f} s, a normal goal afterwards {delayed:.2f} s")


def goals(share: float, folder: Path) -> Found:
    """Hundreds of goals at once: each is answered, and each that is accepted gets its result."""
    count = part_of(500, share, 16)
    with asking(folder, log_folder="") as (executor, client, node):
        began = time.monotonic()
        sent = [client.send_goal_async(RunStudy.Goal(**QUICK)) for _ in range(count)]
        spun(executor, lambda: all(future.done() for future in sent), 120.0)
        took = time.monotonic() - began
        answered = [future.result() for future in sent if future.done()]
        accepted = [handle for handle in answered if handle.accepted]
        results = [handle.get_result_async() for handle in accepted]
        spun(executor, lambda: all(future.done() for future in results), 60.0)
        lost = count - len(answered) + len(accepted) - sum(future.done() for future in results)
        silent = int(node.poll() is not None)
    return Found(count, count - lost, lost, silent, f"{len(accepted)} accepted, {took:.1f} s for all")


def calls(share: float, folder: Path) -> Found:
    """Thirty clients call ~/pause of a sim_node at once, again and again, while commands flood it: all are answered."""
    attempts, answers, worst = part_of(10, share, 1), 0, 0.0
    with ros_executor() as executor, running("sim_node", executor, {"scene": "bearing_6203"}, folder) as node:
        callers = [plain_node(executor, f"caller_{k}") for k in range(30)]
        clients = [caller.create_client(SetBool, "/bearing/sim_node/pause", qos_profile=SERVICE) for caller in callers]
        speed = callers[0].create_publisher(Float64, "/bearing/command/speed", 10)
        if not spun(executor, lambda: all(client.service_is_ready() for client in clients), 120.0):
            raise RuntimeError((folder / "sim_node.txt").read_text())
        spun(executor, lambda: False, 5.0)
        for k in range(attempts):
            for value in range(200):
                speed.publish(Float64(data=float(value)))
            began = time.monotonic()
            sent = [client.call_async(SetBool.Request(data=bool(k % 2))) for client in clients]
            spun(executor, lambda sent=sent: all(future.done() for future in sent), 60.0)
            answers += sum(future.done() for future in sent)
            worst = max(worst, time.monotonic() - began)
        silent = int(node.poll() is not None) + (folder / "sim_node.txt").read_text().count("Traceback")
    return Found(30 * attempts, answers, 30 * attempts - answers, silent, f"greatest {worst:.2f} s for thirty")


def cancels(share: float, folder: Path) -> Found:
    """Studies of three kinds are cancelled at random: acknowledged within 100 ms, ended within 500 ms."""
    attempts, survived, silent, chance = part_of(18, share), 0, 0, random.Random(8)
    times = []
    with asking(folder, log_folder="") as (executor, client, node):
        for k in range(attempts):
            heard, goal = [], (ENDLESS, WITH_HISTORIES, BY_WORKERS)[k % 3]
            sent = client.send_goal_async(RunStudy.Goal(**goal), heard.append)
            if not spun(executor, sent.done, 60.0) or not sent.result().accepted:
                continue
            if goal is not BY_WORKERS:  # whose first realisation takes minutes
                spun(executor, lambda heard=heard: bool(heard), 30.0)
            spun(executor, lambda: False, chance.uniform(0.0, 1.0))
            began = time.monotonic()
            reported, ended = sent.result().cancel_goal_async(), sent.result().get_result_async()
            if not spun(executor, reported.done, 10.0):
                continue
            acknowledged = time.monotonic() - began
            if not spun(executor, ended.done, 30.0):
                continue
            times.append((acknowledged, time.monotonic() - began))
            silent += ended.result().status != GoalStatus.STATUS_CANCELED
            survived += times[-1][0] < ACKNOWLEDGED and times[-1][1] < ENDED
        silent += int(node.poll() is not None)
    times = times or [(np.nan, np.nan)]
    worst, middle = np.max(times, axis=0), np.median(times, axis=0)
    texts = [f"{1e3 * usual:.0f} ms (greatest {1e3 * most:.0f})" for usual, most in zip(middle, worst, strict=True)]
    return Found(attempts, survived, 0, silent, f"acknowledged {texts[0]}, ended {texts[1]}")


def soak(share: float, folder: Path) -> Found:
    """sim_node, recorder_node and uq_node at real time, with a study now and then: their memory does not grow."""
    seconds, logs = max(2.0, SOAK * share), [folder / "sim.mcap", folder / "recorded.mcap"]
    seen: dict[str, list[float]] = {}
    with contextlib.ExitStack() as stack:
        executor, client, uq = stack.enter_context(asking(folder, log_folder=""))
        parameters = {"sim_node": {"scene": "bearing_6203", "log": logs[0]}, "recorder_node": {"log": logs[1]}}
        nodes = {name: stack.enter_context(running(name, executor, row, folder)) for name, row in parameters.items()}
        nodes["uq_node"] = uq
        if not until(lambda: all(log.exists() and log.stat().st_size > BEGUN for log in logs), 120.0):
            raise RuntimeError("the nodes of the soak did not begin")
        began = time.monotonic()
        while time.monotonic() - began < seconds:
            answer(executor, client, QUICK)
            for name, node in nodes.items():
                if node.poll() is None:
                    seen.setdefault(name, []).append(1e-6 * memory_of(node.pid))
            time.sleep(min(2.0, seconds / 20.0))
        dead = sum(node.poll() is not None for node in nodes.values())
    # Of the second half: buffers, pools of threads and the results of goals, kept for 30 s, are filled by then.
    grown = {name: sizes[-1] - sizes[len(sizes) // 2] for name, sizes in seen.items()}
    far = max((1e-9 * sample.time_ns for sample in read_log(logs[0])), default=0.0)
    good = sum(growth < GROWN for growth in grown.values())
    sentence = ", ".join(f"{name} {growth:+.1f} MB of {seen[name][-1]:.0f} MB" for name, growth in grown.items())
    figures = f"{seconds / 60.0:.1f} min, {far:.0f} s simulated, in the second half {sentence}"
    return Found(len(nodes), good, int(far == 0.0), dead, figures)


LONG = (
    ("bearing_6203", ["solver.stepper=rk4", "solver.step=1e-11"]),
    ("bearing_6203", ["solver.stepper=radau", "run.duration=1000"]),
    ("bearing_6203_load_and_speed", ["cage.kind=pockets", "run.duration=1000"]),
    ("bearing_6203", ["geometry.balls=4000", "geometry.pitch_diameter=12.0", "run.duration=1000"]),
    ("ellipsoid_tumbling", ["solver.stepper=rk4", "solver.step=1e-13"]),
    ("two_bodies_superellipsoid", ["run.duration=80000"]),
    ("soft_discs_mean", ["mesh.divisions=400"]),
    ("sphere_on_beam", ["solver.modes=4000", "run.duration=30", "run.output_rate=100000"]),
)
"""Scenes that take longer than the torture; spheres and discs that meet are solved in an instant.

The beam's impact itself takes a second or two, its 3 million outputs of 2000 modes minutes.
"""
STUDIES = (
    ("spheres_alpha_4e-5", ["sweep=", "histories=[]", "samples=12000000", "batch=1000000"]),
    ("bearing_6203_tolerances", ["run.duration=20000"]),
)


def commands() -> list[list[str]]:
    """Each of them as a command, and some scenes in a node, where another thread computes."""
    program = [sys.executable, "-m", "bearing_twin"]
    rows = [*(("simulate", *row) for row in LONG), *(("study", *row) for row in STUDIES)]
    lines = [[*program, verb, name, *(f"--set={change}" for change in changes)] for verb, name, changes in rows]
    lines += [node_command("sim_node", {"scene": name, "overrides": changes}) for name, changes in LONG[::4]]
    return [*lines, node_command("uq_node", {"log_folder": ""})]


def schedule_of(process: int) -> dict[str, np.ndarray]:
    """Times [s] for which each thread of a process and of its children ran, and waited for a processor."""
    times = {}
    for task in Path(f"/proc/{process}/task").glob("*"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            times[task.name] = 1e-9 * np.array((task / "schedstat").read_text().split()[:2], float)
            for child in (task / "children").read_text().split():
                times |= schedule_of(int(child))
    return times


def ended_by(process: subprocess.Popen, number: int) -> tuple[float, float]:
    """Time [s] until a signal ended a process, and for how long of it threads waited for a processor."""
    before = times = schedule_of(process.pid)
    began = time.monotonic()
    process.send_signal(number)
    gone = lambda: os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)  # noqa: E731
    while not gone() and time.monotonic() < began + KILLED:
        times = times | schedule_of(process.pid)  # also of threads that have ended
        time.sleep(0.005)
    took = time.monotonic() - began
    times = times | schedule_of(process.pid)
    return took, (sum(times.values()) - sum(before.values()))[1]


def stops(share: float, folder: Path, seed: int = 9) -> Found:
    """Each ended by SIGINT or SIGTERM some seconds after its start: gone within 500 ms, without a traceback.

    The time counts for which it ran or slept; what a busy machine let it wait for a processor is reported beside.
    """
    chance, times, silent, slow, longest = random.Random(seed), [], 0, [], 0.0
    ended = zip(commands(), itertools.cycle((signal.SIGINT, signal.SIGTERM, signal.SIGINT)))
    for arguments, number in list(ended)[:: max(1, round(1.0 / share))]:
        stderr = folder / "output.txt"
        with own_domain() as domain, stderr.open("wb") as output:
            environment = os.environ | {"ROS_DOMAIN_ID": str(domain)}
            process = subprocess.Popen(arguments, stdout=output, stderr=output, env=environment)
            try:
                until(lambda pid=process.pid: sum(schedule_of(pid).values(), np.zeros(2))[0] > IMPORTED, STARTED)
                time.sleep(chance.uniform(0.0, 1.0))
                if process.poll() is not None:
                    raise RuntimeError(f"{' '.join(arguments)} has ended by itself: {stderr.read_text()[-500:]}")
                took, waited = ended_by(process, number)
            finally:
                process.kill()
                process.wait()
        longest = max(longest, took)
        times.append(took - waited)
        event = f"{signal.Signals(number).name} to {' '.join(arguments[2:])}"
        if process.returncode not in (0, 130, 143) or "Traceback" in stderr.read_text():
            silent += 1
            slow.append(f"exit code {process.returncode} after {event}")
            print(f"torture: {slow[-1]}\n{stderr.read_text()[-3000:]}", file=sys.stderr)
        if times[-1] > ENDED:
            slow.append(f"{1e3 * times[-1]:.0f} ms after {event}")
    figures = (
        f"ended {1e3 * np.median(times):.0f} ms (greatest {1e3 * max(times):.0f}; {1e3 * longest:.0f} by the wall)"
    )
    survived = sum(seconds < ENDED for seconds in times)
    return Found(len(times), survived, 0, silent, "; ".join([figures, *slow]))


ROWS = (
    Row("stop", "long scenes of every kind, as a command, in a study and in sim_node, ended by a signal", stops),
    Row("hostile", "goals that mean ill, answered within 1 s, each followed by a normal one", hostile),
    Row("goals", "goals at once", goals),
    Row("calls", "calls of a service by thirty clients at once, in a flood of commands", calls),
    Row("cancel", "cancels of a study that runs, acknowledged within 100 ms and ended within 500 ms", cancels),
    Row("soak", f"nodes at real time for {SOAK:.0f} s, growing by less than {GROWN:.0f} MB in the second half", soak),
)
