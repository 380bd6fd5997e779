"""``python -m gearcase``: the command, in any folder: modules are not taken from the working folder."""

import os
import sys

from gearcase.shadowed_packages import HOME

if __name__ == "__main__":
    here = os.path.realpath(os.getcwd())
    if here != str(HOME):
        sys.path[:] = [entry for entry in sys.path if os.path.realpath(entry or here) != here]
    from pipelines.cli.main import program

    sys.exit(program())
