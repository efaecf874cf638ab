"""Calibration of two mounted cameras, with OpenCV: corners of a chessboard, cameras, the maps of ``golden.rig``, and reports of them.

``views`` finds corners, ``solve`` cameras, ``sources`` reads them from files of others, ``rectified`` and ``flat`` make maps, ``outputs``
and ``picture`` write them, ``command`` is ``golden calibrate``. May import ``golden.rig`` and ``golden.pictures``.
"""
