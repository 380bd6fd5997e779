"""Commands on hostile scenes, drawn at random: wrong types, depth, size, special files, markup, unusable values."""

from __future__ import annotations

import copy
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from scenes import EXTREMES, at, mutated, places, shipped_tree

from pipelines.io.toml_text import format_document, format_value

MARKUP = (
    "[bold]x[/bold]", "[/nothing]", "<script>alert(1)</script>", "$\\frac$", "{0} %s \\n", "\x1b[2J", "\x9b31m",
    "\u202e",    "\x00", "\r\n", "\u2028", "a" * 5000, "起重机", "e\u0301" * 50, "\U0001f600" * 200, "\ufeff",
    "..", "/", "' or 1", "`id`",
)  # fmt: skip
# values that look right one by one and cannot be used; item by item what was once accepted and failed in the run
UNUSABLE = (
    ("bearings.model", ("hertz",)),
    ("bearings.designation", ("6205", "6999", "62O5", "", "6208-2RS")),
    ("bearings.radial_stiffness_N_per_um", (0.01, 1e6)),
    ("diagnosis.windows_s", ({"late": [0.9, 5.0]}, {"none": [0.0, 1e-9]}, {"all": [0.0, 0.02]})),
    ("diagnosis.envelope_band_Hz", ([100.0, 200.0], [1.0, 4999.0], "mesh", "resonance")),
    ("diagnosis.stage", (1, 2)),
    ("simulation.step_us", (1e-12, 1e-3, 1.0, 1000.0)),
    ("simulation.output_rate_Hz", (50.0, 100.0, 700.0, 2e5)),
    ("simulation.end_s", (1e-4, 0.02, 0.05, 3600.0)),
    ("simulation.integrator", ("exponential", "trapezoidal", "generalised-alpha")),
    ("shafts.1.sections.1.outer_diameter_mm", (0.5, 2.0, 5.0, 30.0)),
    ("shafts.2.sections.1.length_mm", (1e-3, 1.0, 5000.0)),
    ("load.container_kg", (0.0, 1e-6, 1.0, 5e3, 1e9)),
    ("load.drum_radius_mm", (1e-3, 1.0, 1e5)),
    ("drive.speeds_rpm", ([0.0, 1e-9, 1e-9], [0.0, 1e5, 1e5], [0.0, 1e9, -1e9])),
    ("drive.coupling_stiffness_N_m_per_rad", (1e-9, 1e15)),
    ("stages.1.face_width_mm", (1e-3, 0.1, 300.0)),
    ("stages.1.backlash_um", (0.0, 1e4)),
    ("stages.1.module_mm", (1e-3, 0.05, 50.0)),
    ("stages.1.helix_angle_deg", (0.0, 44.9)),
    ("stages.1.pinion_teeth", (1, 5, 6, 200)),
    ("stages.1.mesh_damping_time_us", (0.0, 1e6)),
    ("stages.1.mesh.model", ("iso", "energy")),
    ("gear_material.elastic_modulus_GPa", (1e-9, 1e6)),
    ("casing.model", ("none", "rigid")),
    ("shaft_model.model", ("torsion", "timoshenko")),
    ("load.model", ("static-torque", "rope", "rope-pendulum")),
    ("losses.model", ("none", "efficiency", "coulomb")),
    ("deviations.iso_grade", (1, 12)),
    ("control", ("without-faults",)),
)  # fmt: skip
SHORT = {
    "simulation.end_s": 0.02, "drive.times_s": [0.0, 0.005, 0.02], "drive.speeds_rpm": [0.0, 900.0, 900.0],
    "diagnosis.windows_s": {},
}  # fmt: skip

Command = tuple[list[str], str]  # the arguments of gearcase, and what was done to them


def hostile_command(draw: random.Random, folder: Path) -> Command:
    """A command on a file or with settings that hold something hostile."""
    return draw.choice(_GENERATORS)(draw, folder)


def unusable_command(draw: random.Random, folder: Path) -> Command:
    """`gearcase check minimal` with one to three values that look right and may not be usable."""
    settings: dict[str, Any] = dict(SHORT)
    chosen = draw.sample(UNUSABLE, draw.choice((1, 1, 2, 3)))
    for path, values in chosen:
        settings[path] = draw.choice(values)
    if settings.get("casing.model") == "none":
        settings["sensors"] = []
    arguments = [part for path, value in settings.items() for part in ("--set", f"{path}={format_value(value)}")]
    return ["check", "minimal", *arguments], f"{ {path: settings[path] for path, _ in chosen} }"


def _wrong_types(draw: random.Random, folder: Path) -> Command:
    tree, done = mutated(_base(draw), draw)
    return _file(folder, format_document(tree), done)


def _deep(draw: random.Random, folder: Path) -> Command:
    depth = draw.choice((20, 31, 32, 33, 100, 330, 400, 1000, 20_000))
    key = draw.choice(("title", "sensors", "casing", "x"))
    text = draw.choice(
        (
            f"{key} = {'[' * depth}{']' * depth}\n",
            f"{key} = {'{a=' * depth}1{'}' * depth}\n",
            f"{key}.{'a.' * depth}a = 1\n",
            f"[{key}.{'a.' * depth}a]\nb = 1\n",
            f"[[{key}.{'a.' * depth}a]]\nb = 1\n",
            "[[a]]\n" + "".join(f"[[a{'.a' * n}]]\n" for n in range(1, min(depth, 200))),
        )
    )
    return _file(folder, f'extends = "minimal"\n{text}', f"depth {depth}: {text[:30]!r}")


def _large(draw: random.Random, folder: Path) -> Command:
    count = draw.choice((100, 1000, 5000, 20_000, 100_000))
    make = draw.choice(
        (
            lambda: "".join(f"key_{n} = {n}\n" for n in range(count)),
            lambda: "".join(f"[key_{n}]\n" for n in range(count)),
            lambda: "[[sensors]]\n" * count,
            lambda: f"stages = [{'{}, ' * count}]\n",
            lambda: f"[drive]\ntimes_s = [{', '.join(map(str, range(count)))}]\n",
            lambda: "[diagnosis.windows_s]\n" + "".join(f"w{n} = [0, 9]\n" for n in range(count)),
            lambda: f'title = "{"x" * count}"\n',
            lambda: f"title = {'9' * count}\n",
            lambda: f"x = 0x{'f' * count}\n",
            lambda: f"x = 1e{'9' * count}\n",
            lambda: "x = [" + "\n".join(f"{n}, # [" for n in range(count)) + "\n]\n",
            lambda: '"' + "\\u0041" * count + '" = 1\n',
        )
    )
    text = make()
    return _file(folder, f'extends = "minimal"\n{text}', f"size {count}: {text[:30]!r}")


def _special_file(draw: random.Random, folder: Path) -> Command:
    name = f"special{draw.choice(('', '', '-' * 240, chr(0x1B), chr(0xDCE9)))}.toml"
    path = folder / name
    kind = draw.choice(("pipe", "zero", "loop", "folder", "sparse", "bytes", "utf-16", "absent", "full"))
    try:
        path.unlink(missing_ok=True) if not path.is_dir() else path.rmdir()
        _made(kind, path, draw)
    except OSError:
        pass  # no such name can be made
    place = draw.choice(("scene", "extends", "control", "housing"))
    if place == "scene":
        return ["check", str(path)], f"{kind} as scene"
    written = format_value(str(path))
    text = {
        "extends": f"extends = {written}\n",
        "control": f'extends = "minimal"\ncontrol = {written}\n',
        "housing": f'extends = "rig-step"\n[casing.housing]\nfile = {written}\n',
    }[place]
    return _file(folder, text, f"{kind} as {place}")


def _made(kind: str, path: Path, draw: random.Random) -> None:
    if kind == "pipe":
        os.mkfifo(path)
    elif kind in ("zero", "full"):
        path.symlink_to(f"/dev/{kind}")
    elif kind == "loop":
        path.symlink_to(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "sparse":
        with open(path, "wb") as file:
            file.truncate(5_000_000_000)
    elif kind == "bytes":
        path.write_bytes(draw.randbytes(draw.choice((0, 1, 100, 10_000))))
    elif kind == "utf-16":
        path.write_text('extends = "minimal"\n', encoding="utf-16")


def _markup(draw: random.Random, folder: Path) -> Command:
    tree = _base(draw)
    path = draw.choice([place for place in places(tree) if isinstance(at(tree, place), str | dict)])
    parent, text = at(tree, path[:-1]), draw.choice(MARKUP)
    if isinstance(parent[path[-1]], str):
        parent[path[-1]] = text
    else:
        parent[path[-1]][text] = draw.choice(EXTREMES)
    return _file(folder, format_document(tree), f"{text[:20]!r} at {'.'.join(map(str, path))}")


def _setting(draw: random.Random, folder: Path) -> Command:
    tree = _base(draw)
    path = ".".join(str(p + 1) if isinstance(p, int) else p for p in draw.choice(list(places(tree))))
    keys = draw.choice((path, path, path, f"{path}.a", path.replace(".", ".."), ".a" * 5000, "9" * 5000, f"{path}.0"))
    number = 10 ** draw.choice((1, 3, 5))
    value = draw.choice(
        (
            *map(format_value, EXTREMES), *MARKUP, "", "=", "[", "{", '"', "[[[[]]]]", "{a.b.c=1}", "9" * 5000,
            "[" * 400 + "]" * 400, "{" + ", ".join(f"k{n}=1" for n in range(number)) + "}", f"[{'0,' * number}]",
            "1\n[x]\ny=2", "2024-02-30", "1979-05-27T07:32:00Z", "+nan", "0b2", "1__0", '"""\n', "a\udce9",
        )
    )  # fmt: skip
    return ["check", "minimal", "--set", f"{keys}={value}"], f"--set {keys[:40]}={value[:40]!r}"


def _base(draw: random.Random) -> dict[str, Any]:
    return copy.deepcopy(shipped_tree(draw.choice(("minimal", "minimal", "rig-missing-tooth", "rig-step"))))


def _file(folder: Path, text: str, done: str) -> Command:
    path = folder / "hostile.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    return ["check", str(path)], done


_GENERATORS: tuple[Callable[[random.Random, Path], Command], ...] = (
    _wrong_types, _deep, _large, _special_file, _markup, _setting, unusable_command,
)  # fmt: skip
