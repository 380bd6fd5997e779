"""Commands that repeat a scene in variants, to learn how far its answer can be trusted."""
