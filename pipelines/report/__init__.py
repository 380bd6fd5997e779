"""The one HTML file of a run."""
