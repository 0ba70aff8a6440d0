"""Acceleration records of damaged bearings, made by formulas that share nothing with the product.

Each passage over damage rings a resonance; the moment of the passage wanders (independent slip), the shaft's own
lines are strong, their phase wanders too, and the sensor is noisy.
"""

import numpy as np

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
        places = np.cumsum(1 + slip * random.standard_normal(count)) / rate_of
        places = places[places < turns[-1]]
        moments = np.interp(places, turns, t)
        force = np.ones(len(places))
        if damage == "inner":
            force = np.maximum(0.1, np.cos(2 * np.pi * places)) ** 1.5
        elif damage == "ball":
            force = (0.35 + np.maximum(0.0, np.cos(2 * np.pi * per_turn["cage"] * places))) * np.where(
                np.arange(len(places)) % 2, 1.0, 0.6
            )
        force *= strength * (1 + 0.3 * random.standard_normal(len(places)))
        train = np.zeros(len(t))
        np.add.at(train, (moments * rate).astype(int), force)
        tau = np.arange(int(0.01 * rate)) / rate
        ring = np.exp(-tau / 0.0012) * np.sin(2 * np.pi * 0.28 * rate * tau)
        size = len(t) + len(ring)
        x += np.fft.irfft(np.fft.rfft(train, size) * np.fft.rfft(ring, size), size)[: len(t)]
    return x
