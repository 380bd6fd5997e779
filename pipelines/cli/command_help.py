"""What each command does, reads and writes, how long it takes as a rule, and what its example prints.

Lines that are left out of an output are shown as ``...``.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class CommandHelp:
    """Sentences above the options of a command, and the main lines of the output of its example."""

    text: str
    output: str


def example_text(example: str, found: CommandHelp) -> str:
    """The example of a command with its output, as it is shown below the options."""
    output = "".join(f"\n  {line}".rstrip() for line in found.output.splitlines())
    return f"example:\n  {example}{output}"


def action_parser(
    actions: Any, command: argparse.ArgumentParser, name: str, words: str, example: str
) -> argparse.ArgumentParser:
    """The parser of one action of a command such as `runs`, with its help.

    Parameters
    ----------
    actions : what `add_subparsers` of the command returned
    command : its parser
    name, words, example : of the action, one line on it, and a command line
    """
    found = HELP[f"{command.prog.split()[-1]} {name}"]
    made: argparse.ArgumentParser = actions.add_parser(
        name,
        help=words,
        description=found.text,
        epilog=example_text(example, found),
        formatter_class=command.formatter_class,
        allow_abbrev=False,
    )
    made.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        default=argparse.SUPPRESS,
        help="log each step, and print the traceback of an error",
    )
    return made


HELP = {
    "new": CommandHelp(
        text="""\
Write a commented scene file as a start for your own. The source is a shipped scene, your own scene, or a gear unit
in REXS. An existing file is never overwritten. Takes seconds.""",
        output="my.toml written from bench. Change it, then: gearcase check my.toml",
    ),
    "check": CommandHelp(
        text="""\
Check a scene file. Print ratios, frequencies, tooth forces, bearing positions, the shortest usable time windows, and
time, memory and disk space of a run. Nothing is simulated and no file is written. Takes seconds.""",
        output="""\
Quay-crane hoist rig, one tooth of the stage 1 wheel missing, container on rope
...
  control: rig-healthy
...""",
    ),
    "run": CommandHelp(
        text="""\
Simulate the machine and its healthy control, diagnose the fault from the signals and write a report.
The result folder holds report.html, response.nc (the signals), the diagnosis and the settings.
Takes under a minute for the scenes `minimal` and `bench`, and minutes for the scenes `rig-...`. The first run after
installation also compiles code for a minute or two. Results of earlier runs are reused from the cache.""",
        output="""\
One tooth of the stage 1 wheel chipped: seen at motor_side (axis z) in the one analysed window.
...
report: runs/bench/2026-11-25_01-02-13/report.html
...""",
    ),
    "simulate": CommandHelp(
        text="""\
Simulate the machine and write its signals to response.nc in a result folder, by default under ./runs.
There is no healthy control, no diagnosis and no report. Takes seconds for the scene `minimal`, and up to minutes for
the scenes `rig-...`.""",
        output="signals: runs/minimal/2026-11-25_00-50-21/response.nc",
    ),
    "runs": CommandHelp(
        text="""\
List the finished runs under ./runs, open the report of one, compare several, or remove old ones. Takes seconds.""",
        output="""\
Runs, newest first
run  scene                 folder     age   MB  differs in  verdict
---  -------  -------------------  ------  ---  ----------  -------------
  4  bench    2026-11-25_01-01-40  28 min  3.5  -           not diagnosed
  5  minimal  2026-11-25_00-50-21  40 min  5.6  -           not diagnosed
Nothing was removed. To remove these runs, repeat the command with --yes.""",
    ),
    "runs list": CommandHelp(
        text="List the finished runs under ./runs, newest first, with the settings in which they differ.",
        output="""\
Runs, newest first
run  scene                 folder     age   MB  differs in               verdict
---  -------  -------------------  ------  ---  -----------------------  -------------
  1  minimal  2026-11-25_01-27-24   2 min  1.1  load.container_kg=80.0   not diagnosed
  5  minimal  2026-11-25_00-50-21  40 min  5.6  load.container_kg=114.0  not diagnosed""",
    ),
    "runs open": CommandHelp(
        text="Open the report of a run in the browser, and print its path.",
        output="runs/bench/2026-11-25_01-02-13/report.html",
    ),
    "runs compare": CommandHelp(
        text="Print the verdicts, the settings that differ and the sensor levels of several runs in one table.",
        output="""\
Runs side by side; all other settings are the same. rms: all axes of a sensor, over the whole run
                    run 1: minimal  run 5: minimal
------------------  --------------  --------------
...
load.container_kg   80.0            114.0
sensor_3, m/s2 rms  1.227           1.538
...""",
    ),
    "runs clean": CommandHelp(
        text="Show which runs would be removed. With --yes, remove them with all their files.",
        output="1 run removed, 5.6 MB freed",
    ),
    "diagnose": CommandHelp(
        text="""\
Print which component is damaged. A measured recording is compared with recordings of healthy machines (--baseline).
A finished run is compared with its healthy control. Nothing is simulated and no file is written. Takes seconds.""",
        output="""\
One tooth of the stage 1 wheel chipped: seen at motor_side (axis z) in the one analysed window.
...
line                  Hz  faulty m/s²  healthy m/s²  difference dB  over floor dB  healthy over floor dB  verdict
...
envelope f_r      10.081       0.0224       0.00656          +10.7          +28.7                  +22.8  detected
...""",
    ),
    "compare": CommandHelp(
        text="""\
Compare recordings, measured or simulated. Print a table of features; write it as CSV, and figures of order spectra,
envelope spectra and time-synchronous averages. The first recording is the reference. Takes seconds.""",
        output="""\
   recording               s  turns   rpm  f_m Hz  samples/s  speed from
-  -------------  ----------  -----  ----  ------  ---------  -------------------------
A  bench@0.5:0.9  0.5 to 0.9   10.0  1500     625      12800  recorded angle of shaft_1
B  bench@0.9:1.3  0.9 to 1.3   10.0  1500     625      12800  recorded angle of shaft_1
...
comparison/features.csv""",
    ),
    "orders": CommandHelp(
        text="""\
Analyse the run-up or coast-down of a finished run by orders of a shaft. Print the highest amplitude of each order.
Write pictures of the order spectra over speed, and of the amplitude of each order over speed. Takes seconds.""",
        output="""\
input-bearing z over the orders of shaft 1, 11 windows
  order  highest m/s2  at rpm   at Hz
-------  ------------  ------  ------
...
     46        0.0944    1470  1126.7
runs/reducer/2026-11-25_01-02-30/orders.png
...""",
    ),
    "export": CommandHelp(
        text="""\
Write the signals of a finished run as a CSV, MATLAB or universal file (UFF 58) for other programs. Takes seconds.""",
        output="runs/minimal/2026-11-25_00-50-21/response.mat",
    ),
    "gears": CommandHelp(
        text="""\
Compute the mesh stiffness, transmission error and load sharing of every gear pair, healthy and faulty, over one passage
of a tooth. Print tables and a proposal for tip relief. --plot plots the transmission error, --out writes the curves.
Takes seconds, and up to a minute for each pair with the mesh model `solid`.""",
        output="""\
...
stage  torque N m  flanks      order 1 um  order 2 um  order 3 um  order 4 um  order 5 um
-----  ----------  ----------  ----------  ----------  ----------  ----------  ----------
    1          50  unmodified      0.9229      0.6531      0.4129      0.1859    0.009963
...
stage 1: usual tip relief of both gears: length_mm = 2.07 (short) or 4.14 (long)
...
te.png""",
    ),
    "inspect": CommandHelp(
        text="""\
Write pictures of a gear pair in mesh with its stiffness curve and contact pattern, and of the casing mesh.
--stress, --mesh and --casing-mode write other pictures or files instead. Takes seconds, and up to minutes with the
mesh model `solid`.""",
        output="""\
gears_1.png
mesh_1.png
pattern_1.png
casing rigid: no mesh to show""",
    ),
    "housing": CommandHelp(
        text="""\
Read a housing from a CAD file, a mesh, or stiffness and mass matrices. Print its solids and bores, or a check of the
matrices. Write a picture and an HTML page of the solids and bores. With --scene, choose the bores that hold the
bearings (bearing seats), and write them to housing.toml. Takes seconds.""",
        output="""\
...
bore  solid  diameter mm  length mm         middle mm     axis  of 360 deg
----  -----  -----------  ---------  ----------------  -------  ----------
   1      1      95.0000     30.000  315.686, -135, 0  0, 1, 0         360
...
rig-housing-housing/housing.toml
...""",
    ),
    "casing": CommandHelp(
        text="""\
Mesh the casing of a scene and reduce it to its bearing points and modes. Print these points, natural frequencies with
error bands, and weight. --response writes frequency responses, --export the matrices or mode shapes. Takes seconds to
minutes.""",
        output="""\
casing rigid: 6 coordinates, 23 output channels
...
  bearing_1  x     0.00  y   -65.00  z     0.00 mm
...""",
    ),
    "modes": CommandHelp(
        text="""\
Linearise the loaded machine about its static equilibrium. Print natural frequencies, damping and the share of each
part in the energy of each mode. No motion is simulated. Takes seconds if the cache holds mesh stiffness and casing.""",
        output="""\
minimal: small vibrations about the loaded static equilibrium, stage 1 at mesh cycle 0
mode  frequency Hz  damping ratio %  shafts %  bearings %  casing %  drive %  mesh 1 %  dominant
...
   1        112.84            6.186      58.1         4.3       0.3     34.8       2.5  motor coupling
...
mesh 1: force 1061 N, tangent stiffness 146.9 N/um
...""",
    ),
    "converge": CommandHelp(
        text="""\
Compute a scene with several values of one setting, from fine to coarse. Print the observed order of convergence, the
extrapolated value and the error band of each result, and write a plot. Takes seconds to minutes for each value.""",
        output="""\
...
The setting in use is fine enough for 1 %: the widest error band is 0.1 % (sensor_3 rms, lifting).
...
plot: convergence-minimal-step.png""",
    ),
    "tradeoff": CommandHelp(
        text="""\
Measure time, memory and error of every model and main setting. The error is the deviation from the preset
`reference`. Print a table, the least expensive choice within --error and the most accurate within --time; write a
plot. Takes about a minute for the scene `minimal`, and about 5 minutes for the scenes `rig-...`.""",
        output="""\
...
Within 2 % error of sensor rms, the least expensive choice is together: standard laws, 100 us (1.91 s, 0.36 %).
...
plot: tradeoff-minimal.png""",
    ),
    "starts": CommandHelp(
        text="""\
Simulate a scene from several slightly different initial states. Print mean and spread of the level of each sensor.
Use it where a motion is chaotic, so that levels depend on the initial state. Takes one simulation for each start.""",
        output="""\
8 initial states
...
level                        mean  95 % interval of the mean +/-  standard deviation  lowest  highest
...
sensor_3 rms, lifting, m/s2  1.55                      4.696e-07           5.617e-07    1.55     1.55""",
    ),
    "detect": CommandHelp(
        text="""\
Simulate healthy and damaged machines with different gear deviations. Print and write the probability of detection and
the rate of false alarms over damage size, sensor noise and sensors. Takes minutes to hours: use --dry-run first.""",
        output="""\
scenes      88
labels      60 chipped-tooth, 28 healthy
...
time        about 4 minutes on 2 cores: ...
disk        about 335 MB in 88 files per signal""",
    ),
    "campaign": CommandHelp(
        text="""\
Simulate all scenes of a plan and write them as one labelled data set. Repeat the command to continue after an
interruption. Takes minutes to hours: use --dry-run first.""",
        output="""\
scenes      240
labels      80 chipped-tooth, 80 cracked-tooth, 80 healthy
...
time        about 4 minutes on 2 cores: ...
disk        about 144 MB in 240 files per signal""",
    ),
    "dataset": CommandHelp(
        text="""\
Summarise, check or export a data set of `gearcase campaign`, or compute its features. Takes seconds to minutes.""",
        output="""\
...
  labels   6 healthy
  split    4 train, 2 test; 6 groups
...""",
    ),
    "dataset info": CommandHelp(
        text="""\
Print the numbers of runs by label and by part of the split (train, validation, test), and the range of each variable.
Can be used while the campaign is running. Takes seconds.""",
        output="""\
...
  runs     6: 6 done
...
  labels   6 healthy
  split    4 train, 2 test; 6 groups
...""",
    ),
    "dataset check": CommandHelp(
        text="""\
Check the signals against their checksums, and the table of runs and labels against the plan. Print what is wrong and
what to do; the exit code is then 1. Takes seconds to minutes.""",
        output="6 rows of 6 runs checked: 0 errors, 0 warnings",
    ),
    "dataset features": CommandHelp(
        text="""\
Compute statistical and order features of every run, and write them to features.parquet in the data set.
Repeat the command to continue after an interruption. Takes seconds to minutes.""",
        output="""\
...
campaigns/plan/features.parquet: 18 lines""",
    ),
    "dataset export": CommandHelp(
        text="""\
Write runs, or pieces of them of equal length, with their labels to a file for other programs. The data set itself is
not changed. Takes seconds to minutes.""",
        output="""\
16 pieces
...""",
    ),
    "verify": CommandHelp(
        text="""\
Check the claims of a published study of a quay-crane hoist with a missing tooth. Print each claim with its limit,
simulate the 8 scenes of the study with each seed, and print whether each claim holds.
With --out, write claims.md and claims.json. Takes about 5 minutes on two cores, and longer with an empty cache.""",
        output="""\
...
claims/claims.md
claims/claims.json""",
    ),
    "explain": CommandHelp(
        text="""\
Print which steps of a run would be reused from the cache, which would be computed, and which changed setting is the
reason.
Nothing is computed and no file is written. Takes seconds.""",
        output="""\
First run: the cache holds no results of a similar scene to compare with.
...
compute  law_1
...""",
    ),
    "schema": CommandHelp(
        text="""\
Print the JSON schema of scene files, with which an editor completes and checks keys and values. Takes a second.""",
        output="scene.schema.json",
    ),
    "completion": CommandHelp(
        text="""\
Print the script by which a shell completes commands, options and file names. For bash, write it to
~/.local/share/bash-completion/completions/gearcase; for zsh, to a file _gearcase in a folder of `fpath`.""",
        output="""\
...
_shtab_gearcase_runs_subparsers=(list open compare clean)
...""",
    ),
    "cache": CommandHelp(
        text="""\
Show the size of the cache, verify its checksums, or clear it. The cache stores the results of computed steps, which
all scenes reuse. After clearing, runs compute these steps again. Takes seconds.""",
        output="""\
...
  casing               1 entries        0.0 MB
...
  all                  6 stored         6.2 MB""",
    ),
}
