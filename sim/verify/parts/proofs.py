"""The part *proofs*: what is proved for all inputs, of which component, in which size."""

import argparse
import importlib
import pkgutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from golden.errors import UserError

from .. import proofs
from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from ..proofs.proof import FAMILIES, Proof, carried_out


__all__ = ["HOLDS", "PART", "all_proofs"]


#: Results of a claim that holds.
HOLDS = ("proved", "bounded")


def all_proofs() -> dict[str, Proof]:
    """The catalogue: those of all modules of :mod:`sim.verify.proofs`, by ``family: name``."""
    modules = [importlib.import_module(f"{proofs.__name__}.{found.name}") for found in pkgutil.iter_modules(proofs.__path__)]
    found = [proof for module in modules for proof in getattr(module, "PROOFS", ())]
    found.sort(key=lambda proof: ([*FAMILIES].index(proof.family), proof.name))
    named = {f"{proof.family}: {proof.name}": proof for proof in found}
    assert len(named) == len(found)
    return named


def _prove(key: str, timeout: float) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        return carried_out(all_proofs()[key], Path(folder), timeout=timeout)


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--quick", action="store_true", help="only those of the default tests")
    parser.add_argument("--only", default="", metavar="WORD", help="only those with this in their name, such as a family or a component")
    parser.add_argument("--timeout", type=float, default=600, metavar="S", help="seconds for a run of the prover (default: %(default)g)")


def _run(options: argparse.Namespace) -> int:
    chosen = {key: proof for key, proof in all_proofs().items() if options.only in key and (proof.quick or not options.quick)}
    if not chosen:
        raise UserError(f"no proof has {options.only!r} in its name; python -m sim.verify proofs without --only tells all names")
    if options.record and len(chosen) < len(all_proofs()):
        raise UserError("a record is of all proofs; leave out --quick and --only")
    results = run_campaign("proofs", {key: (_prove, key, options.timeout) for key in chosen}, options,
                           digest_of_sources("golden", "hdl", "sim/kit", "sim/verify/proofs"))
    results = {key: results[key] for key in chosen}
    for key, result in results.items():
        print(f"{result['result']:10} {result['seconds']:8.2f} s  {key}")
        if result["found"]:
            print(result["found"])
    failed = sum(result["result"] not in HOLDS for result in results.values())
    print(f"{len(results)} claims, {failed} of them do not hold" if failed else f"{len(results)} claims, all of which hold")
    if options.record:
        write_record("proofs", "python -m sim.verify proofs --record", {"proofs": results})
    return int(failed > 0)


def _section(record: Mapping[str, Any]) -> list[str]:
    results, catalogue = record["proofs"], all_proofs()
    total = sum(result["seconds"] for result in results.values())
    bounded = sum(result["result"] == "bounded" for result in results.values())
    lines = [
        f"{len(results)} claims hold for all inputs in all orders: {len(results) - bounded} in any number of cycles, by property-directed "
        f"reachability (ABC's `pdr`), and {bounded} within the stated number of cycles, by bounded model checking (`bmc3`). A component "
        "is proved in a small size, which has all its parts; what is around it obeys its documentation and is otherwise free. Each claim "
        "has a witness: what it is about can happen. In each family deliberate faults are refuted, `tests/sim/verify/test_proofs.py`. "
        f"All took {total / 60:.1f} minutes of a processor."]
    for family, claim in FAMILIES.items():
        keys = [key for key in results if key.startswith(f"{family}: ")]
        if not keys:
            continue
        lines += ["", f"### {family.capitalize()}", "", f"{claim[0].upper()}{claim[1:]}.", "",
                  "| component | size | also, or but | in | registers | seconds |", "|---|---|---|---|---:|---:|"]
        for key in keys:
            proof, result = catalogue[key], results[key]
            depth = f"{proof.depth} cycles" if proof.depth else "any time"
            held = depth if result["result"] in HOLDS else f"**{result['result']}**"
            lines.append(f"| `{proof.name}` | {proof.size} | {proof.claim} | {held} | {result['registers']} | {result['seconds']:.1f} |")
    lines += ["", "Every component that sends a stream is in the first table, or its stream is, wire by wire, that of a part which is: "
              "`sim/verify/proofs/components.py` names these and those that send none, and a test holds the list complete. Further proofs: "
              "pairing of frames, `tests/hdl/video/test_pairing_proof.py`, and the rule of frames with sizes that change, "
              "`tests/hdl/interfaces/test_frame_rule.py`."]
    return lines


PART = Part("proofs", "what is proved for all inputs, of which component", _add_options, _run, _section)
