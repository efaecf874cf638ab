"""Cameras in, memory, monitor out: what turns the matcher into a system."""
