"""ECPIX-5 with an LFE5UM5G-85F: a pair of pictures over USB, matched, and back; its HDMI transmitter is not driven.
May import ``boards.ecp5``, ``boards.loop`` and ``golden``.
"""
