// Stand-ins for Altera's double-data-rate registers, for simulators.
module altddio_out (datain_h, datain_l, outclock, dataout);
  parameter width = 1;
  input [width-1:0] datain_h;
  input [width-1:0] datain_l;
  input outclock;
  output [width-1:0] dataout;

  reg [width-1:0] high;
  reg [width-1:0] low;
  always @(posedge outclock) begin
    high <= datain_h;
    low <= datain_l;
  end
  assign dataout = outclock ? high : low;
endmodule

module altddio_in (datain, inclock, dataout_h, dataout_l);
  parameter width = 1;
  input [width-1:0] datain;
  input inclock;
  output reg [width-1:0] dataout_h;
  output reg [width-1:0] dataout_l;

  reg [width-1:0] low;
  always @(negedge inclock) low <= datain;
  always @(posedge inclock) begin
    dataout_h <= datain;
    dataout_l <= low;
  end
endmodule
