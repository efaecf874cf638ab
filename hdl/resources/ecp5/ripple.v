// Carries of a few bits, one after the other: ABC finds the tables for them.
(* techmap_celltype = "$lcu" *)
module ripple_carry (P, G, CI, CO);
    parameter WIDTH = 1;
    input  [WIDTH-1:0] P, G;
    input  CI;
    output [WIDTH-1:0] CO;
    wire   [WIDTH:0] carry = {CO, CI};
    assign CO = G | (P & carry[WIDTH-1:0]);
endmodule
