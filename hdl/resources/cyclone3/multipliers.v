module \$__C3_MULT18 (input [17:0] A, input [17:0] B, output [35:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 18;
  parameter B_WIDTH = 18;
  parameter Y_WIDTH = 36;
  C3_MULT18 #(.A_SIGNED(A_SIGNED), .B_SIGNED(B_SIGNED)) _TECHMAP_REPLACE_ (.A(A), .B(B), .Y(Y));
endmodule

module \$__C3_MULT9 (input [8:0] A, input [8:0] B, output [17:0] Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 9;
  parameter B_WIDTH = 9;
  parameter Y_WIDTH = 18;
  C3_MULT9 #(.A_SIGNED(A_SIGNED), .B_SIGNED(B_SIGNED)) _TECHMAP_REPLACE_ (.A(A), .B(B), .Y(Y));
endmodule
