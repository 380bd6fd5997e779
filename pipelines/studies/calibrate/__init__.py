"""Calibration: free keys of a scene estimated from recordings of a healthy machine."""
