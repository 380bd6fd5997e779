"""Write the parametric housing of a scene as STEP.

`python -m pipelines.machine.housing_file SCENE FILE.step [PATH=VALUE ...]`.

So were the files in the package `meshes` made, see its README.
"""

from __future__ import annotations

import sys
from pathlib import Path


def main(arguments: list[str]) -> int:
    """Write the file; the hash of its content goes to standard output."""
    from fem.casing.geometry.housing import Housing
    from fem.casing.mesh.imported import content_hash
    from fem.casing.mesh.mesher import write_step
    from pipelines.io.errors import InputError
    from pipelines.machine.machine import make_plant
    from pipelines.scene.file import load_scene

    name, target, *settings = arguments
    scene = load_scene(name, settings).scene
    made = make_plant(scene).structure.housing
    if not isinstance(made, Housing):
        raise InputError(f"{name}: has no parametric housing. Set a scene whose casing.housing.model is parametric.")
    write_step(made, Path(target))
    sys.stdout.write(f"{target} {content_hash(Path(target))}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
