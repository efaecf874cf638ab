"""Pictures for scripts outside the project, by the name that version 0.1 had: all of it is :mod:`golden.pictures.dataset`."""

from .pictures.dataset import StereoPair, load_pair, load_pairs, motorcycle


__all__ = ["StereoPair", "load_pair", "load_pairs", "motorcycle"]
