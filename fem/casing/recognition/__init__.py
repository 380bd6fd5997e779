"""What a housing from a file holds: solids, bores, flat faces, bolt patterns, and where the shafts of a machine fit."""
