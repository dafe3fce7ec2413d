"""Devices that push back: styli with motors, and what stands in for them."""
