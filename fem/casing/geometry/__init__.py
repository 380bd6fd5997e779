"""Dimensions of a parametric housing, and checks that they form a valid body."""
