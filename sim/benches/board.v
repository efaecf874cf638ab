// The board around the chip, as far as a bench needs it: pull-ups on the I2C lines, and another device that can pull each of them low.
// Lines: decoder SCL, SDA; transmitter SCL, SDA.
module board (
  input clk50, input reset_n, input [3:0] buttons_n, input switch, output [7:0] leds_n,
  input left_clk, input [7:0] left_data, input right_clk, input [7:0] right_data,
  output decoder_reset_n, output decoder_powerdown_n, input [3:0] lines_low, output [3:0] lines,
  output dvi_clk, output dvi_clk_n, output [7:0] red, output [7:0] green, output [7:0] blue, output de, output hsync, output vsync,
  output isel, output power_up, output dken, output [2:0] ctl, input rx, output tx);
  wire [3:0] bus;
  pullup up0 (bus[0]);
  pullup up1 (bus[1]);
  pullup up2 (bus[2]);
  pullup up3 (bus[3]);
  assign bus[0] = lines_low[0] ? 1'b0 : 1'bz;
  assign bus[1] = lines_low[1] ? 1'b0 : 1'bz;
  assign bus[2] = lines_low[2] ? 1'b0 : 1'bz;
  assign bus[3] = lines_low[3] ? 1'b0 : 1'bz;
  assign lines = bus;

  stereo chip (
    .clk50_0__io(clk50), .rst_0__io(reset_n), .switch_0__io(switch),
    .button_0__io(buttons_n[0]), .button_1__io(buttons_n[1]), .button_2__io(buttons_n[2]), .button_3__io(buttons_n[3]),
    .led_0__io(leds_n[0]), .led_1__io(leds_n[1]), .led_2__io(leds_n[2]), .led_3__io(leds_n[3]),
    .led_4__io(leds_n[4]), .led_5__io(leds_n[5]), .led_6__io(leds_n[6]), .led_7__io(leds_n[7]),
    .camera_0__clk__io(left_clk), .camera_0__data__io(left_data), .camera_1__clk__io(right_clk), .camera_1__data__io(right_data),
    .decoder_0__reset_n__io(decoder_reset_n), .decoder_0__powerdown_n__io(decoder_powerdown_n),
    .decoder_0__scl__io(bus[0]), .decoder_0__sda__io(bus[1]), .dvi_0__scl__io(bus[2]), .dvi_0__sda__io(bus[3]),
    .dvi_0__clk__io(dvi_clk), .dvi_0__clk_n__io(dvi_clk_n), .dvi_0__red__io(red), .dvi_0__green__io(green), .dvi_0__blue__io(blue),
    .dvi_0__de__io(de), .dvi_0__hsync__io(hsync), .dvi_0__vsync__io(vsync),
    .dvi_0__isel__io(isel), .dvi_0__power_up__io(power_up), .dvi_0__dken__io(dken), .dvi_0__ctl__io(ctl),
    .uart_0__rx__io(rx), .uart_0__tx__io(tx),
    .ddr2_0__cke__io(), .ddr2_0__cs_n__io(), .ddr2_0__ras_n__io(), .ddr2_0__cas_n__io(), .ddr2_0__we_n__io(), .ddr2_0__odt__io(),
    .ddr2_0__addr__io(), .ddr2_0__ba__io(), .ddr2_0__dm__io(), .ddr2_0__clk__io(), .ddr2_0__clk_n__io(), .ddr2_0__dq__io(),
    .ddr2_0__dqs__io());
endmodule
