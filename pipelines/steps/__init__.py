"""The steps of a run: the graph, and one module per step with a spec and a function of it."""
