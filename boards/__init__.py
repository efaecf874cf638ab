"""Pins and quirks of boards, nothing else."""
