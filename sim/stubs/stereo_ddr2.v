// Stand-in for the DDR2 controller that Quartus generates for this board, for simulators: the ports alone. The local interface runs on
// the reference clock; what it answers, a bench sets.
module stereo_ddr2 (
  local_address, local_write_req, local_read_req, local_burstbegin, local_wdata, local_be, local_size,
  global_reset_n, pll_ref_clk, soft_reset_n,
  local_ready, local_rdata, local_rdata_valid, local_refresh_ack, local_wdata_req, local_init_done,
  reset_request_n, reset_phy_clk_n, phy_clk, aux_full_rate_clk, aux_half_rate_clk,
  mem_odt, mem_cs_n, mem_cke, mem_addr, mem_ba, mem_ras_n, mem_cas_n, mem_we_n, mem_dm, mem_clk, mem_clk_n, mem_dq, mem_dqs);
  input [22:0] local_address;
  input local_write_req;
  input local_read_req;
  input local_burstbegin;
  input [127:0] local_wdata;
  input [15:0] local_be;
  input [0:0] local_size;
  input global_reset_n;
  input pll_ref_clk;
  input soft_reset_n;
  output reg local_ready = 1'b0;
  output reg [127:0] local_rdata = 128'b0;
  output reg local_rdata_valid = 1'b0;
  output local_refresh_ack;
  output local_wdata_req;
  output reg local_init_done = 1'b0;
  output reset_request_n;
  output reset_phy_clk_n;
  output phy_clk;
  output aux_full_rate_clk;
  output aux_half_rate_clk;
  output [0:0] mem_odt;
  output [0:0] mem_cs_n;
  output [0:0] mem_cke;
  output [12:0] mem_addr;
  output [1:0] mem_ba;
  output mem_ras_n;
  output mem_cas_n;
  output mem_we_n;
  output [3:0] mem_dm;
  inout [0:0] mem_clk;
  inout [0:0] mem_clk_n;
  inout [31:0] mem_dq;
  inout [3:0] mem_dqs;

  assign phy_clk = pll_ref_clk;
  assign reset_phy_clk_n = global_reset_n & soft_reset_n;
  assign reset_request_n = reset_phy_clk_n;
  assign aux_full_rate_clk = pll_ref_clk;
  assign aux_half_rate_clk = pll_ref_clk;
  assign local_refresh_ack = 1'b0;
  assign local_wdata_req = 1'b0;
  assign mem_odt = 1'b0;
  assign mem_cs_n = 1'b1;
  assign mem_cke = 1'b0;
  assign mem_addr = 13'b0;
  assign mem_ba = 2'b0;
  assign mem_ras_n = 1'b1;
  assign mem_cas_n = 1'b1;
  assign mem_we_n = 1'b1;
  assign mem_dm = 4'b0;
  assign mem_clk = 1'b0;
  assign mem_clk_n = 1'b1;
  assign mem_dq = 32'bz;
  assign mem_dqs = 4'bz;
endmodule
