from .hdl import *  # noqa: F403
