// The video system between two cameras, a memory and a monitor, for whole pictures of full size: a language outside would cost more
// than the system itself. It drives the clocks and looks at the end (`done`) only. Verilog-2001 without delays, for Verilator without
// --timing and for Icarus. What the models of Python check of the memory's protocol is not checked here.
//
// Plusargs: +left= +right=    bytes of a frame after BT.656, hexadecimal, one a line; sent over and over
//           +right_at=        byte of its frame that the right camera begins with; the left one begins with byte 0
//           +output=          file for the monitor's pins, one word a pixel clock: red, green, blue and their neighbours of
//                             sim.models.monitor.PINS, hexadecimal, of the first frame that shows a picture
//           +report=          file for lines of `key value`; times are in clocks of `clk` since the reset
//
// Host and I2C chips are not there: the lines are idle, and nobody answers.

/* verilator lint_off BLKSEQ */
module system_bench #(
  parameter FRAME_BYTES = 16,   // of a camera
  parameter WORDS = 16,         // of the memory
  parameter SHOWN = 8,          // first word of the pictures for the monitor; those of the cameras are below it
  parameter PICTURE_WORDS = 4,  // of the two planes of a picture for the monitor
  parameter LATENCY = 20,       // clocks from a read to its word
  parameter REFRESH = 585,      // clocks from a refresh to the next
  parameter REFRESH_CLOCKS = 24 // clocks of a refresh
) (
  input      clk,
  input      rst,
  input      display_clk,
  input      display_rst,
  input      left_camera_clk,
  input      left_camera_rst,
  input      right_camera_clk,
  input      right_camera_rst,
  output reg done
);
  localparam NAME = 8 * 1024;   // bits of a file name
  reg [NAME-1:0] left_name, right_name, output_name, report_name;
  integer report_file, output_file, right_at;

  // Cameras: bytes change as their clock falls.

  reg [7:0] left_bytes [0:FRAME_BYTES-1];
  reg [7:0] right_bytes [0:FRAME_BYTES-1];
  integer   left_position, right_position;
  reg [7:0] left_data, right_data;

  always @(negedge left_camera_clk) begin
    left_data <= left_bytes[left_position];
    left_position <= left_position == FRAME_BYTES - 1 ? 0 : left_position + 1;
  end
  always @(negedge right_camera_clk) begin
    right_data <= right_bytes[right_position];
    right_position <= right_position == FRAME_BYTES - 1 ? 0 : right_position + 1;
  end

  // Memory: `ready` is low in refreshes and at random, one clock in four.

  wire [22:0]  address;
  wire [31:0]  wide = {9'd0, address};   // as wide as parameters are
  wire         write_req, read_req;
  wire [127:0] wdata;
  wire [15:0]  be;
  reg  [127:0] words [0:WORDS-1];
  wire [$clog2(WORDS)-1:0] word = address[$clog2(WORDS)-1:0];
  reg  [127:0] on_their_way [0:LATENCY-1];
  reg  [LATENCY-1:0] valid;
  reg  [127:0] rdata;
  reg          rdata_valid, ready;
  reg  [15:0]  noise;
  reg  [127:0] mask;
  integer      refresh, n;

  always @(posedge clk) begin
    noise <= {noise[14:0], noise[15] ^ noise[13] ^ noise[12] ^ noise[10]};
    refresh <= refresh == REFRESH - 1 ? 0 : refresh + 1;
    ready <= !rst && refresh >= REFRESH_CLOCKS && noise[1:0] != 0;
    for (n = LATENCY - 1; n > 0; n = n - 1) on_their_way[n] <= on_their_way[n - 1];
    on_their_way[0] <= words[word];
    valid <= {valid[LATENCY-2:0], ready && read_req};
    if (ready && (read_req || write_req) && wide >= WORDS) begin
      $display("address %0d is behind the memory's %0d words", address, WORDS);
      $fatal;
    end
    rdata <= on_their_way[LATENCY-1];
    rdata_valid <= valid[LATENCY-1];
    if (ready && write_req) begin
      for (n = 0; n < 16; n = n + 1) mask[8 * n +: 8] = {8{be[n]}};
      words[word] <= words[word] & ~mask | wdata & mask;
    end
  end

  // What is counted: the first pair alone.

  integer clocks, words_read, words_written, shown_words, started, finished;
  reg     shown;    // the picture is fetched for the monitor

  always @(posedge clk) begin
    if (rst) clocks <= 0;
    else begin
      clocks <= clocks + 1;
      if (ready && read_req) begin
        words_read <= words_read + 1;
        if (started < 0 && wide < SHOWN) started <= clocks;
        if (wide >= SHOWN) shown <= 1;
      end
      if (ready && write_req) begin
        words_written <= words_written + 1;
        if (wide >= SHOWN) begin
          shown_words <= shown_words + 1;
          if (shown_words == PICTURE_WORDS - 1) finished <= clocks;
        end
      end
    end
  end

  // Monitor: the first frame for which a picture was fetched, from one fall of `vsync` to the next.

  wire [7:0] red, green, blue;
  wire       de, hsync, vsync;
  reg        vsync_before;
  integer    falls;

  always @(posedge display_clk) begin
    vsync_before <= vsync;
    if (shown && vsync_before && !vsync) begin
      falls = falls + 1;
      if (falls == 2) begin
        $fwrite(report_file, "clocks %0d\nstarted %0d\nfinished %0d\nwords_read %0d\nwords_written %0d\nleds %0d\n", clocks, started,
                finished, words_read, words_written, leds);
        $fclose(report_file);
        $fclose(output_file);
        done <= 1;
      end
    end
    if (falls == 1) $fwrite(output_file, "%h\n", {vsync, hsync, de, red, green, blue});
  end

  wire [7:0] leds;
  wire       burstbegin, size, uart_tx, decoder_scl_low, decoder_sda_low, dvi_scl_low, dvi_sda_low, decoder_reset_n, decoder_powerdown_n;
  stereo_system system (
    .clk(clk), .rst(rst), .display_clk(display_clk), .display_rst(display_rst),
    .left_camera_clk(left_camera_clk), .left_camera_rst(left_camera_rst), .left_data(left_data),
    .right_camera_clk(right_camera_clk), .right_camera_rst(right_camera_rst), .right_data(right_data),
    .memory_address(address), .memory_write_req(write_req), .memory_read_req(read_req), .memory_burstbegin(burstbegin),
    .memory_wdata(wdata), .memory_be(be), .memory_size(size), .memory_ready(ready), .memory_rdata(rdata),
    .memory_rdata_valid(rdata_valid), .memory_init_done(!rst),
    .red(red), .green(green), .blue(blue), .de(de), .hsync(hsync), .vsync(vsync),
    .decoder_scl_low(decoder_scl_low), .decoder_sda_low(decoder_sda_low), .decoder_scl(!decoder_scl_low), .decoder_sda(!decoder_sda_low),
    .dvi_scl_low(dvi_scl_low), .dvi_sda_low(dvi_sda_low), .dvi_scl(!dvi_scl_low), .dvi_sda(!dvi_sda_low),
    .decoder_reset_n(decoder_reset_n), .decoder_powerdown_n(decoder_powerdown_n),
    .uart_rx(1'b1), .uart_tx(uart_tx), .leds(leds), .buttons(4'b0));

  initial begin
    done = 0;
    noise = 16'hACE1;
    refresh = 0;
    ready = 0;
    valid = 0;
    rdata_valid = 0;
    vsync_before = 0;
    shown = 0;
    falls = 0;
    words_read = 0;
    words_written = 0;
    shown_words = 0;
    started = -1;
    finished = -1;
    left_position = 0;
    right_at = 0;
    if (!$value$plusargs("left=%s", left_name) || !$value$plusargs("right=%s", right_name) || !$value$plusargs("output=%s", output_name)
        || !$value$plusargs("report=%s", report_name)) begin
      $display("a file is not named");
      $finish;
    end
    if (!$value$plusargs("right_at=%d", right_at)) right_at = 0;
    right_position = right_at;
    $readmemh(left_name, left_bytes);
    $readmemh(right_name, right_bytes);
    output_file = $fopen(output_name, "w");
    report_file = $fopen(report_name, "w");
  end
endmodule
