"""What the stages of a run compute: one module per stage, a spec and a function of it. See pipelines.chain."""
