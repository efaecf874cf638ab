"""Rival methods: those of the thesis's Table 1, OpenCV's, and the exact cuts of its Appendix A; and the commands that measure them.

``registry`` names all methods, ours too; the commands are ``command`` (`golden rivals`), ``gaps`` and ``compare``.
May import ``golden.lab``, ``golden.pictures``, ``golden.matcher`` and ``golden.config``, never ``golden.lab.thesis``.
"""
