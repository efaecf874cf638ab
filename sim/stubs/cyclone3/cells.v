// The elements that hdl.resources maps to, for simulation. A mode that the mapping has no use for ends the simulation. No value is unknown:
// a register starts as 0, a memory block without content as noise. Unknown bits would spread, because what is known of a signal is lost
// where its logic is divided into tables.
/* verilator lint_off BLKSEQ */
/* verilator lint_off DECLFILENAME */
/* verilator lint_off MULTITOP */
/* verilator lint_off WIDTH */
/* verilator lint_off UNUSEDSIGNAL */

module C3_ADD (input A, input B, input CI, output S, output CO);
  parameter INVERT = 0;
  wire b = INVERT != 0 ? ~B : B;
  assign S = A ^ b ^ CI;
  assign CO = (A & b) | (A & CI) | (b & CI);
endmodule

module C3_LUT (input A, input B, input C, input D, output O);
  parameter LUT = 0;
  parameter WIDTH = 4;
  // A tree, so that an unknown input matters only where both of its values do.
  wire [15:0] entries = LUT;
  wire [7:0] of_d = D ? entries[15:8] : entries[7:0];
  wire [3:0] of_c = C ? of_d[7:4] : of_d[3:0];
  wire [1:0] of_b = B ? of_c[3:2] : of_c[1:0];
  assign O = A ? of_b[1] : of_b[0];
  initial
    if (WIDTH < 1 || WIDTH > 4) begin
      $display("C3_LUT: %0d inputs", WIDTH);
      $finish;
    end
endmodule

module C3_FF (input D, input CLK, input EN, input CLR, output reg Q);
  parameter ASYNC = 0;
  initial Q = 1'b0;
  generate
    if (ASYNC != 0) begin : asynchronous
      always @(posedge CLK or posedge CLR)
        if (CLR)
          Q <= 1'b0;
        else
          Q <= EN ? D : Q;
    end else begin : synchronous
      always @(posedge CLK)
        Q <= EN ? (CLR ? 1'b0 : D) : Q;
    end
  endgenerate
endmodule

// Both ports are of one width and have one clock: with two nothing is promised of a read that meets a write. A word of less than nine
// bits leaves each ninth bit out.
module C3_M9K (input CLK, input RCLK, input [12:0] WA, input [35:0] WD, input WE, input [12:0] RA, input RE, output reg [35:0] Q);
  parameter W_WIDTH = 36;
  parameter R_WIDTH = 36;
  parameter FILLED = 0;
  parameter [9215:0] INIT = 9216'd0;
  localparam SHIFT = W_WIDTH == 36 ? 5 : W_WIDTH == 18 ? 4 : W_WIDTH == 9 ? 3 : W_WIDTH == 4 ? 2 : W_WIDTH == 2 ? 1 : 0;
  localparam ROWS = 8192 >> SHIFT;
  reg [W_WIDTH-1:0] rows [0:ROWS-1];
  wire [12:0] write_row = WA >> SHIFT;
  wire [12:0] read_row = RA >> SHIFT;
  integer row, seed;
  reg [63:0] noise;
  initial begin
    seed = 1;
    Q = 36'd0;
    for (row = 0; row < ROWS; row = row + 1) begin
      noise = {$random(seed), $random(seed)};
      rows[row] = FILLED != 0 ? INIT[(W_WIDTH < 9 ? 9 * (row * W_WIDTH / 8) + row * W_WIDTH % 8 : row * W_WIDTH) +: W_WIDTH] : noise;
    end
    if (W_WIDTH != R_WIDTH) begin
      $display("C3_M9K: ports of %0d and %0d bits, which this model does not have", W_WIDTH, R_WIDTH);
      $finish;
    end
  end
  always @(posedge CLK) begin
    if (RCLK !== 1'b1) begin
      $display("C3_M9K: two clocks, which this model does not have");
      $finish;
    end
    if (WE)
      rows[write_row] <= WD[W_WIDTH-1:0];
    // The old word, where it is written in the same clock.
    if (RE)
      Q <= {{36 - W_WIDTH{1'b0}}, rows[read_row]};
  end
endmodule

module C3_MULT18 (input [17:0] A, input [17:0] B, output [35:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  wire signed [18:0] a = {A_SIGNED != 0 & A[17], A};
  wire signed [18:0] b = {B_SIGNED != 0 & B[17], B};
  assign Y = a * b;
endmodule

module C3_MULT9 (input [8:0] A, input [8:0] B, output [17:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  wire signed [9:0] a = {A_SIGNED != 0 & A[8], A};
  wire signed [9:0] b = {B_SIGNED != 0 & B[8], B};
  assign Y = a * b;
endmodule
