"""Forces that vary with time or turn with a shaft."""
