"""`gearcase verify rig`: what the study of the rig claims, put to the test."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Print the measures, simulate the cases, print the verdicts; write them if a folder is given."""
    from pipelines.engine.code_version import library_versions
    from pipelines.engine.working import Work
    from pipelines.io.user_files import writable_folder
    from pipelines.studies.verification import page
    from pipelines.studies.verification.rig import simulated

    folder = writable_folder(options.out) if options.out else None
    sys.stdout.write(f"{page.stated()}\n")
    sys.stdout.flush()
    work = Work(processes=options.processes, quiet=options.quiet)
    evidence = simulated(options.seeds, options.preset, work)
    found = page.verdicts(evidence)
    sys.stdout.write(page.text(found))
    if folder is not None:
        facts = {"preset": options.preset, "seeds": options.seeds, "versions": library_versions("gearcase")}
        for path in page.write(folder, evidence, found, facts):
            sys.stdout.write(f"{path}\n")
    return 0
