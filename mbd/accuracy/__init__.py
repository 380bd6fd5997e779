"""How true a motion is: error of its step, whether it can be repeated."""
