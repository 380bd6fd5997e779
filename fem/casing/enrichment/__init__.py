"""Edge-singularity enrichment: functions added to hexahedra at edges where the exact stresses are singular."""
