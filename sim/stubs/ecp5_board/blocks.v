// Stand-ins for Lattice's blocks, for simulators: with the ports and parameters that the boards with an ECP5 connect, and no others.
module IB (input I, output O);
  assign O = I;
endmodule

module OBZ (input I, input T, output O);
  assign O = T ? 1'bz : I;
endmodule

module BB (input I, input T, output O, inout B);
  assign B = T ? 1'bz : I;
  assign O = B;
endmodule

module FD1S3AX (input D, input CK, output reg Q);
  initial Q = 1'b0;
  always @(posedge CK) Q <= D;
endmodule

module OFS1P3DX (input CD, input D, input SP, input SCLK, output reg Q);
  initial Q = 1'b0;
  always @(posedge SCLK) if (CD) Q <= 1'b0; else if (SP) Q <= D;
endmodule

// D0 leaves in the first half of a clock.
module ODDRX1F (input SCLK, input RST, input D0, input D1, output Q);
  reg first;
  reg second;
  initial first = 1'b0;
  initial second = 1'b0;
  always @(posedge SCLK) begin
    first <= D0 & ~RST;
    second <= D1 & ~RST;
  end
  assign Q = SCLK ? first : second;
endmodule

// The first output is the clock that is given, whatever the ratio; the second one has the right ratio to it.
module EHXPLLL (
  input CLKI, input CLKFB, input PHASESEL1, input PHASESEL0, input PHASEDIR, input PHASESTEP, input PHASELOADREG, input STDBY,
  input PLLWAKESYNC, input RST, input ENCLKOP, output CLKOP, output reg CLKOS, output reg LOCK);
  parameter CLKI_DIV = 1;
  parameter CLKFB_DIV = 1;
  parameter CLKOP_DIV = 8;
  parameter CLKOP_CPHASE = 0;
  parameter CLKOP_FPHASE = 0;
  parameter CLKOP_ENABLE = "ENABLED";
  parameter CLKOS_DIV = 8;
  parameter CLKOS_CPHASE = 0;
  parameter CLKOS_FPHASE = 0;
  parameter CLKOS_ENABLE = "DISABLED";
  parameter FEEDBK_PATH = "CLKOP";
  parameter PLLRST_ENA = "DISABLED";
  parameter INTFB_WAKE = "DISABLED";
  parameter STDBY_ENABLE = "DISABLED";
  parameter DPHASE_SOURCE = "DISABLED";
  parameter OUTDIVIDER_MUXA = "DIVA";
  parameter OUTDIVIDER_MUXB = "DIVB";
  parameter OUTDIVIDER_MUXC = "DIVC";
  parameter OUTDIVIDER_MUXD = "DIVD";

  assign CLKOP = CLKI;
  integer count;
  initial count = 0;
  initial CLKOS = 1'b0;
  initial LOCK = 1'b0;
  always @(posedge CLKI) begin
    LOCK <= 1'b1;
    count <= count == CLKOS_DIV / CLKOP_DIV - 1 ? 0 : count + 1;
    CLKOS <= count == 0;
  end
endmodule
