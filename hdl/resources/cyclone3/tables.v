module \$lut (A, Y);
  parameter WIDTH = 0;
  parameter LUT = 0;
  (* force_downto *) input [WIDTH-1:0] A;
  output Y;
  wire [3:0] inputs = A;
  C3_LUT #(.LUT(LUT), .WIDTH(WIDTH)) _TECHMAP_REPLACE_ (.A(inputs[0]), .B(inputs[1]), .C(inputs[2]), .D(inputs[3]), .O(Y));
endmodule
