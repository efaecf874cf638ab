"""Parameters of a matcher: the vocabulary that golden model, gateware, benches and builds share.

May import nothing of the project.
"""

from .matcher import (
    FUSED_1,
    FUSED_2,
    FUSED_3,
    IN_USE_BITS,
    MINIMUM_BITS,
    PIXEL_BITS,
    PIXEL_MAX,
    WEIGHT_BITS,
    WEIGHT_MAX,
    Arithmetic,
    Cost,
    Engine,
    FusedParameters,
    MatcherConfig,
    Refinement,
)


__all__ = ["Arithmetic", "Cost", "Engine", "FUSED_1", "FUSED_2", "FUSED_3", "FusedParameters", "IN_USE_BITS", "MINIMUM_BITS",
           "MatcherConfig", "PIXEL_BITS", "PIXEL_MAX", "Refinement", "WEIGHT_BITS", "WEIGHT_MAX"]
