"""The matcher: ``matcher`` is the whole between two streams, ``framed`` adds frame timing signals; in front of the engine a line buffer and
the stages on pixels. The rooms ``sequential`` and ``streaming`` are the engines, ``refine`` the stages on disparities.
May import ``golden.config``, ``golden.matcher`` and ``hdl.parts``.
"""
