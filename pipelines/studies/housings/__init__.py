"""`gearcase housing`: what a file of a housing holds, as text, as pictures and as a block for a scene."""
