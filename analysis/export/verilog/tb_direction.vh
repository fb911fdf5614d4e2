// The rule's thresholds in noises / 256, by samples in a mean less one: the tables of tb_fixed.h.
localparam [15:0] CEILING = 57344, MOVING = 9830, WINDOW = 2731;
localparam [10:0] BAND = 1408, REST = 768;
localparam [3:0] LONGEST_GAP = 10;
localparam [1:0] LONGEST_SPIKE = 3;
localparam [2:0] LONGEST_MEAN = 7;

function [10:0] jump_of(input [2:0] n);
  case (n)
    0: jump_of = 1810;
    1: jump_of = 1568;
    2: jump_of = 1478;
    3: jump_of = 1431;
    4: jump_of = 1402;
    5: jump_of = 1383;
    6: jump_of = 1368;
    7: jump_of = 1358;
  endcase
endfunction
function [15:0] step_share_of(input [2:0] n);
  case (n)
    0: step_share_of = 32768;
    1: step_share_of = 49152;
    2: step_share_of = 54613;
    3: step_share_of = 57344;
    4: step_share_of = 58982;
    5: step_share_of = 60075;
    6: step_share_of = 60855;
    7: step_share_of = 61440;
  endcase
endfunction
function [15:0] part_of(input [2:0] n);
  case (n)
    0: part_of = 65535;
    1: part_of = 32768;
    2: part_of = 21845;
    3: part_of = 16384;
    4: part_of = 13107;
    5: part_of = 10923;
    6: part_of = 9362;
    7: part_of = 8192;
  endcase
endfunction
function [7:0] lead_of(input [2:0] n);
  case (n)
    0: lead_of = 0;
    1: lead_of = 158;
    2: lead_of = 172;
    3: lead_of = 168;
    4: lead_of = 160;
    5: lead_of = 152;
    6: lead_of = 145;
    7: lead_of = 139;
  endcase
endfunction
function [10:0] band_of(input [2:0] n);
  case (n)
    0: band_of = 1408;
    1: band_of = 996;
    2: band_of = 813;
    3: band_of = 704;
    4: band_of = 630;
    5: band_of = 575;
    6: band_of = 532;
    7: band_of = 498;
  endcase
endfunction
function [8:0] hold_of(input [2:0] n);
  case (n)
    0: hold_of = 410;
    1: hold_of = 290;
    2: hold_of = 236;
    3: hold_of = 205;
    4: hold_of = 183;
    5: hold_of = 167;
    6: hold_of = 155;
    7: hold_of = 145;
  endcase
endfunction
