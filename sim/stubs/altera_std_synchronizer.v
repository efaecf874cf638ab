// Stand-ins for Altera's synchronisers, for simulators.
module altera_std_synchronizer (clk, reset_n, din, dout);
  parameter depth = 3;
  input clk;
  input reset_n;
  input din;
  output dout;

  reg [depth-1:0] stages;
  initial stages = {depth{1'b0}};
  always @(posedge clk or negedge reset_n)
    if (!reset_n) stages <= {depth{1'b0}};
    else stages <= {stages[depth-2:0], din};
  assign dout = stages[depth-1];
endmodule

module altera_std_synchronizer_bundle (clk, reset_n, din, dout);
  parameter depth = 3;
  parameter width = 1;
  input clk;
  input reset_n;
  input [width-1:0] din;
  output [width-1:0] dout;

  genvar bit_number;
  generate
    for (bit_number = 0; bit_number < width; bit_number = bit_number + 1) begin : bits
      altera_std_synchronizer #(.depth(depth)) one (.clk(clk), .reset_n(reset_n), .din(din[bit_number]), .dout(dout[bit_number]));
    end
  endgenerate
endmodule
