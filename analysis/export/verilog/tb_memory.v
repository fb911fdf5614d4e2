// A page for each taxel, one port: either written or read, the word a cycle after its address.
module tb_memory #(
    parameter WIDTH = 16,
    parameter ADDRESS = 8,
    /* verilator lint_off UNUSEDPARAM */
    parameter STYLE = "block"  // or "huge": a single-port RAM of 256 kbit
    /* verilator lint_on UNUSEDPARAM */
) (
    input clk,
    input write,
    input [ADDRESS-1:0] at,
    input [WIDTH-1:0] in,
    output reg [WIDTH-1:0] out
);
  (* ram_style = STYLE *) reg [WIDTH-1:0] words[0:(1<<ADDRESS)-1];
  always @(posedge clk)
    if (write) words[at] <= in;
    else out <= words[at];
endmodule
