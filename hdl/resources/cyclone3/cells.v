// What a Cyclone III is counted in. A black box each: only their number matters.

// A logic element in arithmetic mode: S = A ^ B ^ CI, CO = majority of A, B, CI; with INVERT, B is taken inverted.
(* blackbox *) module C3_ADD (input A, input B, input CI, output S, output CO);
  parameter INVERT = 0;
endmodule

// Any function of up to four inputs.
(* blackbox *) module C3_LUT (input A, input B, input C, input D, output O);
  parameter LUT = 0;
  parameter WIDTH = 4;
endmodule

(* blackbox *) module C3_FF (input D, input CLK, input EN, input CLR, output Q);
endmodule

// A memory block with one port to write and one to read.
(* blackbox *) module C3_M9K (input CLK, input RCLK, input [12:0] WA, input [35:0] WD, input WE, input [12:0] RA, input RE, output [35:0] Q);
endmodule

(* blackbox *) module C3_MULT18 (input [17:0] A, input [17:0] B, output [35:0] Y);
endmodule

(* blackbox *) module C3_MULT9 (input [8:0] A, input [8:0] B, output [17:0] Y);
endmodule
