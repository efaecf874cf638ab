"""Operands of RTLIL text that are as wide as their operation, so that no width in the Verilog is implied."""

import re


__all__ = ["pad_operands"]


# Kinds of cells whose operands Verilog extends to the widest of both and the result, and to the wider of both.
_RESULT = ("add", "sub", "and", "or", "xor", "xnor", "not", "neg")
_COMPARISON = ("lt", "le", "eq", "ne", "ge", "gt")
_CELL = re.compile(rf"(?m)^  cell \$({'|'.join(_RESULT + _COMPARISON)}) .*\n((?:    .*\n)*)  end\n")
_SHIFT = re.compile(r"(?m)^  cell \$(shr|shift|shiftx) (\S+)\n((?:    .*\n)*)  end\n")
_RESULT_PIN = re.compile(r"    connect \\Y (.*)\n")
_PARAMETER = re.compile(r"    parameter \\(\w+) (\d+)\n")
_OPERAND = re.compile(r"    connect \\([AB]) (.*)\n")
_FIRST = re.compile(r"(?:\{ )?(?:\d+'([01])[01]*|(\S+) \[(\d+)(?::\d+)?\])(?: |$)")


def _highest_bit(signal: str) -> str:
    """The most significant bit of a signal, with which a concatenation begins; empty if ``signal`` does not tell its width."""
    found = _FIRST.match(signal)
    if found is None:
        return ""
    return f"1'{found[1]}" if found[1] else f"{found[2]} [{found[3]}]"


def _shifted(found: re.Match[str]) -> str:
    """A shift to the right whose result is as wide as its operand; of the result some low bits are used."""
    kind, cell, body = found.groups()
    given = {name: int(value) for name, value in _PARAMETER.findall(body)}
    width, used = given["A_WIDTH"], given["Y_WIDTH"]
    result = _RESULT_PIN.search(body)
    if used >= width or result is None:
        return found[0]
    net = f"$shifted{cell}"
    body = _RESULT_PIN.sub(lambda _: f"    connect \\Y {net}\n", body).replace(f"\\Y_WIDTH {used}\n", f"\\Y_WIDTH {width}\n")
    return (f"  wire width {width} {net}\n\n  cell ${kind} {cell}\n{body}  end\n\n"
            f"  connect {result[1]} {net} [{used - 1}:0]\n")


def pad_operands(text: str) -> str:
    """RTLIL whose additions, subtractions, bit operations and comparisons have operands of one width, whose shifts to the right have
    a result as wide as what they shift.

    Verilog extends the narrower operand of an expression by rules that linters distrust. Here the extension is written out, by zeros or
    by copies of the sign, and bit for bit the same is computed. Operands whose result is no wider than themselves need no sign: they are
    unsigned afterwards. Products stay as they are: their operands tell the size of the multiplier.

    Examples
    --------
    >>> cell = '''  cell $add $2
    ...     parameter \\\\A_SIGNED 0
    ...     parameter \\\\B_SIGNED 0
    ...     parameter \\\\A_WIDTH 3
    ...     parameter \\\\B_WIDTH 1
    ...     parameter \\\\Y_WIDTH 4
    ...     connect \\\\A \\\\a [2:0]
    ...     connect \\\\B 1'1
    ...     connect \\\\Y $1
    ...   end
    ... '''
    >>> print("\\n".join(line for line in pad_operands(cell).splitlines() if "WIDTH" in line or "connect" in line))
        parameter \\A_WIDTH 4
        parameter \\B_WIDTH 4
        parameter \\Y_WIDTH 4
        connect \\A { 1'0 \\a [2:0] }
        connect \\B { 3'000 1'1 }
        connect \\Y $1
    """
    def padded(found: re.Match[str]) -> str:
        kind, body = found[1], found[2]
        given = {name: int(value) for name, value in _PARAMETER.findall(body)}
        sides = [side for side in "AB" if f"{side}_WIDTH" in given]
        widths = [given[f"{side}_WIDTH"] for side in sides]
        of_result = kind in _RESULT
        width = max(*widths, given["Y_WIDTH"]) if of_result else max(widths)
        signed = all(given[f"{side}_SIGNED"] for side in sides)
        drop_sign = signed and of_result and width == given["Y_WIDTH"]
        if not drop_sign and min(widths) == width:
            return found[0]

        operands: dict[str, str] = {}
        for side, signal in _OPERAND.findall(body):
            missing = width - given[f"{side}_WIDTH"]
            sign = _highest_bit(signal) if signed else ""
            if missing and signed and not sign:
                return found[0]
            extension = " ".join([sign] * missing) if signed else f"{missing}'{'0' * missing}"
            operands[side] = f"{{ {extension} {signal.removeprefix('{ ').removesuffix(' }')} }}" if missing else signal
        body = _OPERAND.sub(lambda match: f"    connect \\{match[1]} {operands[match[1]]}\n", body)
        changed = {f"{side}_WIDTH": width for side in sides} | ({f"{side}_SIGNED": 0 for side in sides} if drop_sign else {})
        body = _PARAMETER.sub(lambda match: f"    parameter \\{match[1]} {changed.get(match[1], match[2])}\n", body)
        return found[0].replace(found[2], body, 1)

    return _SHIFT.sub(_shifted, _CELL.sub(padded, text))
