// What a Cyclone III is counted in. A black box each: only their number matters. What a simulator needs beside that are parameters, see
// sim/stubs/cyclone3.

// A logic element in arithmetic mode: S = A ^ B ^ CI, CO = majority of A, B, CI; with INVERT, B is taken inverted.
(* blackbox *) module C3_ADD (input A, input B, input CI, output S, output CO);
  parameter INVERT = 0;
endmodule

// Any function of up to four inputs.
(* blackbox *) module C3_LUT (input A, input B, input C, input D, output O);
  parameter LUT = 0;
  parameter WIDTH = 4;
endmodule

// Starts as 0. The clear needs the enable; with ASYNC it needs neither that nor the clock.
(* blackbox *) module C3_FF (input D, input CLK, input EN, input CLR, output Q);
  parameter ASYNC = 0;
endmodule

// A memory block with one port to write and one to read. Addresses are those of single bits, whatever the width.
// If it is FILLED its first content is INIT, else it has none.
(* blackbox *) module C3_M9K (input CLK, input RCLK, input [12:0] WA, input [35:0] WD, input WE, input [12:0] RA, input RE, output [35:0] Q);
  parameter W_WIDTH = 36;
  parameter R_WIDTH = 36;
  parameter FILLED = 0;
  parameter INIT = 0;
endmodule

(* blackbox *) module C3_MULT18 (input [17:0] A, input [17:0] B, output [35:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
endmodule

(* blackbox *) module C3_MULT9 (input [8:0] A, input [8:0] B, output [17:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
endmodule
