"""Search for flank modifications: least transmission error, pressure and stress, for the nominal pair or deviating ones."""
