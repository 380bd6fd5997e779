"""Search for flank modifications with the least transmission error and pressure, nominal or with deviations."""
