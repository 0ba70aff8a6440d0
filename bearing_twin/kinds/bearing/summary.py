"""The numbers of a run read off its blocks, without simulating anything again."""

import numpy as np

from bearing_twin.errors import LogError
from bearing_twin.kinds.bearing.history import LoadHistory


def run_facts(source) -> dict:
    """`scene`, `law` and `stepper` of a run or a log, as far as it tells them."""
    described = (getattr(source, "metadata", None) or {}).get("bearing_twin", {})
    simulation = getattr(source, "simulation", None)
    facts = {name: described.get(name) or getattr(simulation, name, None) for name in ("law", "stepper")}
    return {"scene": getattr(source, "scene", None), **facts}


def summarise(stream, blocks=None, history: LoadHistory | None = None) -> dict:
    """Greatest and mean loads, speeds, torque and energy balance of a log or run, as plain data with SI-suffixed keys.

    `blocks` are taken in place of `stream.blocks()`, and shown to `history` on the way; `missing_outputs` counts the
    gaps between them. Loads are over the whole run, angles and ellipses at its end. Raises LogError without a sample.
    """
    total, missing, outputs, following = None, 0, 0, None
    first = last = None
    for block in stream.blocks() if blocks is None else blocks:
        if history is not None:
            history.add_block(block)
        if following is not None:
            missing += max(block.first_sequence - following, 0)
        following = block.first_sequence + len(block)
        outputs += len(block)
        first, last = first or block[0], block[-1]
        total = _added(total, block)
    if last is None:
        raise LogError("there is no sample in it; recover the log from the original, or simulate again")

    span = (last.time_ns - first.time_ns) / 1e9
    orbit = (last["orbit_angle"] - first["orbit_angle"]) / span if span else np.zeros_like(last["orbit_angle"])
    facts = run_facts(stream)
    scene = facts["scene"]
    details = scene.model.contact_details(scene.parameters, last) if scene else {}
    result = {
        "scene": scene.name if scene else None,
        "law": facts["law"],
        "stepper": facts["stepper"],
        "outputs": outputs,
        "missing_outputs": missing,
        "start_s": first.time_ns / 1e9,
        "end_s": last.time_ns / 1e9,
        "inner_ring_speed_rad_s": float(last["inner_ring_speed"]),
        "cage_speed_rad_s": float(orbit.mean()),
        "greatest_normal_load_n": float(total["greatest"].max()),
        "inner_ring_torque_z_mean_nm": float(total["torque"] / outputs),
        "energy_closure": _energy_closure(first, last),
    }
    for raceway, word in enumerate(("inner", "outer")):
        result |= {
            f"greatest_normal_load_{word}_n": total["greatest"][:, raceway].tolist(),
            f"normal_load_{word}_n": (total["load"][:, raceway] / outputs).tolist(),
            f"share_without_contact_{word}": (total["loose"][:, raceway] / outputs).tolist(),
            f"contact_angle_{word}_rad": last["contact_angle"][:, raceway].tolist(),
        }
        for name in ("semi_major", "semi_minor") if details else ():
            result[f"{name}_{word}_m"] = details[name][:, raceway].tolist()
    return result


def _added(total, block):
    load = block.values["normal_load"]
    part = {
        "greatest": load.max(axis=0),
        "load": load.sum(axis=0),
        "loose": (load <= 0.0).sum(axis=0),
        "torque": block.values["inner_ring_torque"][:, 2].sum(),
    }
    if total is None:
        return part
    return {
        name: np.maximum(total[name], part[name]) if name == "greatest" else total[name] + part[name] for name in part
    }


def _energy_closure(first, last) -> float:
    """Energy gained (+) or lost (-) by the numbers alone, as a share of the greatest of the three parts."""

    def change(*names):
        return sum(float(last[name]) - float(first[name]) for name in names)

    work, dissipated = change("drive_work"), change("dissipated")
    stored = change("kinetic_energy", "elastic_energy", "potential_energy")
    scale = max(abs(work), abs(dissipated), abs(stored))
    return (stored + dissipated - work) / scale if scale > 0.0 else 0.0
