"""Error bars of spectrum lines: what the casing's mesh, and inputs that are not known well, leave open of a level."""
