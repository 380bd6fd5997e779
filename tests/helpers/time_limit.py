"""How long a test waits for another process before it says that the process hangs.

No work here takes longer on a machine that has many other things to do: a limit that a busy machine can meet fails
tests of sound code.
"""

HANGING = 900.0  # s
