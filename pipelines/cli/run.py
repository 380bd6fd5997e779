"""`gearcase run`: simulation, healthy control, diagnosis and report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path


def main(options: argparse.Namespace) -> int:
    """Run the scene; print the verdict and where the report is."""
    if not options.quiet:
        from pipelines.io.shown import shown

        sys.stderr.write(f"gearcase run {shown(str(options.scene))}\n")  # before the imports, which take a while
    from pipelines.engine.working import Work
    from pipelines.runs.run import Options, run_scene
    from pipelines.runs.run_folder import REPORT
    from pipelines.scene.presets import load_asked

    finished = run_scene(
        load_asked(options),
        Options(
            out=options.out,
            with_control=not options.no_control,
            both_loads=not options.one_load,
            seeds=options.seeds,
            baseline=options.baseline,
            work=Work(processes=options.processes, quiet=options.quiet),
        ),
    )
    built = [record for record in finished.records if not record.reused]
    seconds = sum(record.seconds for record in built)
    if finished.words:
        sys.stdout.write(finished.words.partition("\n\n")[0] + "\n")
    for reason in finished.left_out:
        sys.stdout.write(f"{reason}\n")
    sys.stdout.write(
        f"{len(built)} steps computed in {seconds:.1f} s of processing, {len(finished.records) - len(built)} reused.\n"
        f"report: {finished.folder / REPORT}\n"
    )
    sys.stdout.write("next:\n" + "".join(f"  {command}\n      {what}\n" for command, what in _next(options)))
    return 0


def _next(options: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """Two commands that follow a first run, and what they do; as this one was typed where PATH does not hold it."""
    import shlex
    import shutil

    from pipelines.io.shown import shown

    typed = sys.argv[0]
    program = shlex.quote(typed) if Path(typed).name == "gearcase" and not shutil.which("gearcase") else "gearcase"
    scene = shown(shlex.quote(str(options.scene)))
    run = shown(shlex.quote(str(options.out or options.scene)))
    yield f"{program} runs open {run}", "open the report in a browser"
    if str(options.scene).endswith(".toml") or Path("my.toml").exists():
        yield f"{program} inspect {scene}", "write pictures of its gears and its casing"
    else:
        yield f"{program} new my.toml --from {scene}", "write a commented copy of the scene to change"
