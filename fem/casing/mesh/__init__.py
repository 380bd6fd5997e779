"""From a housing, whatever it comes from, to solid elements with named patches."""
