"""Words for the steps of a run and for what they count, as the table of costs shows them."""

from __future__ import annotations

import re

_STARTS = {  # start of the name of a step -> what it computes; the rest of the name follows
    "unmodified_law_": "mesh law without faults and modifications, stage ",
    "law_": "mesh law, stage ",
    "crack surface of ": "flexibility of a cracked tooth, ",
    "trial casing": "coarse casing, from which the element size follows",
    "coarse": "casing with larger elements, for the discretisation error: coarse",
    "quadratic casing": "casing with quadratic elements, for the discretisation error",
}
_STEPS = {
    "casing mesh": "finite-element mesh of the casing",
    "casing modes": "natural modes and static shapes of the casing",
    "casing error": "error of the reduced casing against the finite-element model",
    "casing picture": "picture of the casing",
    "casing": "reduced casing with damping and sensors",
    "simulate": "motion of the machine",
    "gear picture": "picture of the gear pair",
    "stiffness curves": "figures of the mesh stiffness",
    "diagnose": "lines of the faulty run compared with those of its control",
    "error bars": "error bars of the lines",
    "verdict": "ranking of the components",
    "report": "text and figures of this report",
}
_NAME = re.compile(r"(features )?(torque )?(?:(seed \d+|error-free) )?(healthy )?(?:(seed \d+) )?(.*)")
_COUNTS = {
    "gear_meshes": "finite-element meshes of gears",
    "factorisations": "matrix factorisations",
    "gear_factorisations": "matrix factorisations for gears",
    "casing_meshes": "finite-element meshes of the casing",
    "casing_coordinates": "coordinates of the reduced casing",
    "recovery_rows": "displacements recovered at sensors",
    "simulations": "simulated motions",
    "coordinates": "coordinates of the machine, sum over all motions",
    "rope_coordinates": "coordinates of ropes, sum over all motions",
    "time_steps": "time steps, sum over all motions",
    "channels": "recorded signals, sum over all motions",
}


def step_words(name: str) -> str:
    """What a step computes; "" for one that is not known here."""
    found = _NAME.fullmatch(name)
    assert found is not None  # the last part takes every text
    features, torque, deviations, healthy, seed, kind = found.groups()
    words = [text + kind[len(start) :] for start, text in _STARTS.items() if kind.startswith(start)]
    words += [_STEPS[kind]] if kind in _STEPS else []
    if not words:
        return ""
    words += ["constant torque as load"] * bool(torque)
    words += ["no deviations" if one == "error-free" else f"deviations of {one}" for one in (deviations, seed) if one]
    words += ["without faults"] * bool(healthy)
    return ("signal features of the " if features else "") + ", ".join(words)


def count_words(name: str) -> str:
    """What is counted."""
    return _COUNTS.get(name, name.replace("_", " "))
