"""The command line: help for newcomers, one readable message per mistake, exit codes, no traceback."""

import importlib
import json
import logging
import os
import signal
import subprocess
import sys
import time
from importlib import resources

import pytest

from pipelines.cli.command_line import COMMANDS, help_and_example, parser
from pipelines.cli.main import _first_time, main
from pipelines.scene.load_scene import load_scene


def gearcase(capsys, *arguments):
    """Exit code, standard output, standard error of a command run in this process."""
    try:
        code = main(list(arguments))
    except SystemExit as end:  # argparse: help and usage errors
        code = end.code
    out = capsys.readouterr()
    return code, out.out, out.err


def command(*words, stdout=subprocess.PIPE, **environment):
    return subprocess.Popen(
        [sys.executable, "-m", "pipelines.cli.main", *words], stdout=stdout, stderr=subprocess.PIPE,
        env={**os.environ, **environment},
    )  # fmt: skip


@pytest.mark.parametrize("buffered", ["", "1"])
def test_a_reader_that_has_enough_ends_the_command_quietly(buffered):
    """As in `gearcase check rig-healthy | head -1`: it ended with exit code 1."""
    reading, writing = os.pipe()
    os.close(reading)
    with command("check", "rig-healthy", stdout=writing, PYTHONUNBUFFERED=buffered) as process:
        os.close(writing)
        assert process.stderr.read() == b""
    assert process.returncode == 0


def test_help_appears_at_once():
    """0.4 s of the processor, which a busy machine does not change much; the best of three."""
    seconds = []
    for _ in range(3):
        before = os.times()
        done = subprocess.run([sys.executable, "-m", "pipelines.cli.main", "--help"], capture_output=True, check=True)
        after = os.times()
        seconds.append(sum(after[2:4]) - sum(before[2:4]))  # of children: user and system
    assert b"first steps" in done.stdout
    assert min(seconds) < 0.4


@pytest.mark.parametrize("command", list(COMMANDS))
def test_every_command_explains_itself_with_an_example(capsys, command):
    code, out, _ = gearcase(capsys, command, "--help")
    assert code == 0
    assert f"example:\n  gearcase {command} " in out
    example = out.partition("example:\n  gearcase ")[2].splitlines()[0]
    assert parser().parse_args(example.split()).command == command


QUICK = ("new", "check", "explain", "schema", "modes", "cache")  # seconds, and without a finished run


@pytest.mark.parametrize("command", QUICK)
def test_an_example_prints_what_its_help_shows(capsys, here, own_cache, command):
    """Lines in their order, whatever their spaces; "..." stands for any lines."""
    example, *lines = help_and_example(importlib.import_module(f"pipelines.cli.{command}"))[1].splitlines()
    if command == "cache":
        gearcase(capsys, "casing", "minimal", "--quiet")
    shown = [" ".join(line.split()) for line in lines]
    code, out, _ = gearcase(capsys, *example.split()[1:])
    assert code == 0
    printed = iter([" ".join(line.split()) for line in out.splitlines()])
    told = [line for line in shown if line != "..." and command != "cache"] or ["casing 1 entry 0.0 MB"]
    assert [line for line in told if line not in printed] == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check", "minimal", "--set", "stages.1.face_widht_mm=12"], "Did you mean face_width_mm?"),
        (["check", "minimal", "--set", "stages.1.module_mm=-2"], "stages.1.module_mm = -2: must be at least 0.05 mm"),
        (
            ["check", "minimal", "--set", "stages.1.module_mm=0.0025"],
            "must be at least 0.05 mm. Convert it if it is in m: 0.0025 m = 2.5 mm.",
        ),
        (["check", "minimal", "--set", "stages.1.face_width_mm=0"], "stages.1.face_width_mm = 0: must be greater"),
        (
            ["check", "minimal", "--set", "gear_material.elastic_modulus_GPa=210000"],
            "or correct gear_material.elastic_modulus_GPa. Convert it if it is in MPa: 210000 MPa = 210 GPa.",
        ),
        (
            ["check", "minimal", "--set", "casing.material.elastic_modulus_GPa=1.1e11"],
            "must be at most 1e+06 GPa. Convert it if it is in Pa: 1.1e+11 Pa = 110 GPa.",
        ),
        (
            ["check", "minimal", "--set", "casing.material.density_kg_m3=7.2e-9"],
            "must be at least 1 kg/m3. Convert it if it is in t/mm3: 7.2e-09 t/mm3 = 7200 kg/m3.",
        ),
        (["check", "nowhere.toml"], "nowhere.toml: no such file"),
        (["check", "minimal", "--set", "casing.model=rubber"], "must be one of none, rigid"),
        (["check", "minimal", "--set", "stages.1.mesh.model=solid-ish"], "stages.1.mesh.model"),
        (["check", "minimal", "--set", "casing.housing.boss_diameters_mm=[90, 90]"], "overlap"),
        (
            ["check", "minimal", "--set", "drive.times_s=[0.0, 0.5, 0.2]"],
            "must increase strictly, but 0.2 s follows 0.5 s",
        ),
        (
            ["check", "minimal", "--set", "casing.housing.height_mm=100"],
            "mm beyond the inner face of the cover of the housing",
        ),
        (["run", "minimal", "--set", "stages.1.module_mm=0"], "stages.1.module_mm = 0"),
        (["simulate", "minmal"], "Did you mean minimal?"),
        (["explain", "minimal", "--set", "x"], "has no value"),
        (["export", "minimal", "--to", "csv"], "First: gearcase run minimal"),
        (["diagnose", "nowhere"], "no result here"),
        (["cache", "verify", "--older-than", "3"], "--older-than is an option of cache clear only"),
        (["detect", "bench", "--over", "faults.1.depth_um=1", "--dry-run"], "scenes cannot be run. Message of the "),
        (["new", "my.txt"], "must end in .toml"),
        (
            ["housing", "rig-housing.step", "--unit", "t-mm-s"],
            "a CAD file or mesh has a unit of length. Give one of m, ",
        ),
        (["run", "minimal", "--processes", "0"], "whole number from 1"),
        (
            ["run", "minimal", "--sett", "stages.1.module_mm=2"],
            "--sett stages.1.module_mm=2. Did you mean --set? Help:",
        ),
        (["check", "minimal", "--set", "casing.model=craig"], 'Did you mean "craig-bampton"?'),
        (["export", "minimal", "--to", "mat", "--out", "x.csv"], "with --to mat the name must end in .mat."),
        (["detect", "bench", "--over", "faults.1.depth_mm=0.5:3", "--dry-run"], "0.5:3: the step is missing. Write"),
        (["check", "bench", "--set", "casing.damping_ratio=5%"], "must be a number or a list of numbers. Write the"),
        (["check", "bench", "--set", "sensors.1.position_mm=[0, 0]"], "has too few values. Give all of them: x, y, z"),
        (["fly"], "invalid choice"),
        (["check", "pair", "--set", "stages.1.profile_shift_pinion=0.3"], "Did you mean pinion_profile_shift?"),
        (["check", "pair", "--set", "stages.1.bore_mm=30"], "Did you mean pinion_bore_mm or wheel_bore_mm?"),
        (["check", "pair", "--set", "stages.1.wheel.teeth=30"], "Did you mean stages.1.wheel_teeth?"),
        (["check", "pair", "--set", "stages.1.wheel.teth=30"], "Did you mean stages.1.wheel_teeth?"),
        (["check", "pair", "--set", "stages.1.wheel.face_widht_mm=3"], "Did you mean stages.1.face_width_mm?"),
        (["check", "pair", "--set", "stages.1.teth=30"], "Did you mean pinion_teeth or wheel_teeth?"),
        (["check", "bench", "--set", "shafts.1.diameter_mm=3"], "Did you mean shafts.1.sections.1.diameter_mm?"),
        (["dataset"], "Give one of info, check, export"),
        (["gears", "pair", "--torque", "50,100"], "Separate numbers by blanks: 50 100"),
        (["tradeoff", "minimal", "--error", "2"], "'2' is above 1 (100 %); for 2 per cent write 2%"),
        (
            ["check", "minimal", "--torque", "3"],
            "arguments: --torque 3. --torque is an option of gears, design, inspect. Help:",
        ),
        (["check", "minimal", "--quieet"], "Did you mean --quiet?"),
        (["check", "minimal", "--xyz"], "arguments: --xyz. Help:"),
        (["chek", "minimal"], "Did you mean check? Help: gearcase COMMAND --help"),
        (["runs", "clena"], "Did you mean clean? Help: gearcase runs --help"),
        (["tradeoff", "minimal", "--time", "2h"], "'2h' is not a time above 0 in s"),
        ([], "usage"),
    ],
)
def test_a_mistake_gives_exit_code_2_and_a_message(capsys, here, arguments, words):
    code, out, err = gearcase(capsys, *arguments)
    assert code == 2
    assert words in err
    assert "Traceback" not in err
    assert out == ""
    assert list(here.iterdir()) == []


def test_a_file_of_another_kind_is_named_with_the_command_that_reads_it(capsys, here):
    (here / "machine.toml").write_text("teeth = [[20, 31]]\nspeed_rpm = 1500\n", encoding="utf-8")
    (here / "plan.toml").write_text('scene = "minimal"\nscenes = 3\n', encoding="utf-8")
    (here / "scene.toml").write_text('extends = "minimal"\n', encoding="utf-8")
    for command in ("check", "run", "explain"):
        code, out, err = gearcase(capsys, command, "machine.toml")
        assert (code, out) == (2, "")
        assert "machine.toml: this is a machine file, and a scene is needed." in err
        assert "gearcase diagnose RECORD --machine machine.toml" in err
        code, out, err = gearcase(capsys, command, "plan.toml")
        assert (code, out) == (2, "")
        assert "plan.toml: this is the plan of a campaign, and a scene is needed." in err
        assert "gearcase campaign plan.toml" in err
    code, out, err = gearcase(capsys, "campaign", "scene.toml")
    assert (code, out) == (2, "")
    assert "scene.toml: this is a scene, and the plan of a campaign is needed." in err


@pytest.mark.parametrize("command", ["check", "explain"])
def test_a_quiet_command_does_not_list_what_a_preset_changes(capsys, here, command):
    assert "preset draft: " in gearcase(capsys, command, "minimal", "--preset", "draft")[2]
    code, _, err = gearcase(capsys, command, "minimal", "--preset", "draft", "--quiet")
    assert (code, err) == (0, "")


def test_check_prints_what_follows(capsys):
    code, out, _ = gearcase(capsys, "check", "rig-missing-tooth")
    assert code == 0
    for words in ("20/55", "300", "5.4545", "23.9881", "bearing_8", "control: rig-healthy", "missing-tooth 0"):
        assert words in out


def test_new_then_check(capsys, here):
    assert gearcase(capsys, "new", "my.toml", "--from", "rig-missing-tooth")[0] == 0
    assert gearcase(capsys, "check", "my.toml")[0] == 0
    code, _, err = gearcase(capsys, "new", "my.toml")
    assert code == 2
    assert "not overwritten" in err


def test_explain_builds_nothing(capsys, own_cache):
    code, out, _ = gearcase(capsys, "explain", "minimal")
    assert code == 0
    assert out.startswith("First run: ")
    assert not own_cache.exists()


def test_explain_of_another_scene_lists_its_stages_and_no_differences(capsys, own_cache):
    """After a run of minimal the differences of rig-missing-tooth to it filled 21,398 letters."""
    from pipelines.engine.cache import Cache
    from pipelines.engine.run_graph import run_graph
    from pipelines.steps.run_plan import plan_run

    scene = load_scene("minimal", {"simulation.end_s": 0.01, "diagnosis.windows_s": {}})
    run_graph(plan_run(scene).graph, Cache(), ["simulate"])
    code, out, _ = gearcase(capsys, "explain", "rig-missing-tooth")
    assert code == 0
    assert out.startswith("First run: ")
    assert "->" not in out
    assert "healthy simulate" in out
    assert len(out) < 2000
    code, out, _ = gearcase(capsys, "explain", "minimal", "--set", "load.container_kg=80")
    assert "First run" not in out
    assert "machine.load.torque 27.949 -> 19.6133" in out


def test_cache_info_verify_and_clear(capsys, own_cache):
    from pipelines.engine.cache import Cache

    entry = Cache().store("law", "0" * 64, lambda folder: (folder / "a").write_bytes(b"abc"))
    assert "law                  1 entry " in gearcase(capsys, "cache")[1]
    (entry.folder / "a").write_bytes(b"abd")
    code, out, _ = gearcase(capsys, "cache", "verify")
    assert code == 1
    assert "does not match its checksum" in out
    assert gearcase(capsys, "cache", "clear")[0] == 0
    assert not (own_cache / "entries").exists()


def raising(error):
    def main(options):
        raise error

    return main


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "Finished steps are kept"),
        (ZeroDivisionError("division by zero"), 1, "ZeroDivisionError: division by zero"),
        (ValueError("from a library"), 1, "ValueError: from a library"),
    ],
)
def test_failures_of_the_work(capsys, monkeypatch, error, code, words):
    monkeypatch.setattr("pipelines.cli.check.main", raising(error))
    found, _, err = gearcase(capsys, "check", "minimal")
    assert found == code
    assert words in err
    assert "Traceback" not in err
    if code == 1:
        assert "Traceback" in gearcase(capsys, "check", "minimal", "-v")[2]


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_sigterm_is_an_interrupt(capsys, monkeypatch):
    """So that child processes end, and what they share is removed; afterwards SIGTERM is what it was."""
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr("pipelines.cli.check.main", lambda options: os.kill(os.getpid(), signal.SIGTERM))
    code, _, err = gearcase(capsys, "check", "minimal")
    assert (code, "interrupted" in err) == (130, True)
    assert signal.getsignal(signal.SIGTERM) == before


def test_our_own_work_errors_are_one_message(capsys, monkeypatch):
    from pipelines.io.errors import WorkError

    monkeypatch.setattr("pipelines.cli.check.main", raising(WorkError("no convergence at t = 1 s")))
    assert gearcase(capsys, "check", "minimal") == (1, "", "gearcase: no convergence at t = 1 s\n")


def test_the_version(capsys):
    code, out, _ = gearcase(capsys, "--version")
    assert code == 0
    assert out.startswith("gearcase ")


SHORT = (
    "--set", "simulation.end_s=0.05", "--set", "drive.times_s=[0.0, 0.02, 0.05]",
    "--set", "diagnosis.windows_s={}",
)  # fmt: skip


def test_a_killed_export_leaves_the_old_file(capsys, here, monkeypatch):
    """Nothing of a file is to be seen before it is whole: not the first half of a table, nor an empty picture."""
    gearcase(capsys, "simulate", "minimal", *SHORT, "--out", "mine")
    target = here / "signals.csv"
    target.write_text("old", encoding="utf-8")

    def killed(run, path, form):
        path.write_text("time", encoding="utf-8")
        assert target.read_text(encoding="utf-8") == "old"
        raise KeyboardInterrupt

    monkeypatch.setattr("pipelines.diagnosis.result_export.export", killed)
    assert gearcase(capsys, "export", "mine", "--to", "csv", "--out", "signals.csv")[0] == 130
    assert target.read_text(encoding="utf-8") == "old"
    assert sorted(path.name for path in here.iterdir()) == ["mine", "signals.csv"]


def test_simulate_then_export(capsys, here):
    code, out, err = gearcase(capsys, "simulate", "minimal", *SHORT, "--out", "mine", "--quiet")
    assert (code, err) == (0, "")
    assert "response.nc" in out
    assert sorted(p.name for p in (here / "mine").iterdir()) == [
        "log.jsonl", "response.nc", "run.json", "scene.asked.toml", "scene.resolved.toml"
    ]  # fmt: skip
    facts = json.loads((here / "mine" / "run.json").read_text(encoding="utf-8"))
    assert facts["ledger"]["recovery_rows"] == 3
    assert facts["ledger"]["rope_coordinates"] == 0
    assert "meshes" not in facts["ledger"]
    assert gearcase(capsys, "export", "mine", "--to", "csv")[0] == 0
    assert (here / "mine" / "response.csv").stat().st_size > 1000
    assert gearcase(capsys, "export", "mine", "--to", "uff")[0] == 0
    assert (here / "mine" / "response.uff").read_text(encoding="ascii").count("\n    58\n") > 10
    assert gearcase(capsys, "simulate", "minimal", "--out", "mine")[0] == 2


def test_gears_and_casing_print_what_they_built(capsys):
    code, out, _ = gearcase(capsys, "gears", "minimal", "--quiet")
    assert code == 0
    assert "secant N/um" in out
    code, out, _ = gearcase(capsys, "casing", "minimal", "--quiet")
    assert code == 0
    assert "casing rigid: 6 coordinates" in out
    assert "bearing_4" in out


def test_a_plot_that_cannot_be_written_is_refused_before_anything_is_computed(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["tradeoff", "minimal", "--out", "plot.xyz"])
    assert ended.value.code == 2
    assert "does not end in .png, .svg or .pdf" in capsys.readouterr().err


@pytest.mark.slow
def test_inspect_writes_a_picture_or_says_why_not(capsys, here):
    code, out, _ = gearcase(capsys, "inspect", "minimal", "--out", "pictures", "--quiet")
    assert code == 0
    assert (here / "pictures" / "gears_1.png").is_file() or "left out" in out
    assert gearcase(capsys, "inspect", "minimal", "--stage", "2")[0] == 2


def test_a_repeated_run_builds_nothing_and_takes_at_most_2_s(capsys, here):
    """Seconds of the processor for the work itself, in a process that has its modules loaded."""
    gearcase(capsys, "simulate", "minimal", *SHORT)
    start = time.process_time()
    code, _, _ = gearcase(capsys, "simulate", "minimal", *SHORT)
    assert code == 0
    assert time.process_time() - start < 2.0
    newest = (here / "runs" / "minimal" / "latest.txt").read_text(encoding="utf-8").strip()
    facts = json.loads((here / "runs" / "minimal" / newest / "run.json").read_text(encoding="utf-8"))
    assert all(step["reused"] for step in facts["steps"])


def test_an_unknown_option_is_refused_by_its_command(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["inspect", "pair", "--nothing"])
    assert ended.value.code == 2
    err = capsys.readouterr().err
    assert "gearcase inspect: error: unrecognized arguments: --nothing" in err
    assert "Help: gearcase inspect --help" in err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("bearings.designation=6208", 'It belongs to model = "hertz": set that, or delete the key.'),
        ("faults.1.length_mm=3", 'It belongs to kind = "spalled-tooth" or kind = "pitted-tooth"'),
        (
            "casing.housing.wall_thickness_mm=100",
            ": 1 problem\n  casing.housing: wall thickness 100 mm fills",
        ),
        ("shafts.1.bearing_positions_mm=[0]", 'Set two bearing_positions_mm whose bearing_supports is "casing"'),
    ],
)
def test_a_problem_is_the_cause_with_its_remedy(capsys, change, words):
    code, _, err = gearcase(capsys, "check", "bench", "--set", change)
    assert code == 2
    assert words in err


def test_a_misspelt_key_is_one_problem(capsys, tmp_path):
    text = (
        (resources.files("pipelines.scene") / "shipped" / "minimal.toml")
        .read_text(encoding="utf-8")
        .replace("\nface_width_mm", "\nface_width_m")
    )
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    code, _, err = gearcase(capsys, "check", str(tmp_path / "own.toml"))
    assert code == 2
    assert ": 1 problem\n" in err
    assert "Did you mean face_width_mm?" in err


def test_a_simulation_shorter_than_its_windows_is_named_as_the_cause(capsys):
    code, out, _ = gearcase(capsys, "check", "bench", "--set", "simulation.end_s=0.3")
    assert code == 0
    assert "no window in diagnosis.windows_s that ends by simulation.end_s = 0.3" in out


def test_a_run_that_is_no_scene_is_not_proposed_as_one(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = gearcase(capsys, "export", "nosuch", "--to", "mat")
    assert code == 2
    assert "gearcase run nosuch" not in err
    assert "`gearcase runs` lists" in err


def test_a_stage_beyond_the_only_one(capsys):
    code, _, err = gearcase(capsys, "inspect", "minimal", "--stage", "4")
    assert code == 2
    assert "Set 1, the only stage of the scene." in err


def test_a_warning_is_printed_once():
    new = _first_time(set())
    records = [logging.LogRecord("x", level, "", 0, "load %d", (1,), None) for level in (30, 30, 20, 20)]
    assert [new(record) for record in records] == [True, False, True, True]
