"""Error bars of spectrum lines: numerical uncertainty by casing mesh and time step, and effect of uncertain damping."""
