// Stand-in for Altera's PLL, for simulators: its clock is the one that comes in, whatever the ratio.
module altpll (inclk, areset, clk, locked);
  parameter bandwidth_type = "AUTO";
  parameter clk0_divide_by = 1;
  parameter clk0_duty_cycle = 50;
  parameter clk0_multiply_by = 1;
  parameter clk0_phase_shift = "0";
  parameter compensate_clock = "CLK0";
  parameter inclk0_input_frequency = 0;
  parameter intended_device_family = "";
  parameter lpm_type = "altpll";
  parameter operation_mode = "NORMAL";
  parameter pll_type = "AUTO";
  parameter port_areset = "PORT_UNUSED";
  parameter port_clk0 = "PORT_UNUSED";
  parameter port_inclk0 = "PORT_UNUSED";
  parameter port_locked = "PORT_UNUSED";
  parameter width_clock = 5;
  input [1:0] inclk;
  input areset;
  output [width_clock-1:0] clk;
  output locked;

  assign clk = {{(width_clock - 1){1'b0}}, inclk[0]};
  assign locked = ~areset;
endmodule
