"""Gateware of the matcher, in Amaranth; every component names its golden function."""
