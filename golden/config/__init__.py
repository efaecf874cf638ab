"""Parameters of a matcher: the vocabulary that golden model, gateware, benches and builds share.

May import nothing of the project.
"""

from .fused import FUSED_1, FUSED_2, FUSED_3, Arms, Fused, FusedCost, Vertical
from .limits import (
    IN_USE_BITS,
    LEAST_MINIMUM,
    MINIMUM_BITS,
    PIXEL_BITS,
    PIXEL_MAX,
    WEIGHT_BITS,
    WEIGHT_MAX,
    Arithmetic,
    Engine,
    MatchingCost,
    Setting,
    Weights,
)
from .matcher import MatcherConfig
from .method import Method, RefinedMethod, RuleMethod, changed, parameters_of, value_of
from .one_pass import OnePass
from .recursive import (
    RECURSIVE_1,
    RECURSIVE_2,
    GradedArms,
    LineBelow,
    Propagation,
    Recursive,
    RecursiveCost,
    WeightedRefinement,
)
from .refinement import CONFIDENCE_BITS, Refinement


__all__ = ["Arithmetic", "Arms", "CONFIDENCE_BITS", "Engine", "FUSED_1", "FUSED_2", "FUSED_3", "Fused", "FusedCost", "GradedArms",
           "IN_USE_BITS", "LEAST_MINIMUM", "LineBelow", "METHODS", "MINIMUM_BITS", "MatcherConfig", "MatchingCost", "Method", "OnePass",
           "PIXEL_BITS", "PIXEL_MAX", "Propagation", "RECURSIVE_1", "RECURSIVE_2", "Recursive", "RecursiveCost",
           "RefinedMethod", "Refinement", "RuleMethod", "Setting", "Vertical", "WEIGHT_BITS", "WEIGHT_MAX", "WeightedRefinement",
           "Weights", "changed", "parameters_of", "value_of"]


#: The methods by name; a method's place is its number in the register map.
METHODS: dict[str, type[Method]] = {method.name: method for method in (OnePass, Fused, Recursive)}
