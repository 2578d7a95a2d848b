"""Perceive: size from the grip, the surface under each pad, and the object from a sequence of touches."""
