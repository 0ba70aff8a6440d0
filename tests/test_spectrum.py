"""What `bearing_twin spectrum` says of records made by formulas that share nothing with the product."""

import numpy as np
import pytest
import scipy.io

from bearing_twin.command import cli
from bearing_twin.log.cdr import encode
from bearing_twin.log.raw_log import RawLogWriter

BALLS, BALL, PITCH = 9, 7.94, 39.04  # mm, 6205 of a public test rig (its maker's numbers)


def frequencies(shaft: float) -> dict[str, float]:
    """Cage, outer and inner ball-pass frequency and twice the ball's spin [Hz] of a deep groove bearing."""
    g = BALL / PITCH
    cage = shaft / 2 * (1 - g)
    return {"cage": cage, "outer": BALLS * cage, "inner": BALLS * (shaft - cage), "ball": shaft / g * (1 - g * g)}


def record(
    damage: str = "",
    shaft: float = 29.5,
    rate: float = 12_000.0,
    seconds: float = 10.0,
    slip: float = 0.01,
    off: float = 0.0,
    strength: float = 1.0,
    noise: float = 0.3,
    shaft_lines: float = 1.0,
    wander: float = 0.0,
    seed: int = 0,
) -> np.ndarray:
    """A record (N,): `slip` = spread of a period, `off` = relative offset of the line, `wander` = of the speed."""
    random = np.random.default_rng(seed)
    t = np.arange(int(seconds * rate)) / rate
    turns = shaft * (t + (wander / (2 * np.pi * 0.2) * np.sin(2 * np.pi * 0.2 * t)))
    x = noise * random.standard_normal(len(t))
    for k in (1, 2, 3, 4, 5):
        drift = np.cumsum(random.standard_normal(len(t))) * 0.02 / np.sqrt(rate)
        x += shaft_lines / k * np.cos(2 * np.pi * k * turns + random.uniform(0, 6) + drift)
    hum = 1 + 0.2 * np.cos(2 * np.pi * turns + 1) + 0.1 * np.cos(4 * np.pi * turns)
    x += noise * hum * random.standard_normal(len(t))
    if damage:
        per_turn = frequencies(1.0)
        rate_of = per_turn[damage] * (1 + off)
        count = int(turns[-1] * rate_of)
        angles = np.cumsum(1 + slip * random.standard_normal(count)) / rate_of
        angles = angles[angles < turns[-1]]
        moments = np.interp(angles, turns, t)
        force = np.ones(len(angles))
        if damage == "inner":
            force = np.maximum(0.1, np.cos(2 * np.pi * angles)) ** 1.5
        elif damage == "ball":
            force = (0.35 + np.maximum(0.0, np.cos(2 * np.pi * per_turn["cage"] * angles))) * np.where(
                np.arange(len(angles)) % 2, 1.0, 0.6
            )
        force *= strength * (1 + 0.3 * random.standard_normal(len(angles)))
        train = np.zeros(len(t))
        np.add.at(train, (moments * rate).astype(int), force)
        tau = np.arange(int(0.01 * rate)) / rate
        ring = np.exp(-tau / 0.0012) * np.sin(2 * np.pi * 0.28 * rate * tau)
        size = len(t) + len(ring)
        x += np.fft.irfft(np.fft.rfft(train, size) * np.fft.rfft(ring, size), size)[: len(t)]
    return x


SHAFT, RATE = 29.5, 12_000.0
BEARING = ("--bearing", "6205", "--speed", "1775rpm")  # the shaft's line is 0.3 % slower
FAMILY = {"outer": "BPFO", "inner": "BPFI", "ball": "2BSF"}


def saved(tmp_path, samples, rate=RATE):
    path = tmp_path / "record.npz"
    np.savez(path, x=samples, rate=rate)
    return path


RECORDS = (
    *(
        {"damage": "outer", "slip": slip, "seed": seed, "off": off}
        for slip, seed, off in ((0.01, 1, 0.005), (0.02, 2, -0.01))
    ),
    *({"damage": "inner", "slip": slip, "seed": seed, "strength": 3.0} for slip, seed in ((0.005, 3), (0.01, 4))),
    {"damage": "outer", "strength": 2.0, "wander": 0.02, "seed": 5, "seconds": 10.0},
    {"damage": "inner", "strength": 3.0, "wander": 0.02, "slip": 0.005, "seed": 6, "seconds": 10.0},
    {"damage": "outer", "shaft_lines": 20.0, "seed": 7},
    {"damage": "outer", "shaft": 20.0, "rate": 48_000.0, "seed": 8, "strength": 2.0},
)


def test_damaged_raceways_are_named_and_their_lines_found(tmp_path, run_json):
    for made in RECORDS:
        shaft = made.get("shaft", SHAFT)
        path = saved(tmp_path, record(**{"seconds": 5.0} | made), made.get("rate", RATE))
        result = run_json("spectrum", path, "--bearing", "6205", "--speed", f"{60.18 * shaft}rpm")
        assert result["verdict"] == made["damage"], made
        assert result["shaft_hz"] == pytest.approx(shaft, rel=1e-3), made
        assert result["by_order"] == ("wander" in made)
        line = next(row for row in result["lines"] if row["name"] == FAMILY[made["damage"]])
        true = frequencies(shaft)[made["damage"]] * (1 + made.get("off", 0.0))
        assert line["found_hz"] == pytest.approx(true, rel=3e-3), made
        assert line["off"] == pytest.approx(line["found_hz"] / line["expected_hz"] - 1.0, abs=1e-9)


def test_lines_of_a_raceway_are_not_taken_for_those_of_a_shaft_that_has_none(tmp_path, run_json):
    # BPFO and the sidebands of BPFI lie next to three and four orders
    times = np.arange(int(5.0 * RATE)) / RATE
    for bearing, rpm, part, order in (
        ("6205", 2400, "outer", 3.58),
        ("6203", 1500, "inner", 4.96),
        ("6308", 1797, "inner", 4.97),
    ):
        shaft = rpm / 60.0
        since = times * order * shaft % 1.0 / (order * shaft)  # the last blow, which rings at 3 kHz
        load = 1.0 + 0.8 * (part == "inner") * np.cos(2.0 * np.pi * shaft * times)
        blows = 5.0 * load * np.exp(-800.0 * since) * np.sin(2.0 * np.pi * 3000.0 * since)
        made = saved(tmp_path, blows + np.random.default_rng(1).standard_normal(len(times)))
        result = run_json("spectrum", made, "--bearing", bearing, "--speed", f"{rpm}rpm")
        assert (result["verdict"], result["by_order"]) == (part, False), bearing
        assert result["shaft_hz"] == pytest.approx(shaft, rel=2e-3), bearing


def test_records_of_no_damage_and_of_a_hidden_one_are_not_misnamed(tmp_path, run_json):
    healthy = [{"seed": seed, "shaft_lines": lines} for seed in (10, 11) for lines in (0.0, 20.0)]
    for made in (*healthy, {"wander": 0.02}, {"damage": "outer", "strength": 0.05}):
        assert (
            run_json("spectrum", saved(tmp_path, record(seconds=5.0, **made)), *BEARING)["verdict"]
            == "nothing stands out"
        ), made
    for seed in range(4):
        made = record("ball", seconds=5.0, seed=seed, strength=(0.5, 1.0, 2.0, 4.0)[seed])
        assert run_json("spectrum", saved(tmp_path, made), *BEARING)["verdict"] in ("ball", "nothing stands out")


def test_sidebands_show_how_damage_goes_through_the_load(tmp_path, run_json):
    result = run_json("spectrum", saved(tmp_path, record("inner", strength=4.0, slip=0.003)), *BEARING)
    level = {line["name"]: line["over_noise_db"] for line in result["lines"]}
    assert min(level["BPFI-fs"], level["BPFI+fs"]) > 15.0 > level["BPFO+fs"]
    assert {f"{k}{name}" for k in ("", "2x", "3x") for name in (*FAMILY.values(), "FTF")} <= level.keys()


@pytest.mark.parametrize("damage", ["outer", "inner"])
def test_a_line_of_the_damage_that_another_family_meets_is_named_as_such(damage, tmp_path, run_json):
    """Three times BPFO is within 1 % of twice BPFI, and four times BPFO of six times the ball's spin."""
    result = run_json("spectrum", saved(tmp_path, record(damage, strength=4.0, slip=0.003)), *BEARING)
    family = FAMILY[damage]
    frequency = {line["name"]: line["found_hz"] for line in result["lines"]}
    assert result["verdict"] == damage
    for line in result["lines"]:
        assert not (line["same_as"] and family in line["name"])
        if line["same_as"] in frequency:
            assert line["found_hz"] == pytest.approx(frequency[line["same_as"]], rel=2e-3)
        if line["over_noise_db"] > 25.0 and line["name"][-4:] in {"BPFO", "BPFI", "2BSF"} - {family}:
            assert line["same_as"], line
    others = {line["name"]: line["same_as"] for line in result["lines"]}
    assert others["2xBPFI" if damage == "outer" else "3xBPFO"] == ("3xBPFO" if damage == "outer" else "2xBPFI")


def test_one_record_in_every_kind_of_file_says_the_same(tmp_path, run_json):
    samples = record("outer", seconds=1.0, strength=2.0).astype(np.float32)
    times = np.arange(len(samples)) / RATE
    header = 'time,"acceleration, along z"'
    np.savetxt(tmp_path / "a.csv", np.c_[times, samples], delimiter=",", header=header, comments="")
    np.savetxt(tmp_path / "b.csv", samples)
    rows = (f"{1e3 * time:.9g};{sample:.9g}".replace(".", ",") for time, sample in zip(times, samples, strict=True))
    (tmp_path / "c.csv").write_text("\n".join(["Zeit [ms];Beschl. [m/s^2]", *rows]))
    np.savez(tmp_path / "c.npz", x=samples, y=np.zeros(100))
    scipy.io.savemat(
        tmp_path / "d.mat", {"X97_DE_time": samples[:, None], "X97_FE_time": samples[::-1][:, None], "X97RPM": 1775}
    )
    imu, floats = "sensor_msgs/msg/Imu", "std_msgs/msg/Float64"
    with RawLogWriter(tmp_path / "e.mcap") as log:
        for ros_type, name in ((imu, "/imu"), (floats, "/force")):
            log.add_topic(name, ros_type)
        topic = log.add_topic("/shaken", imu)
        for time, value in zip(np.rint(1e9 * times).astype(int).tolist(), samples.tolist(), strict=True):
            log.write(topic, time, time, encode(imu, {"linear_acceleration": {"z": value}}, time, "sensor"))
    options = {
        "a.csv": (),
        "b.csv": ("--rate", "12kHz"),
        "c.csv": (),
        "c.npz": ("--key", "x", "--rate", "12000"),
        "d.mat": ("--key", "DE_time", "--rate", "12kHz"),
        "e.mcap": ("--topic", "/shaken", "--key", "linear_acceleration.z"),
    }
    results = {name: run_json("spectrum", tmp_path / name, *arguments, *BEARING) for name, arguments in options.items()}
    results["its own speed"] = run_json("spectrum", tmp_path / "d.mat", *options["d.mat"], *BEARING[:2])
    for name, result in results.items():
        assert result["verdict"] == "outer", name
        assert result["rms"] == pytest.approx(float(np.std(samples, dtype=float)), rel=1e-4), name
        first, line = results["b.csv"]["lines"][0], result["lines"][0]
        assert line["found_hz"] == pytest.approx(first["found_hz"], rel=1e-6), name


def test_kurtosis_and_band_and_picture(tmp_path, quick_pictures, run_json, run_cli):
    random = np.random.default_rng(1)
    path = saved(tmp_path, random.standard_normal(120_000))
    assert run_json("spectrum", path, *BEARING)["kurtosis"] == pytest.approx(3.0, abs=0.1)
    options = ("--band", "2kHz,5.9kHz", "--plot", str(tmp_path / "p.png"))
    result = run_json("spectrum", path, *BEARING, *options)
    assert result["band_hz"] == [2000.0, 5900.0]
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG"
    assert run_cli("spectrum", path, *BEARING).out.split("\n")[0].split(maxsplit=1) == [
        "verdict",
        "nothing stands out",
    ]


def with_gap(samples):
    times = np.arange(len(samples)) / RATE
    times[40_000:] += 0.01
    return {"time": times, "x": samples}


PLAIN = record(seconds=5.0)
BAD = {  # what is wrong: the arrays of a file, options, a word of the sentence
    "constant": ({"x": np.full(50_000, 2.0)}, (), "constant"),
    "not finite": ({"x": np.where(np.arange(50_000) == 7_000, np.nan, PLAIN[:50_000])}, (), "finite"),
    "clipped": ({"x": np.clip(record("outer", strength=3.0, seconds=5.0), -1.5, 1.5)}, (), "clipped"),
    "gap": (with_gap(PLAIN), (), "gap"),
    "no speed": ({"x": PLAIN}, ("--bearing", "6205", "--rate", "12kHz"), "speed"),
    "no bearing": ({"x": PLAIN}, ("--speed", "1770rpm", "--rate", "12kHz"), "bearing"),
    "no rate": ({"x": PLAIN}, BEARING, "rate"),
    "rate against times": (
        {"x": PLAIN, "time": np.arange(60_000) / 12e3},
        (*BEARING, "--rate", "10kHz"),
        "12000 Hz",
    ),
    "rate too low": ({"x": PLAIN[::10]}, (*BEARING, "--rate", "1200"), "at least"),
    "too short": ({"x": PLAIN[:6000]}, (), "turns"),
    "standing": ({"x": PLAIN}, ("--bearing", "6205", "--speed", "0", "--rate", "12kHz"), "above zero"),
    "text": ({"x": np.array(["a", "b"] * 50)}, (), "numbers"),
    "several": ({"x": PLAIN, "y": PLAIN}, (), "--key"),
    "wrong band": ({"x": PLAIN}, (*BEARING, "--rate", "12kHz", "--band", "2kHz,9kHz"), "band"),
}


@pytest.mark.parametrize("wrong", BAD)
def test_a_record_of_no_use_is_refused_in_a_sentence(tmp_path, wrong, refused):
    arrays, options, word = BAD[wrong]
    np.savez(tmp_path / "record.npz", **arrays)
    rate = () if "time" in arrays else ("--rate", "12kHz")
    assert word in refused("spectrum", tmp_path / "record.npz", *(options or (*BEARING, *rate)))


def test_files_that_are_none_are_refused(capsys, tmp_path):
    for name in ("a.csv", "a.npz", "a.mat", "a.mcap", "a.wav"):
        (tmp_path / name).write_bytes(b"\x00\xff nothing \n of that")
        assert cli.main(["spectrum", str(tmp_path / name), *BEARING, "--rate", "12kHz"]) == 2, name
        assert len(capsys.readouterr().err.strip().splitlines()) == 1, name
    assert cli.main(["spectrum", str(tmp_path / "none.csv"), *BEARING]) == 2


@pytest.mark.parametrize("position", [0.1, 0.5, 0.99])
def test_an_archive_that_was_damaged_is_refused(position, tmp_path, refused):
    path = tmp_path / "record.npz"
    np.savez_compressed(path, x=np.random.default_rng(1).normal(size=1000))
    data = bytearray(path.read_bytes())
    data[int(position * len(data))] ^= 8
    path.write_bytes(data)
    assert "record.npz cannot be read as npz" in refused("spectrum", path, *BEARING, "--rate", "12kHz")


def test_an_uncertain_number_of_balls_and_a_speed_without_a_unit_are_warnings(tmp_path, run_cli):
    path = saved(tmp_path, record(seconds=5.0))
    without_unit = "spectrum", path, "--bearing", "6205", "--speed", "185.9", "--rate", "12kHz"
    assert "is in rad/s, 1775.21 rpm" in run_cli(*without_unit).err
    arguments = "spectrum", path, "--speed", "1750rpm", "--rate", "12kHz", "--bearing"
    assert "7203B has 10 ± 1 balls" in run_cli(*arguments, "7203B").err
    assert "balls" not in run_cli(*arguments, "6205").err
