// Clock enable and synchronous clear are signals of the whole block of 16 elements: they cost no table.
module \$_DFF_P_ (input D, C, output Q);
  C3_FF _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(1'b1), .CLR(1'b0), .Q(Q));
endmodule

module \$_DFFE_PP_ (input D, C, E, output Q);
  C3_FF _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(E), .CLR(1'b0), .Q(Q));
endmodule

module \$_SDFF_PP0_ (input D, C, R, output Q);
  C3_FF _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(1'b1), .CLR(R), .Q(Q));
endmodule

module \$_SDFFCE_PP0P_ (input D, C, R, E, output Q);
  C3_FF _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(E), .CLR(R), .Q(Q));
endmodule

module \$_DFF_PP0_ (input D, C, R, output Q);
  C3_FF #(.ASYNC(1)) _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(1'b1), .CLR(R), .Q(Q));
endmodule

module \$_DFFE_PP0P_ (input D, C, R, E, output Q);
  C3_FF #(.ASYNC(1)) _TECHMAP_REPLACE_ (.D(D), .CLK(C), .EN(E), .CLR(R), .Q(Q));
endmodule
