// Loads tb_model.mem and holds the module against the rows of vectors.csv, or of +vectors=FILE, +rows=N of them at most.
// The last line is PASSED or FAILED.
`timescale 1ns / 1ns
`include "tb_model.vh"
module tb_bench;
  localparam [1:0] FRAME = 0, LOST = 1, TARE = 2;
  // From count to count of a taxel: the longest way through tb_elam's states (analysis/export/README.md), by steps of a search.
  localparam MOST_CYCLES = 245 + 7 * `TB_EXACT_OUTER + 5 * $clog2(`TB_KNOTS - 1);
  reg clk = 0, reset = 1;
  always #5 clk = !clk;

  reg [15:0] words[0:`TB_WORDS-1];
  reg load_valid = 0;
  wire load_ready, loaded;
  reg [15:0] load_word = 0;
  wire [31:0] hash;
  reg in_valid = 0;
  wire in_ready;
  reg [1:0] in_event = 0;
  reg [15:0] in_count = 0;
  wire out_valid;
  reg out_ready = 1;
  wire [15:0] out_pressure;
  wire [6:0] out_status;
  tb_elam elam (
      .clk(clk), .reset(reset),
      .load_valid(load_valid), .load_ready(load_ready), .load_word(load_word), .loaded(loaded), .hash(hash),
      .in_valid(in_valid), .in_ready(in_ready), .in_event(in_event), .in_count(in_count),
      .out_valid(out_valid), .out_ready(out_ready), .out_pressure(out_pressure), .out_status(out_status));

  reg [1023:0] name;
  integer file, rows, row, letter, field, i, got, samples, differ, cycles, started, most, sum;
  reg [15:0] counts[0:`TB_TAXELS-1], pressures[0:`TB_TAXELS-1], states[0:`TB_TAXELS-1];
  always @(posedge clk) cycles <= cycles + 1;

  task finish(input ok);
    begin
      $display("%0d readings, %0d differ; hash %08h; cycles a taxel: %0d at most (bound %0d), %0d.%02d in the mean", samples, differ, hash, most, MOST_CYCLES,
               sum / (samples + 1), sum % (samples + 1) * 100 / (samples + 1));
      $display("%0s", ok && differ == 0 && samples != 0 && most <= MOST_CYCLES ? "PASSED" : "FAILED");
      $finish;
    end
  endtask

  initial begin
    cycles = 0;
    samples = 0;
    differ = 0;
    most = 0;
    sum = 0;
    if (!$value$plusargs("vectors=%s", name)) name = "vectors.csv";
    if (!$value$plusargs("rows=%d", rows)) rows = 1 << 30;
    $readmemh("tb_model.mem", words);
    repeat (4) @(negedge clk);
    reset = 0;
    for (i = 0; i < `TB_WORDS; i = i + 1) begin
      load_valid = 1;
      load_word = words[i];
      @(negedge clk);
    end
    load_valid = 0;
    while (!loaded) @(negedge clk);
    if (hash !== `TB_HASH) begin
      $display("hash %08h, and %08h was exported: the words are damaged", hash, `TB_HASH);
      finish(0);
    end
    file = $fopen(name, "r");
    letter = $fgetc(file);
    row = 0;
    while (letter != -1 && row < rows && hash === `TB_HASH) begin
      in_event = letter == "t" ? TARE : letter == "l" ? LOST : FRAME;
      while (letter != ",") letter = $fgetc(file);
      for (field = 0; field < 3; field = field + 1)
        for (i = 0; i < `TB_TAXELS; i = i + 1) begin
          got = $fscanf(file, "%d", letter);
          if (got != 1) finish(0);
          if (field == 0) counts[i] = letter[15:0];
          if (field == 1) pressures[i] = letter[15:0];
          if (field == 2) states[i] = letter[15:0];
          letter = $fgetc(file);
        end
      letter = $fgetc(file);
      row = row + 1;
      for (i = 0; i < `TB_TAXELS; i = i + 1) begin
        in_valid = 1;
        in_count = counts[i];
        started = cycles;
        while (!in_ready) @(negedge clk);
        @(negedge clk);
        in_valid = 0;
        while (!out_valid) @(negedge clk);
        if (in_event != TARE) begin
          samples = samples + 1;
          if (out_pressure !== pressures[i] || {9'd0, out_status} !== states[i]) begin
            differ = differ + 1;
            if (differ <= 10)
              $display("row %0d, taxel %0d, count %0d: %0d, status %0d; expected %0d, %0d", row, i, counts[i], out_pressure, out_status,
                       pressures[i], states[i]);
          end
        end
        if (cycles - started + 1 > most) most = cycles - started + 1;
        sum = sum + cycles - started + 1;
      end
    end
    finish(1);
  end
endmodule
