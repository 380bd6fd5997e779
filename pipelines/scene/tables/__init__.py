"""The tables a scene is made of, by subject; `pipelines.scene.scene` puts them together."""
