"""Golden models of the system around the matcher: video formats, layout and bandwidth of the memory, pairing of frames, display, set-up of
the video chips. May import ``golden.config``.
"""
