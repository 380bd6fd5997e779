"""Features of vibration signals: of the time alone, of the angle of a shaft, of the envelope; each with its source."""
