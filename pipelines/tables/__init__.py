"""The tables a scene is made of, by subject; `pipelines.scene` puts them together."""
