"""Pictures: files and formats, stereo pairs with ground truth, synthetic scenes, metrics, sheets, depth.

``images`` and ``text`` read and write files, ``dataset`` and ``scenes`` give pairs, ``metrics`` judges disparities, ``sheet`` draws them.
May import ``golden.config``, ``golden.files``, ``golden.errors`` and ``golden.cli``, never ``golden.matcher`` or ``golden.lab``.
"""
