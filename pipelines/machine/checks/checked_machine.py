"""The machine model of a scene that passes all checks that need no computation, for every command."""

from __future__ import annotations

from pipelines.io.errors import Problems, SceneError
from pipelines.machine.checks.collisions import find_collisions
from pipelines.machine.checks.cost import too_long
from pipelines.machine.checks.flank_checks import bad_flanks
from pipelines.machine.checks.shaft_checks import long_shafts, off_shaft, unheld
from pipelines.machine.checks.strength import bursting, overloaded
from pipelines.machine.checks.window_checks import bad_windows
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import REFUSALS, drivetrain, in_casing
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.scene import Scene


def checked_machine(scene: Scene, source: str) -> MachineModel:
    """The machine model of a scene that passes all checks that need no computation.

    Raises
    ------
    SceneError : lists all problems of the scene
    """
    made = Problems(*REFUSALS)
    train = drivetrain(scene, lay_out(scene, source), made)
    layout = train.layout
    places = [*off_shaft(scene, layout)]
    problems = [
        *find_collisions(scene, train),
        *bad_flanks(scene, train),
        *overloaded(scene, layout),
        *bursting(scene, layout),
        *too_long(train),
        *places,
    ]
    machine = in_casing(train, scene, made)
    if machine is None:
        # parts beyond the end of their shaft are already listed by their keys
        more = [one for one in dict.fromkeys(made) if not (places and one.path == "shafts")]
        raise SceneError(source, [*problems, *more])
    if not places:
        problems += long_shafts(machine.parts)
    problems += unheld(machine)
    if scene.housing is not None:
        from pipelines.machine.checks.casing_checks import bad_casing

        problems += bad_casing(scene, machine)
    if scene.control is not None:  # without a control there is no diagnosis
        problems += bad_windows(scene, machine)
    if problems:
        raise SceneError(source, problems)
    return machine
