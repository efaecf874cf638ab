"""A proof as data, and how it is carried out."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.kit.formal import told

from .claim import Claim, replayed


__all__ = ["FAMILIES", "Proof", "carried_out"]


#: Families of proofs, and what is claimed in each.
FAMILIES = {
    "streams": "what is offered holds until it is accepted, and `valid` and payload do not depend on `ready` of the same cycle",
    "order": "all words leave, in order, and nothing else does",
    "minimum": "sums, choices and minima equal the direct expression",
    "credits": "no queue overflows, and nobody waits longer than stated",
    "protocols": "lines and words of the outside are never violated",
}


@dataclass(frozen=True)
class Proof:
    """A claim about a component, and how it is proved.

    Members
    -------
    family : str
        One of :data:`FAMILIES`.
    name : str
        Unique; begins with the component's.
    claim : str
        In one sentence, or what it adds to that of the family.
    size : str
        The parameters of the component that is proved.
    build : function
        The claim, anew.
    depth : int or None
        Cycles of a bounded proof; ``None``: in all cycles.
    witness : int
        Cycles within which the claim's witness must be reached.
    quick : bool
        Takes at most a second or so: part of the default tests.
    """
    family: str
    name: str
    claim: str
    size: str
    build: Callable[[], Claim]
    depth: int | None = None
    witness: int = 25
    quick: bool = True


def _processor_seconds() -> float:
    """Of this process and of those that it has ended."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def carried_out(proof: Proof, folder: Path, *, timeout: float = 600) -> dict[str, Any]:
    """The result of a proof, of values that JSON has.

    ``result`` is ``proved``, ``bounded``, ``refuted``, ``waits for ready``, ``says nothing``: the witness is not reached, or ``timed out``;
    ``found`` tells why. ``registers`` of the circuit, and ``seconds`` of a processor for all of it.
    """
    begun = _processor_seconds()
    claim = proof.build()
    circuit = claim.circuit(folder)
    result, found = "bounded" if proof.depth else "proved", ""
    waiting = [name for name in claim.outputs if f"{name}.ready" in circuit.inputs_of(name)]
    try:
        verdict = circuit.check(proof.depth, timeout=timeout)
        if not verdict.holds:
            result, found = "refuted", f"{told(verdict.trace)}\n{replayed(proof.build(), verdict.trace)}"
        elif waiting:
            result, found = "waits for ready", ", ".join(waiting)
        elif not circuit.reaches(proof.witness, timeout=timeout):
            result, found = "says nothing", f"its witness is not reached within {proof.witness} cycles"
    except TimeoutError as error:
        result, found = "timed out", str(error)
    return {"result": result, "found": found, "registers": circuit.registers, "seconds": round(_processor_seconds() - begun, 2)}
