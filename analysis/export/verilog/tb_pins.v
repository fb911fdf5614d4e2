// The module between few pins, to place it by itself: a count or word comes bit by bit.
`include "tb_model.vh"
module tb_pins (
    input clk,
    input reset,
    input in_bit,
    input load_valid,
    output load_ready,
    output whole,  // loaded, and the words are those that were exported
    input in_valid,
    output in_ready,
    output out_valid,
    input out_ready,
    output [15:0] pressure,
    output [6:0] status
);
  reg [17:0] in;
  wire loaded;
  wire [31:0] hash;
  tb_elam elam (
      .clk(clk), .reset(reset),
      .load_valid(load_valid), .load_ready(load_ready), .load_word(in[15:0]), .loaded(loaded), .hash(hash),
      .in_valid(in_valid), .in_ready(in_ready), .in_event(in[17:16]), .in_count(in[15:0]),
      .out_valid(out_valid), .out_ready(out_ready), .out_pressure(pressure), .out_status(status));
  assign whole = loaded && hash == `TB_HASH;
  always @(posedge clk) in <= {in[16:0], in_bit};
endmodule
