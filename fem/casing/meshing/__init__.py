"""From a housing, whatever it comes from, to tetrahedra with named patches."""
