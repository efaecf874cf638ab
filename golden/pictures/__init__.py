"""Pictures: files and formats, stereo pairs with ground truth, synthetic scenes, metrics, sheets, depth.

``images``, ``disparities`` and ``text`` read and write files through ``samples`` and ``netpbm``, ``white`` is what becomes 255,
``calibration_files`` and ``calibration_yaml`` read calibrations, ``dataset``, ``sets`` and ``scenes`` give pairs, ``masks`` tells which
pixels count, ``metrics`` judges disparities, ``sheet`` draws them.
May import ``golden.config``, ``golden.files``, ``golden.errors`` and ``golden.cli``, never ``golden.matcher`` or ``golden.lab``.
"""
