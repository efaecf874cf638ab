"""Calibration of two mounted cameras, with OpenCV: corners of a chessboard, cameras, the maps of ``golden.rig``, and reports of them.

``views`` and ``pairs`` find corners, ``solve`` cameras, ``sources`` reads cameras of others, ``rectified`` and ``flat`` make maps,
``results``, ``outputs`` and ``picture`` write what is found, ``command`` is ``golden calibrate``. May import ``golden.rig`` and
``golden.pictures``.
"""
