"""`gearcase verify rig`: check the claims of the published study of the rig."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import QUIET, STEPS_AT_ONCE, argument, work_of
from pipelines.io.argument_types import path, several
from pipelines.scene.presets import PRESETS

ARGUMENTS = (
    argument("what", metavar="WHAT", choices=("rig",), help="study to check: rig, the quay-crane hoist rig"),
    argument("--seeds", type=several, metavar="N", default=5, help="seeds of the deviations, 2 or more (default 5)"),
    argument(
        "--preset",
        choices=PRESETS,
        default="standard",
        help="accuracy of meshes and time step, from coarse (draft) to fine (reference) (default standard)",
    ),
    argument("--out", metavar="FOLDER", type=path, help="folder for claims.md and claims.json (default: print only)"),
    STEPS_AT_ONCE,
    QUIET,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Check the claims of a published study of a quay-crane hoist with a missing tooth. Print each claim with its
    limit, simulate the 8 scenes of the study with each seed, and print whether each claim holds. With --out,
    write claims.md and claims.json. Takes about 2 minutes on two cores, and longer with an empty cache.

    Example
    -------
    gearcase verify rig --out claims
    ...
    claims/claims.md
    claims/claims.json
    """
    from pipelines.engine.code_version import library_versions
    from pipelines.io.user_files import writable_folder
    from pipelines.studies.verification import claims_output
    from pipelines.studies.verification.rig import simulated

    folder = writable_folder(options.out) if options.out else None
    yield claims_output.stated()
    evidence = simulated(options.seeds, options.preset, work_of(options))
    found = claims_output.verdicts(evidence)
    yield claims_output.text(found)
    if folder is not None:
        facts = {"preset": options.preset, "seeds": options.seeds, "versions": library_versions("gearcase")}
        yield from map(str, claims_output.write(folder, evidence, found, facts))
