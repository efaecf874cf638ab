"""What a bitstream was built from, as constants that its host compares: release and parameters must be the host's, as golden is."""

import importlib.metadata
import json
import zlib
from typing import Any

from ..config import MatcherConfig


__all__ = ["parameter_digest", "release"]


#: Parameters of methods that change how the gateware computes, and nothing of what it gives.
_WITHOUT_EFFECT = ("soft_multipliers",)


def release(version: str | None = None) -> int:
    """Version of this project in 16 bits: that of the gateware must be the host's, as the golden model is the host's.

    Examples
    --------
    >>> release("0.2.1") == 0 << 12 | 2 << 6 | 1
    True
    """
    major, minor, patch = (version or importlib.metadata.version("stereo-graph-cut")).split(".")[:3]
    return int(major) % 16 << 12 | int(minor) % 64 << 6 | int(patch) % 64


def parameter_digest(config: MatcherConfig) -> int:
    """32 bits that differ, but for chance, where two builds of a method give different results with the same settings.

    What a host can set does not enter it, nor does what changes no result.

    Examples
    --------
    >>> from golden.config import FUSED_1, FUSED_2, changed
    >>> digests = [parameter_digest(MatcherConfig(method=method)) for method in (FUSED_1, changed(FUSED_1, u1=5, fill=False), FUSED_2)]
    >>> digests[0] == digests[1] != digests[2]
    True
    """
    bare = config.method.with_settings({name: setting.minimum for name, setting in config.settings.items()})
    about: dict[str, Any] = {name: value for name, value in bare.about().items() if name not in _WITHOUT_EFFECT}
    return zlib.crc32(json.dumps([config.method.name, about], sort_keys=True, default=str).encode())
