"""The scene in SI: gears, shafts, bearings, load, housing, and what is wrong with them."""
