"""From a mesh law to forces: the compiled evaluation, and the curves and line loads read from it."""
