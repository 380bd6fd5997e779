"""Torques from outside: drives that give a torque, loads that take one, with or without a rotor of their own."""
