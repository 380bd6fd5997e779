"""Runs and their result folders."""
