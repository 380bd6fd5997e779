"""From solid elements to a reduced body: condensation, modes, damping, and how good they are."""
