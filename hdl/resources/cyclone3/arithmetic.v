// Additions, subtractions and comparisons of more than two bits on carry chains. The first element of a chain needs no carry-in that
// is constant. Shorter ones are left to the tables.

(* techmap_celltype = "$add $sub" *)
module _90_c3_add (A, B, Y);
  parameter _TECHMAP_CELLTYPE_ = "";
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) input [B_WIDTH-1:0] B;
  (* force_downto *) output [Y_WIDTH-1:0] Y;

  wire _TECHMAP_FAIL_ = Y_WIDTH <= 2;
  localparam SUBTRACT = _TECHMAP_CELLTYPE_ == "$sub";
  (* force_downto *) wire [Y_WIDTH-1:0] a, b;
  \$pos #(.A_SIGNED(A_SIGNED && B_SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) widen_a (.A(A), .Y(a));
  \$pos #(.A_SIGNED(A_SIGNED && B_SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH)) widen_b (.A(B), .Y(b));
  wire [Y_WIDTH:0] carry;
  assign carry[0] = SUBTRACT;
  genvar i;
  generate for (i = 0; i < Y_WIDTH; i = i + 1) begin : bits
    C3_ADD #(.INVERT(SUBTRACT)) element (.A(a[i]), .B(b[i]), .CI(carry[i]), .S(Y[i]), .CO(carry[i+1]));
  end endgenerate
endmodule

(* techmap_celltype = "$neg" *)
module _90_c3_negate (A, Y);
  parameter A_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter Y_WIDTH = 1;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) output [Y_WIDTH-1:0] Y;
  \$sub #(.A_SIGNED(A_SIGNED), .B_SIGNED(A_SIGNED), .A_WIDTH(1), .B_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) _TECHMAP_REPLACE_
    (.A(1'b0), .B(A), .Y(Y));
endmodule

// A > B where A - B - 1 does not borrow; the other three are this one with its operands exchanged, its result inverted, or both.
// The last bit is a table: an element in normal mode takes the carry as one of its four inputs.
(* techmap_celltype = "$lt $le $gt $ge" *)
module _90_c3_compare (A, B, Y);
  parameter _TECHMAP_CELLTYPE_ = "";
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CONSTMSK_A_ = 0;
  parameter _TECHMAP_CONSTMSK_B_ = 0;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) input [B_WIDTH-1:0] B;
  (* force_downto *) output [Y_WIDTH-1:0] Y;

  localparam SIGNED = A_SIGNED && B_SIGNED;
  localparam WIDTH = A_WIDTH > B_WIDTH ? A_WIDTH : B_WIDTH;
  // With a constant, tables do better.
  wire _TECHMAP_FAIL_ = WIDTH <= 2 || &_TECHMAP_CONSTMSK_A_ || &_TECHMAP_CONSTMSK_B_;
  localparam EXCHANGE = _TECHMAP_CELLTYPE_ == "$lt" || _TECHMAP_CELLTYPE_ == "$ge";
  localparam INVERT = _TECHMAP_CELLTYPE_ == "$le" || _TECHMAP_CELLTYPE_ == "$ge";
  (* force_downto *) wire [WIDTH-1:0] a, b;
  \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(WIDTH)) widen_a (.A(A), .Y(a));
  \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(WIDTH)) widen_b (.A(B), .Y(b));
  wire [WIDTH-1:0] more, less, carry;
  assign more = EXCHANGE ? b : a;
  assign less = EXCHANGE ? a : b;
  assign carry[0] = 1'b0;
  genvar i;
  generate for (i = 0; i < WIDTH - 1; i = i + 1) begin : bits
    C3_ADD #(.INVERT(1)) element (.A(more[i]), .B(less[i]), .CI(carry[i]), .CO(carry[i+1]));
  end endgenerate
  // Signed numbers compare as unsigned ones do once their sign bits are inverted.
  wire p = more[WIDTH-1] ^ SIGNED, q = less[WIDTH-1] ^ SIGNED, c = carry[WIDTH-1];
  assign Y = INVERT ^ ((p & ~q) | (p & c) | (~q & c));
endmodule
