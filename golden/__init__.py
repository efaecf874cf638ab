"""The reference: what every block must compute. NumPy only; no cycles, no Amaranth."""
