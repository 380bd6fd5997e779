"""One module per command of `gearcase`, imported only when it is asked for."""
