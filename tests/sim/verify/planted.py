"""Commands with one fault each, which the campaign of command lines must see: ``python -m tests.sim.verify.planted KIND``."""

import functools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

from golden.cli import Parser
from golden.errors import UserError, run_cli
from golden.files import write_json


def sound(options):
    write_json(options.output, {"input": options.input.name})


def crash(options):
    raise KeyError("u1")


def two_sentences(options):
    print("planted two_sentences: there is more to say", file=sys.stderr)
    raise UserError("that is wrong; do it right")


def no_remedy(options):
    raise UserError("that is wrong")


def other_name(options):
    print("python: that is wrong; do it right", file=sys.stderr)
    return 2


def silent(options):
    return 2


def other_status(options):
    return 3


def undocumented(options):
    print("planted undocumented: that is wrong; do it right", file=sys.stderr)
    return 1


def warns(options):
    warnings.warn("this will not do for ever", DeprecationWarning, stacklevel=2)
    sound(options)


def half(options):
    options.output.write_text('{"half": ')


def written(options):
    sound(options)
    raise UserError("that is wrong; do it right")


def removed(options):
    options.output.unlink(missing_ok=True)
    raise UserError("that is wrong; do it right")


def temporary(options):
    sound(options)
    Path(".0123456789abcdef.tmp").touch()


def temporary_folder(options):
    sound(options)
    tempfile.mkdtemp()


def changes_input(options):
    sound(options)
    options.input.write_bytes(b"\n")


def leaves_process(options):
    sound(options)
    subprocess.Popen(["sleep", "60"])


def slow(options):
    time.sleep(60)


def deaf(options):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(60)


def half_when_ended(options):
    with options.output.open("w") as file:
        file.write("{")
        file.flush()
        time.sleep(60)


FAULTS = {each.__name__: each for each in (
    sound, crash, two_sentences, no_remedy, other_name, silent, other_status, undocumented, warns, half, written, removed, temporary,
    temporary_folder, changes_input, leaves_process, slow, deaf, half_when_ended)}


def main(argv=None):
    argv = sys.argv[1:] if argv is None else argv
    outer = Parser(prog="planted")
    outer.add_argument("kind", choices=FAULTS)
    kind = outer.parse_args(argv[:1]).kind
    parser = Parser(prog=f"planted {kind}")
    parser.add_argument("input", type=Path, metavar="FILE", help="a picture")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE", help="write what was found there; suffix .json")
    parser.add_argument("--count", type=int, metavar="N", help="of nothing, 1 to 9")

    def run(rest):
        options = parser.parse_args(rest)
        if not options.input.is_file() or not os.access(options.input, os.R_OK):
            raise UserError(f"{options.input} is no file; name another one")
        json.dumps(options.count)
        return FAULTS[kind](options)

    return run_cli(functools.partial(run), argv[1:], f"planted {kind}")


if __name__ == "__main__":
    sys.exit(main())
