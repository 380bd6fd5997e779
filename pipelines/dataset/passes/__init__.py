"""Passes over a whole data set: is it sound, and what features do its signals have."""
