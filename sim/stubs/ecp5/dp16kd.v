// The block RAM of an ECP5, 1,024 rows of 18 bits with two ports, for simulation: Yosys has a black box of it.
//
// After Lattice's technical note FPGA-TN-02204. A row has two bytes of nine bits; narrower words leave the ninth bit out. Ports of 18
// and 36 bits have byte enables in the lowest bits of their address. With 36 bits, port A writes and port B reads, and the halves of a
// word are at the data of A and B. An output register has no reset here.
/* verilator lint_off MULTIDRIVEN */
/* verilator lint_off WIDTH */
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNUSEDPARAM */
/* verilator lint_off BLKSEQ */
module DP16KD(
    input DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0,
    input ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
    input CEA, OCEA, CLKA, WEA, RSTA, CSA2, CSA1, CSA0,
    output DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0,
    input DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0,
    input ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    input CEB, OCEB, CLKB, WEB, RSTB, CSB2, CSB1, CSB0,
    output DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0
);
    parameter DATA_WIDTH_A = 18;
    parameter DATA_WIDTH_B = 18;
    parameter REGMODE_A = "NOREG";
    parameter REGMODE_B = "NOREG";
    parameter RESETMODE = "SYNC";
    parameter ASYNC_RESET_RELEASE = "SYNC";
    parameter CSDECODE_A = "0b000";
    parameter CSDECODE_B = "0b000";
    parameter WRITEMODE_A = "NORMAL";
    parameter WRITEMODE_B = "NORMAL";
    parameter CLKAMUX = "CLKA";
    parameter CLKBMUX = "CLKB";
    parameter GSR = "ENABLED";
    parameter INIT_DATA = "STATIC";
    parameter [319:0] INITVAL_00 = 320'd0; parameter [319:0] INITVAL_01 = 320'd0;
    parameter [319:0] INITVAL_02 = 320'd0; parameter [319:0] INITVAL_03 = 320'd0;
    parameter [319:0] INITVAL_04 = 320'd0; parameter [319:0] INITVAL_05 = 320'd0;
    parameter [319:0] INITVAL_06 = 320'd0; parameter [319:0] INITVAL_07 = 320'd0;
    parameter [319:0] INITVAL_08 = 320'd0; parameter [319:0] INITVAL_09 = 320'd0;
    parameter [319:0] INITVAL_0A = 320'd0; parameter [319:0] INITVAL_0B = 320'd0;
    parameter [319:0] INITVAL_0C = 320'd0; parameter [319:0] INITVAL_0D = 320'd0;
    parameter [319:0] INITVAL_0E = 320'd0; parameter [319:0] INITVAL_0F = 320'd0;
    parameter [319:0] INITVAL_10 = 320'd0; parameter [319:0] INITVAL_11 = 320'd0;
    parameter [319:0] INITVAL_12 = 320'd0; parameter [319:0] INITVAL_13 = 320'd0;
    parameter [319:0] INITVAL_14 = 320'd0; parameter [319:0] INITVAL_15 = 320'd0;
    parameter [319:0] INITVAL_16 = 320'd0; parameter [319:0] INITVAL_17 = 320'd0;
    parameter [319:0] INITVAL_18 = 320'd0; parameter [319:0] INITVAL_19 = 320'd0;
    parameter [319:0] INITVAL_1A = 320'd0; parameter [319:0] INITVAL_1B = 320'd0;
    parameter [319:0] INITVAL_1C = 320'd0; parameter [319:0] INITVAL_1D = 320'd0;
    parameter [319:0] INITVAL_1E = 320'd0; parameter [319:0] INITVAL_1F = 320'd0;
    parameter [319:0] INITVAL_20 = 320'd0; parameter [319:0] INITVAL_21 = 320'd0;
    parameter [319:0] INITVAL_22 = 320'd0; parameter [319:0] INITVAL_23 = 320'd0;
    parameter [319:0] INITVAL_24 = 320'd0; parameter [319:0] INITVAL_25 = 320'd0;
    parameter [319:0] INITVAL_26 = 320'd0; parameter [319:0] INITVAL_27 = 320'd0;
    parameter [319:0] INITVAL_28 = 320'd0; parameter [319:0] INITVAL_29 = 320'd0;
    parameter [319:0] INITVAL_2A = 320'd0; parameter [319:0] INITVAL_2B = 320'd0;
    parameter [319:0] INITVAL_2C = 320'd0; parameter [319:0] INITVAL_2D = 320'd0;
    parameter [319:0] INITVAL_2E = 320'd0; parameter [319:0] INITVAL_2F = 320'd0;
    parameter [319:0] INITVAL_30 = 320'd0; parameter [319:0] INITVAL_31 = 320'd0;
    parameter [319:0] INITVAL_32 = 320'd0; parameter [319:0] INITVAL_33 = 320'd0;
    parameter [319:0] INITVAL_34 = 320'd0; parameter [319:0] INITVAL_35 = 320'd0;
    parameter [319:0] INITVAL_36 = 320'd0; parameter [319:0] INITVAL_37 = 320'd0;
    parameter [319:0] INITVAL_38 = 320'd0; parameter [319:0] INITVAL_39 = 320'd0;
    parameter [319:0] INITVAL_3A = 320'd0; parameter [319:0] INITVAL_3B = 320'd0;
    parameter [319:0] INITVAL_3C = 320'd0; parameter [319:0] INITVAL_3D = 320'd0;
    parameter [319:0] INITVAL_3E = 320'd0; parameter [319:0] INITVAL_3F = 320'd0;

    localparam [20479:0] INITIAL = {
        INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38,
        INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30,
        INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28,
        INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24, INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20,
        INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18,
        INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10,
        INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
        INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01, INITVAL_00};

    reg [17:0] rows [0:1023];
    integer row;
    initial begin
        for (row = 0; row < 1024; row = row + 1)
            rows[row] = INITIAL[20 * row +: 18];
        if (CSDECODE_A != "0b000" || CSDECODE_B != "0b000"
                || CLKAMUX != "CLKA" || CLKBMUX != "CLKB") begin
            $display("DP16KD: a mode that this model does not have");
            $finish;
        end
    end

    always @(posedge RSTA or posedge RSTB)
        if (RESETMODE != "SYNC" || REGMODE_A == "OUTREG" || REGMODE_B == "OUTREG") begin
            $display("DP16KD: an asynchronous reset, or one of an output register, which this model does not have");
            $finish;
        end

    wire [17:0] dia = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
    wire [17:0] dib = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};
    wire [13:0] ada = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
    wire [13:0] adb = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
    reg [17:0] doa = 18'd0;
    reg [17:0] dob = 18'd0;
    reg [17:0] registered_a = 18'd0;
    reg [17:0] registered_b = 18'd0;
    assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0}
        = REGMODE_A == "OUTREG" ? registered_a : doa;
    assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0}
        = REGMODE_B == "OUTREG" ? registered_b : dob;

    // A word of 36 bits is read by port B alone.
    wire clock_a = DATA_WIDTH_B == 36 ? CLKB : CLKA;
    always @(posedge clock_a)
        if (DATA_WIDTH_B == 36 ? OCEB : OCEA)
            registered_a <= doa;
    always @(posedge CLKB)
        if (OCEB)
            registered_b <= dob;

    // Lowest bit of a narrow word in its row.
    function [4:0] place(input [13:0] address, input integer width);
        place = (address[3] ? 5'd9 : 5'd0) + (width == 9 ? 5'd0 : width == 4 ? {2'd0, address[2], 2'd0}
            : width == 2 ? {2'd0, address[2:1], 1'd0} : {2'd0, address[2:0]});
    endfunction

    // A row after a write.
    function [17:0] written(input [17:0] held, input [13:0] address, input [17:0] data, input integer width);
        reg [17:0] mask;
        begin
            mask = width == 18 ? {{9{address[1]}}, {9{address[0]}}} : ((18'd1 << width) - 18'd1) << place(address, width);
            written = held & ~mask | (width == 18 ? data : data << place(address, width)) & mask;
        end
    endfunction

    function [17:0] found(input [17:0] whole, input [13:0] address, input integer width);
        found = width == 18 ? whole : whole >> place(address, width) & ((18'd1 << width) - 18'd1);
    endfunction

    generate
        if (DATA_WIDTH_A == 36) begin : pseudo
            always @(posedge CLKA)
                if (CEA && WEA) begin
                    rows[{ada[13:5], 1'b0}] <= written(rows[{ada[13:5], 1'b0}], {12'd0, ada[1:0]}, dia, 18);
                    rows[{ada[13:5], 1'b1}] <= written(rows[{ada[13:5], 1'b1}], {12'd0, ada[3:2]}, dib, 18);
                end
        end else begin : port_a
            wire [17:0] held = rows[ada[13:4]];
            wire [17:0] stored = written(held, ada, dia, DATA_WIDTH_A);
            always @(posedge CLKA)
                if (CEA) begin
                    if (WEA)
                        rows[ada[13:4]] <= stored;
                    if (RSTA)
                        doa <= 18'd0;
                    else if (!WEA || WRITEMODE_A != "NORMAL")
                        doa <= found(WEA && WRITEMODE_A == "WRITETHROUGH" ? stored : held, ada, DATA_WIDTH_A);
                end
        end
        if (DATA_WIDTH_B == 36) begin : wide_read
            always @(posedge CLKB)
                if (CEB) begin
                    doa <= RSTB ? 18'd0 : rows[{adb[13:5], 1'b0}];
                    dob <= RSTB ? 18'd0 : rows[{adb[13:5], 1'b1}];
                end
        end else begin : port_b
            wire [17:0] held = rows[adb[13:4]];
            wire [17:0] stored = written(held, adb, dib, DATA_WIDTH_B);
            always @(posedge CLKB)
                if (CEB) begin
                    if (WEB && DATA_WIDTH_A != 36)
                        rows[adb[13:4]] <= stored;
                    if (RSTB)
                        dob <= 18'd0;
                    else if (!WEB || WRITEMODE_B != "NORMAL")
                        dob <= found(WEB && WRITEMODE_B == "WRITETHROUGH" ? stored : held, adb, DATA_WIDTH_B);
                end
        end
    endgenerate
endmodule
