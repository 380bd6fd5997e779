"""The energy balance, by part and kind."""
