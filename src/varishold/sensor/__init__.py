"""The sensor: what it makes of pressure, written down once, forward and back."""
