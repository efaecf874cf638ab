"""What both halves of the bench of the camera's receiver are built for."""

from golden.video.formats import CameraFormat


__all__ = ["FORMAT"]


#: A camera of a few lines, so that a bench has time for films with every fault.
FORMAT = CameraFormat(width=6, field_lines=3, blanking=6, before_top=2, after_top=1, before_bottom=1, after_bottom=1)
