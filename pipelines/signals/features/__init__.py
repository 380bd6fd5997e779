"""Features of vibration signals: statistics over time, synchronous averages and envelopes over the shaft angle."""
