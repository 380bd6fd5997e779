"""One module for each command of `gearcase`. A module is imported only when its command is given."""
