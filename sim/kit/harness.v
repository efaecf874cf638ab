// Bench around a matcher: reads the left and the right text picture, drives the stream of pixel pairs, receives the stream of
// disparities, writes a text picture (six digits a word where two are not enough), and counts clocks. Python drives the clock, `go`, and
// waits for `done`: a call of Python in each clock would be slow. Verilog-2001 without delays, for Icarus and for Verilator without
// --timing.
//
// A file may hold several pictures: they are consecutive frames without a pause between them.
//
// SETTING_PORTS is defined as the connections of the matcher's settings to bits of `settings`, and of its further ports, if it has any.
//
// Plusargs: +left= +right= +plan= +output= +report=  files
//           +seed=                            of the stalls
//           +timeout=                         clocks without a transfer after which the run ends as hung; 200000 by default
//
// The plan has a line for each frame, `apply settings stall_i burst_i stall_o burst_o`:
//   apply             0: the settings in force stay. 1: `settings`, all of them, hexadecimal, are applied before the frame, as early as
//                     the matcher allows: once the first disparity of the frame before has been transferred
//   stall_i, stall_o  probability of a stall, in 1/256, in each clock in which the frame is sent, or received
//   burst_i, burst_o  a stall that has begun lasts for up to so many further clocks
// Between two pulses of `apply_settings` the settings are noise.
//
// The report is lines of `key value`. All times are in clocks; latency counts from the clock in which a pixel pair is accepted to the
// first clock in which its disparity is valid.

/* verilator lint_off BLKSEQ */
module harness #(
  parameter WORD_BITS = 7,       // of an output word without its flags: up to 24
  parameter SETTING_BITS = 27    // of all settings
) (
  input      clk,
  input      rst,
  input      go,
  output reg done
);
  localparam FRAMES = 1024;     // frames that may be inside the matcher at once
  localparam PIXELS = 65536;    // pixels that may be inside the matcher at once
  localparam DRAIN = 64;        // clocks to wait for extra words after the last expected one
  localparam NAME = 8 * 1024;   // bits of a file name

  // Streams

  reg                   i_valid;
  wire                  i_ready;
  reg  [18:0]           i_payload;
  wire                  o_valid;
  reg                   o_ready;
  wire [WORD_BITS+2:0] o_payload;
  reg  [SETTING_BITS-1:0] settings;
  reg                   apply_settings;
  wire                  error;

  matcher dut(
    .clk(clk), .rst(rst), `SETTING_PORTS, .apply_settings(apply_settings), .clear(1'b0), .error(error),
    .i_valid(i_valid), .i_ready(i_ready), .i_payload(i_payload),
    .o_valid(o_valid), .o_ready(o_ready), .o_payload(o_payload));

  // Files and settings

  reg [NAME-1:0] left_name, right_name, plan_name, output_name, report_name;
  integer left_file, right_file, plan_file, output_file, report_file;
  integer seed, timeout;
  reg [SETTING_BITS-1:0] planned;
  integer apply;                // `planned` is to be applied before the next pixel
  integer stall_i, burst_i, wait_i, stall_o, burst_o, wait_o, planned_stall_o, planned_burst_o;
  reg     willing;              // no stall of the output

  // Input side: the picture that is read, and the next pixel

  integer rc, rc_right, left, right, right_width, right_height;
  integer in_width, in_height, in_x, in_y;
  reg     in_open;              // a picture is being read
  reg     in_over;              // there is no further picture
  reg     in_taken;
  reg     bad_files;

  // Output side, and sizes and times from the input side

  integer width_of [0:FRAMES-1];
  integer height_of [0:FRAMES-1];
  integer stall_o_of [0:FRAMES-1];
  integer burst_o_of [0:FRAMES-1];
  reg [31:0] first_taken [0:FRAMES-1];
  reg [31:0] last_taken [0:FRAMES-1];
  reg [31:0] taken_at [0:PIXELS-1];
  reg [31:0] frames_read, frames_begun, frames_taken, frames_seen, frames_given, pixels_taken, pixels_given, read_ring, ring;
  integer out_width, out_height, out_x, out_y;
  reg     new_offer;            // first clock in which the word is valid
  reg     seen;                 // the first word of the frame has been valid
  reg     held;
  reg     first, last, end_;
  reg [23:0] word;
  reg [WORD_BITS+2:0] held_payload;

  // Counters

  reg [31:0] clock, idle, drain, latency, offered_at, first_offered, latency_first, latency_max, first_given, flag_errors, rule_errors;
  reg [31:0] unknown_words, extra_words, random_i, random_o;
  reg     was_reset, running, finish, hang;

  function [31:0] xorshift(input [31:0] x);
    reg [31:0] y;
    begin
      y = x ^ (x << 13);
      y = y ^ (y >> 17);
      xorshift = y ^ (y << 5);
    end
  endfunction

  // Read the header of the next pair of pictures, if there is one. It is read in the clock of the last pixel before it: whether that is
  // the last of all must be known before the next clock.
  task next_picture;
    begin
      rc = $fscanf(left_file, " // %d %d", in_width, in_height);
      rc_right = $fscanf(right_file, " // %d %d", right_width, right_height);
      in_open = rc == 2 && rc_right == 2;
      in_over = !in_open;
      in_x = 0;
      in_y = 0;
      if (in_open && (in_width != right_width || in_height != right_height) || (rc == 2) != (rc_right == 2)) bad_files = 1;
      if (in_open) begin
        read_ring = frames_read % FRAMES;
        width_of[read_ring[9:0]] = in_width;
        height_of[read_ring[9:0]] = in_height;
        rc = $fscanf(plan_file, "%d %h %d %d %d %d", apply, planned, stall_i, burst_i, planned_stall_o, planned_burst_o);
        if (rc != 6) bad_files = 1;
        stall_o_of[read_ring[9:0]] = planned_stall_o;
        burst_o_of[read_ring[9:0]] = planned_burst_o;
        frames_read = frames_read + 1;
      end
    end
  endtask

  initial begin
    done = 0; was_reset = 0; running = 0; finish = 0; hang = 0; bad_files = 0;
    i_valid = 0; i_payload = 0; o_ready = 0;
    in_open = 0; in_over = 0; new_offer = 1; seen = 0; held = 0; held_payload = 0;
    frames_read = 0; frames_begun = 0; frames_taken = 0; frames_seen = 0; frames_given = 0; pixels_taken = 0; pixels_given = 0;
    out_x = 0; out_y = 0; in_x = 0; in_y = 0; in_width = 0; in_height = 0; out_width = 0; out_height = 0;
    clock = 0; idle = 0; drain = 0; latency_first = 0; latency_max = 0; first_given = 0; offered_at = 0; first_offered = 0;
    flag_errors = 0; rule_errors = 0; unknown_words = 0; extra_words = 0;
    seed = 1; timeout = 200000;
    rc = $value$plusargs("seed=%d", seed);
    rc = $value$plusargs("timeout=%d", timeout);
    apply_settings = 0; settings = 0; apply = 0;
    stall_i = 0; burst_i = 0; wait_i = 0; stall_o = 0; burst_o = 0; wait_o = 0; willing = 0;
    rc = $value$plusargs("left=%s", left_name);
    rc = $value$plusargs("right=%s", right_name);
    rc = $value$plusargs("plan=%s", plan_name);
    rc = $value$plusargs("output=%s", output_name);
    rc = $value$plusargs("report=%s", report_name);
    // Not zero: a zero would stay zero.
    random_i = (seed * 32'h9e3779b1) | 1;
    random_o = (seed * 32'h85ebca6b) ^ 32'h5bd1e995 | 1;
  end

  always @(posedge clk) begin
    // Until the first reset the inputs may be noise.
    if (rst) was_reset = 1;
    if (go && !rst && was_reset && !running && !done) begin
      left_file = $fopen(left_name, "r");
      right_file = $fopen(right_name, "r");
      output_file = $fopen(output_name, "w");
      report_file = $fopen(report_name, "w");
      plan_file = $fopen(plan_name, "r");
      running = 1;
      bad_files = left_file == 0 || right_file == 0 || plan_file == 0 || output_file == 0 || report_file == 0;
      if (!bad_files) next_picture;
      if (frames_read == 0) bad_files = 1;
    end

    if (running) begin
      clock = clock + 1;
      idle = idle + 1;
      random_i = xorshift(random_i);
      random_o = xorshift(random_o);

      // The input word accepted in the clock that ends here.
      in_taken = i_valid && i_ready === 1'b1;
      if (i_ready !== 1'b1 && i_ready !== 1'b0) rule_errors = rule_errors + 1;
      if (in_taken) begin
        idle = 0;
        taken_at[pixels_taken[15:0]] = clock;
        pixels_taken = pixels_taken + 1;
        if (i_payload[16]) begin
          first_taken[frames_begun[9:0]] = clock;
          frames_begun = frames_begun + 1;
        end
        if (i_payload[18]) begin
          last_taken[frames_taken[9:0]] = clock;
          frames_taken = frames_taken + 1;
        end
      end

      // The output word of the clock that ends here. A payload holds until it is accepted.
      if (o_valid !== 1'b1 && o_valid !== 1'b0) rule_errors = rule_errors + 1;
      if (held && (o_valid !== 1'b1 || o_payload !== held_payload)) rule_errors = rule_errors + 1;
      held = o_valid === 1'b1 && !o_ready;
      held_payload = o_payload;
      if (o_valid === 1'b1) begin
        seen = 1;
        if (new_offer) offered_at = clock;
        new_offer = o_ready;
      end
      if (o_valid === 1'b1 && o_ready) begin
        idle = 0;
        if (pixels_given == pixels_taken) extra_words = extra_words + 1;
        else begin
          // Place the word by the size of the input picture, and compare its flags with that.
          ring = frames_given % FRAMES;
          out_width = width_of[ring[9:0]];
          out_height = height_of[ring[9:0]];
          first = out_x == 0 && out_y == 0;
          last = out_x == out_width - 1;
          end_ = last && out_y == out_height - 1;
          if (o_payload[WORD_BITS+2:WORD_BITS] !== {end_, last, first}) flag_errors = flag_errors + 1;
          if (^o_payload === 1'bx) unknown_words = unknown_words + 1;
          latency = offered_at - taken_at[pixels_given[15:0]];
          pixels_given = pixels_given + 1;
          if (first) begin
            $fwrite(output_file, "// %0d %0d\n", out_width, out_height);
            frames_seen = frames_seen + 1;
            first_given = clock;
            latency_first = latency;
            latency_max = 0;
          end
          if (latency > latency_max) latency_max = latency;
          if (out_x != 0) $fwrite(output_file, " ");
          word = 0;
          word[WORD_BITS-1:0] = o_payload[WORD_BITS-1:0];
          if (WORD_BITS > 8) $fwrite(output_file, "%06x", word);
          else $fwrite(output_file, "%02x", word[7:0]);
          if (last) begin
            $fwrite(output_file, "\n");
            $fflush(output_file);   // progress, for a reader of the file
          end
          out_x = last ? 0 : out_x + 1;
          if (last) out_y = end_ ? 0 : out_y + 1;
          if (end_) begin
            $fwrite(report_file, "frame%0d.width %0d\nframe%0d.height %0d\n", frames_given, out_width, frames_given, out_height);
            $fwrite(report_file, "frame%0d.clocks %0d\n", frames_given, clock - first_taken[ring[9:0]] + 1);
            $fwrite(report_file, "frame%0d.in_clocks %0d\n", frames_given, last_taken[ring[9:0]] - first_taken[ring[9:0]] + 1);
            $fwrite(report_file, "frame%0d.out_clocks %0d\n", frames_given, clock - first_given);
            $fwrite(report_file, "frame%0d.latency %0d\nframe%0d.latency_first %0d\n", frames_given, latency_max, frames_given, latency_first);
            $fwrite(report_file, "frame%0d.start %0d\n", frames_given, first_given);
            frames_given = frames_given + 1;
            seen = 0;
          end
        end
      end

      // The input word of the next clock. The payload of an idle clock is noise: it must not be read without `valid`.
      apply_settings <= 0;
      settings <= {SETTING_BITS{random_i[7]}};
      if (!i_valid || in_taken) begin
        if (in_open && apply == 0 && wait_i == 0 && {24'd0, random_i[15:8]} >= stall_i) begin
          rc = $fscanf(left_file, "%h", left);
          rc_right = $fscanf(right_file, "%h", right);
          if (rc != 1 || rc_right != 1) bad_files = 1;
          i_valid <= 1;
          i_payload <= {in_x == in_width - 1 && in_y == in_height - 1, in_x == in_width - 1, in_x == 0 && in_y == 0, right[7:0], left[7:0]};
          in_x = in_x + 1;
          if (in_x == in_width) begin
            in_x = 0;
            in_y = in_y + 1;
            if (in_y == in_height) next_picture;
          end
        end else begin
          i_valid <= 0;
          i_payload <= random_i[31:13];
          if (in_open && apply != 0 && frames_seen == frames_read - 1) begin
            apply_settings <= 1;
            settings <= planned;
            apply = 0;
          end else if (wait_i != 0) wait_i = wait_i - 1;
          else wait_i = {16'd0, random_i[31:16]} % (burst_i + 1);
        end
      end

      // `ready` of the next clock. With stalls the first word of a frame must be valid for a clock before it is accepted: a matcher
      // whose `valid` waits for `ready` then hangs.
      finish = in_over && frames_given == frames_read;
      if (finish) drain = drain + 1;
      if (frames_given != frames_read) begin
        ring = frames_given % FRAMES;
        stall_o = stall_o_of[ring[9:0]];
        burst_o = burst_o_of[ring[9:0]];
      end
      willing = wait_o == 0 && {24'd0, random_o[15:8]} >= stall_o;
      if (wait_o != 0) wait_o = wait_o - 1;
      else if (!willing) wait_o = {16'd0, random_o[31:16]} % (burst_o + 1);
      o_ready <= finish || willing && (stall_o == 0 || seen);

      hang = idle > timeout;
      if (bad_files || hang || drain > DRAIN) begin
        if (report_file != 0) begin
          $fwrite(report_file, "clocks %0d\nframes %0d\npixels_in %0d\npixels_out %0d\n", clock, frames_given, pixels_taken, pixels_given);
          $fwrite(report_file, "flag_errors %0d\nrule_errors %0d\nunknown_words %0d\n", flag_errors, rule_errors, unknown_words);
          $fwrite(report_file, "extra_words %0d\nerror %0d\nhang %0d\nbad_files %0d\n", extra_words, error, hang, bad_files);
          $fclose(report_file);
        end
        if (output_file != 0) $fclose(output_file);
        if (left_file != 0) $fclose(left_file);
        if (right_file != 0) $fclose(right_file);
        running = 0;
        done <= 1;
      end
    end
  end
endmodule
