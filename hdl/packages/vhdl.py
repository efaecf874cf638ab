"""A core in a VHDL design: a package with its component."""

from .core import Core


__all__ = ["vhdl_files"]


def vhdl_files(core: Core) -> dict[str, str]:
    """``NAME_pkg.vhd``: a package with the component, for a design in VHDL whose simulator or synthesis takes the Verilog as well.

    Fields of a payload are subtypes of ``natural``: ``i_payload(i_payload_left)`` is the left pixel.
    """
    def shape(width: int) -> str:
        return "std_logic" if width == 1 else f"std_logic_vector({width - 1} downto 0)"

    longest = max(map(len, core.ports))
    ports = [f"      {name:{longest}} : {'in ' if direction == 'input' else 'out'} {shape(width)}"
             for name, (direction, width) in core.ports.items()]
    fields = [f"  subtype {port}_{field} is natural range {high} downto {low};"
              for port, layout in core.payloads.items() for field, (low, high) in layout.items()]
    lines = [
        f"-- {core.description}. The component of the module in {', '.join(core.verilog)}:",
        f"--   use work.{core.name}_pkg.all;",
        "",
        "library ieee;",
        "use ieee.std_logic_1164.all;",
        "",
        f"package {core.name}_pkg is",
        f"  component {core.name} is",
        "    port (",
        ";\n".join(ports),
        "    );",
        "  end component;",
        *(["", "  -- Fields of payloads: port(port_field) is a field."] if fields else []),
        *fields,
        "end package;",
    ]
    return {f"{core.name}_pkg.vhd": "\n".join(lines) + "\n"}
