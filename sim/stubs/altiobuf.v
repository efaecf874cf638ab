// Stand-ins for Altera's I/O buffers, for simulators.
module altiobuf_in (datain, dataout);
  parameter enable_bus_hold = "FALSE";
  parameter number_of_channels = 1;
  parameter use_differential_mode = "FALSE";
  input [number_of_channels-1:0] datain;
  output [number_of_channels-1:0] dataout;

  assign dataout = datain;
endmodule

module altiobuf_out (datain, oe, dataout);
  parameter enable_bus_hold = "FALSE";
  parameter number_of_channels = 1;
  parameter use_differential_mode = "FALSE";
  parameter use_oe = "FALSE";
  input [number_of_channels-1:0] datain;
  input [number_of_channels-1:0] oe;
  output [number_of_channels-1:0] dataout;

  genvar channel;
  generate
    for (channel = 0; channel < number_of_channels; channel = channel + 1) begin : channels
      assign dataout[channel] = oe[channel] ? datain[channel] : 1'bz;
    end
  endgenerate
endmodule

module altiobuf_bidir (datain, oe, dataout, dataio);
  parameter enable_bus_hold = "FALSE";
  parameter number_of_channels = 1;
  parameter use_differential_mode = "FALSE";
  input [number_of_channels-1:0] datain;
  input [number_of_channels-1:0] oe;
  output [number_of_channels-1:0] dataout;
  inout [number_of_channels-1:0] dataio;

  assign dataout = dataio;
  genvar channel;
  generate
    for (channel = 0; channel < number_of_channels; channel = channel + 1) begin : channels
      assign dataio[channel] = oe[channel] ? datain[channel] : 1'bz;
    end
  endgenerate
endmodule
