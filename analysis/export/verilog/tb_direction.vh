// The rule's thresholds in noises / 256, by samples in a mean less one: the tables of tb_fixed.h; and single factors.
localparam [15:0] CEILING = 57344, MOVING = 9830;
localparam [3:0] LONGEST_GAP = 10;
localparam [1:0] LONGEST_SPIKE = 3;
localparam [2:0] LONGEST_MEAN = 7;
localparam [2:0] JUMP = 0, STEP_SHARE = 1, PART = 2, LEAD = 3, BAND = 4, HOLD = 5;
localparam [5:0] WIDEST_BAND = 48, REST = 49, TOO_FAR = 50, NEAR_TOP = 51, WINDOW = 52, SPLIT_FADE = 53;
(* ram_style = "block" *) reg [15:0] rules[0:255];
initial begin
  {rules[0], rules[1], rules[2], rules[3], rules[4], rules[5], rules[6], rules[7]} =
      {16'd1810, 16'd1568, 16'd1478, 16'd1431, 16'd1402, 16'd1383, 16'd1368, 16'd1358};  // JUMP
  {rules[8], rules[9], rules[10], rules[11], rules[12], rules[13], rules[14], rules[15]} =
      {16'd32768, 16'd49152, 16'd54613, 16'd57344, 16'd58982, 16'd60075, 16'd60855, 16'd61440};  // STEP_SHARE
  {rules[16], rules[17], rules[18], rules[19], rules[20], rules[21], rules[22], rules[23]} =
      {16'd65535, 16'd32768, 16'd21845, 16'd16384, 16'd13107, 16'd10923, 16'd9362, 16'd8192};  // PART
  {rules[24], rules[25], rules[26], rules[27], rules[28], rules[29], rules[30], rules[31]} =
      {16'd0, 16'd158, 16'd172, 16'd168, 16'd160, 16'd152, 16'd145, 16'd139};  // LEAD
  {rules[32], rules[33], rules[34], rules[35], rules[36], rules[37], rules[38], rules[39]} =
      {16'd1408, 16'd996, 16'd813, 16'd704, 16'd630, 16'd575, 16'd532, 16'd498};  // BAND
  {rules[40], rules[41], rules[42], rules[43], rules[44], rules[45], rules[46], rules[47]} =
      {16'd410, 16'd290, 16'd236, 16'd205, 16'd183, 16'd167, 16'd155, 16'd145};  // HOLD
  {rules[48], rules[49], rules[50], rules[51], rules[52], rules[53]} =
      {16'd1408, 16'd768, 16'd13107, 16'd655, 16'd2731, 16'd106};
end
