"""Teeth as they are drawn: shape with its damage, place in the scene, what they do in mesh."""
