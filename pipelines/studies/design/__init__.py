"""Search for flank modifications with the least transmission error, level or pressure, nominal or with deviations."""
