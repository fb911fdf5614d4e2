// ELAM in integers, one taxel after another: the steps of tb_fixed.h and tb_elam.h, whose names and numbers of equations stand here.
// One product, one restoring divider of 4 bits a cycle. Words are loaded in the order of tb_elam_hash and read back for the hash.
`include "tb_model.vh"
module tb_elam #(
    parameter TAXELS = `TB_TAXELS,              // 1 to 256
    parameter KNOTS = `TB_KNOTS,                // 2 to 32
    parameter [15:0] FLIP = `TB_FLIP,           // 65535: the output falls
    parameter COUNT_SHIFT = `TB_COUNT_SHIFT,
    parameter PLACE_SHIFT = `TB_PLACE_SHIFT,
    parameter [0:0] EXACT_OUTER = `TB_EXACT_OUTER
) (
    input clk,
    input reset,
    // TB_WORDS words after a reset; then `loaded`, and `hash` of what the memories hold, which must be TB_HASH.
    input load_valid,
    output load_ready,
    input [15:0] load_word,
    output reg loaded,
    output reg [31:0] hash,
    // TAXELS counts a frame, row by row. Event 0: a frame; 1: a lost one, of whatever count; 2: tare.
    input in_valid,
    output in_ready,
    input [1:0] in_event,
    input [15:0] in_count,
    // As many readings; status as in tb_fixed.h, of a tare 1, or 4: too far off, or 8: dead.
    output out_valid,
    input out_ready,
    output [15:0] out_pressure,
    output [6:0] out_status
);
  `include "tb_direction.vh"
  localparam [15:0] X = 65535, Y = 61440, NEAR_END = 655;
  localparam [3:0] POINTS = 10;
  localparam [4:0] LAST_KNOT = KNOTS - 1;
  localparam [8:0] LAST_TAXEL = TAXELS - 1;
  localparam [4:0] GAIN = 0, ZERO = 1, TOP = 3, LIMIT = 5, PLACE = 7, UP = 8, DOWN = 9, ALPHA_D = 10, BETA_D = 11, BETA_A = 12,
                   SPLIT_SHORT = 13, SPLIT_LONG = 14;
  localparam [1:0] HELD = 0, BACK = 1, AHEAD = 2, TURNED = 3;
  localparam [1:0] HERE = 0, WAY = 1, FIND = 2;  // what a piece is searched for

  localparam [6:0] LOAD = 0, H0 = 1, H1 = 2, H2 = 3, H3 = 4, H4 = 5, IN0 = 6, IN1 = 7, IN2 = 8, ST0 = 9, ST1 = 10, ST2 = 11,
                   ST3 = 12, IDLE = 13, B1 = 14, B2 = 15, B3 = 16, B4 = 17, B5 = 18, B7 = 19, B6 = 20, CL = 21, CL2 = 22,
                   R1 = 23, R2 = 24, T1 = 25, T2 = 26, T3 = 27, T4 = 28, T5 = 29, HI1 = 30, HI2 = 31, HI3 = 32, HI4 = 33,
                   HI5 = 34, FO1 = 35, FO2 = 36, FO3 = 37, FO4 = 38, FO5 = 39, FO6 = 40, Z0 = 41, Z1 = 42, Z2 = 43, Z3 = 44,
                   Z4 = 45, Z5 = 46, Q0 = 47, Q1 = 48, W0 = 49, W1 = 50, WA = 51, WB = 52, L0 = 53, L1 = 54, L2 = 55, F0 = 56,
                   A0 = 57, A1 = 58, A2 = 59, A3 = 60, A4 = 61, A5 = 62, A6 = 63, A7 = 64, A8 = 65, D0 = 66, D1 = 67, D2 = 68,
                   D3 = 69, D4 = 70, D5 = 71, D6 = 72, D7 = 73, SH1 = 74, SH2 = 75, OU = 76, OU2 = 77, RE = 78, RD = 79,
                   RX = 80, RF = 81, RG = 82, P0 = 83, P1 = 84, P2 = 85, SL = 86, K1 = 87, K2 = 88, E0 = 89, E1 = 90, E2 = 91,
                   EX0 = 92, EX1 = 93, EX2 = 94, CX2 = 95, CU = 96, CUT = 97, AL = 98, AL2 = 99, DIV = 100, MUL = 101,
                   MAP = 102, OUT = 103;
  reg [6:0] state, after;  // `after` the map

  // A taxel and its state.
  reg [7:0] taxel;
  reg [3:0] gap;
  reg [1:0] event_;
  reg [15:0] count, steps, pressure, limit_high;
  reg signed [25:0] top, y, mean, extreme, turn;
  reg signed [26:0] zero, off;
  reg [2:0] samples, extreme_samples;
  reg [1:0] spikes;
  reg [3:0] below;
  reg rises, begun, not_known, searched, has_here, has_there;
  reg [6:0] status;

  // The product.
  reg signed [26:0] factor;
  reg [15:0] by;
  wire [31:0] product_low = factor[15:0] * by;
  wire [26:0] product_high = factor[26:16] * by;
  reg [31:0] whole;  // a cycle later
  reg [26:0] whole_high;
  /* verilator lint_off UNUSEDSIGNAL */
  wire [26:0] m = whole_high + {11'd0, whole[31:16]};  // M(factor, by)
  /* verilator lint_on UNUSEDSIGNAL */
  always @(posedge clk) begin
    whole <= product_low;
    whole_high <= product_high - (factor[26] ? {by, 11'd0} : 27'd0);
  end

  // Memories.
  reg [1:0] phase;  // of the loader: x, words, patterns
  reg [4:0] item;
  reg falls_;
  wire loads = state == LOAD && load_valid, hashes = state == LOAD || state == H0 || state == H1;
  reg [4:0] knot_at, word_at;
  reg [3:0] point_at;
  wire [15:0] pattern, x_knot, word_;
  wire [31:0] point;
  reg er;
  tb_memory #(16, 14, "huge") patterns (clk, loads && phase == 2, {taxel, hashes ? falls_ : !er, knot_at}, load_word, pattern);
  tb_memory #(16, 5, "block") knots (clk, loads && phase == 0, knot_at, load_word, x_knot);
  tb_memory #(16, 14, "huge") parameters_ (clk, loads && phase == 1, {1'b0, taxel, word_at}, load_word, word_);
  wire far = off[26] ? !(&off[26:11]) || off[10:0] == 0 : |off[26:11];  // beyond 2047
  wire [10:0] size = off[26] ? -off[10:0] : off[10:0];
  // One threshold of the rule at a time.
  wire noisy = samples == LONGEST_MEAN && extreme_samples != LONGEST_MEAN;  // came to rest so near that the extreme was noise
  wire [2:0] fewer = samples < extreme_samples ? samples : extreme_samples;
  wire [10:0] threshold = state == FO2 ? jump_of(samples) : state == Z3 ? band_of(fewer) : state != Z4 ? BAND : noisy ? REST : {2'd0, hold_of(fewer)};
  wire exceeds = far || size > threshold, behind = !off[26] && exceeds;
  wire near_band = !behind;
  wire at_zero = low_zone || !off[26];  // in HI4, where a history that is not known begins anew
  wire puts_point = state == WB || (state == HI4 && at_zero) || state == ST3, forgets_points = state != WB;
  tb_memory #(16, 14, "huge") points_x (clk, puts_point, {2'd0, taxel, point_at}, forgets_points ? 16'd0 : mapped, point[15:0]);
  tb_memory #(16, 14, "huge") points_u (clk, puts_point, {2'd0, taxel, point_at}, forgets_points ? 16'd0 : along_u, point[31:16]);

  wire [101:0] kept;
  tb_memory #(102, 8, "block") core (clk, state == OUT || state == ST3, taxel,
    {mean, extreme, steps, samples, extreme_samples, spikes, below, pressure, rises, begun, not_known, searched, has_here,
     has_there}, kept);
  wire [26:0] kept_zero;
  wire [15:0] kept_high, kept_low;
  tb_memory #(59, 8, "block") limits (clk, state == ST2, taxel, {zero, limit_high, sum_word}, {kept_zero, kept_high, kept_low});
  reg [15:0] p_low, p_high, p_x_low, p_x_high;  // the piece
  wire [63:0] kept_piece;
  reg [1:0] goal;
  wire is_there = goal == FIND;
  tb_memory #(64, 9, "block") pieces (clk, state == AL, {is_there, taxel}, {p_low, p_high, p_x_low, p_x_high}, kept_piece);
  reg known;
  reg [15:0] split, turn_x, reach;  // tb_elam_shape
  wire [15:0] kept_split, kept_turn_x, kept_reach;
  tb_memory #(48, 8, "block") shapes (clk, state == P0 && !known && goal != FIND, taxel, {split, turn_x, reach},
    {kept_split, kept_turn_x, kept_reach});

  // A branch: end, split; the part on which the output lies.
  reg [15:0] lo_x, lo_u, hi_x, hi_u, split_x, split_y, along_u, share;
  reg [3:0] left;
  reg [1:0] zone;
  reg [15:0] u, turn_u;
  reg looks_left, was_left, negative, low_zone, high_zone, outer, end_above, scaled, upper, flat, cuts;
  wire [15:0] of_low = er ? lo_u : reach, of_high = er ? reach : hi_u;
  wire [15:0] y_low = upper ? split_y : er ? lo_u : 16'd0, y_high = !upper ? split_y : er ? Y : hi_u;
  wire [15:0] part_low = upper ? split_x : er ? lo_x : 16'd0, part_high = !upper ? split_x : er ? X : hi_x;
  wire [15:0] own_low = upper ? split : er ? turn_x : 16'd0, own_high = !upper ? split : er ? X : Y;  // on the pattern
  wire [15:0] first = er ? y_low : own_low, last = er ? y_high : own_high;

  // The search of a knot.
  reg [4:0] k, left_knots;
  reg [15:0] unsought;  // the complement of what is sought
  reg on_x;
  reg [6:0] found;
  wire [4:0] half = left_knots >> 1, next_left = left_knots - half;
  wire [15:0] knot_of = on_x ? x_knot : pattern, knot_to = on_x ? pattern : x_knot;
  /* verilator lint_off UNUSEDSIGNAL */
  wire [16:0] compared = {1'b0, knot_of} + {1'b0, unsought};  // carries: the knot is above
  /* verilator lint_on UNUSEDSIGNAL */
  wire [4:0] next_k = compared[16] ? k : k + half;
  reg both, low_0, high_0, low_1, high_1, low_e, high_e, has_low, has_high, ends_knots, ends_low;
  wire rises_to = low_e || (!high_e && !beyond);  // in E2: the knot's output is below
  wire next_low = ends_knots ? ends_low : rises_to || has_low;
  wire [4:0] probe_k = rises_to && !ends_knots ? k + half : k;
  reg [15:0] at_0, at_1, at_e;

  // tb_map and tb_along.
  reg [15:0] v, v_low, v_high, to_low, to_high;
  reg [15:0] rest, over, rise, quotient, mapped;
  reg [1:0] turns;
  wire goes_along = state == W1 || state == WA || state == Q1 || state == AL, is_x = state == EX0 || state == EX1;
  wire [16:0] past = {1'b0, v} - {1'b0, v_low}, room = {1'b0, v_high} - {1'b0, v_low}, climb = {1'b0, to_high} - {1'b0, to_low};
  wire at_low = v == v_low, under = past[16] || at_low, beyond = v >= v_high, between = !under && !beyond, same = v_low == to_low && v_high == to_high;
  wire x_under = state == EX0 ? low_0 : low_1, x_beyond = state == EX0 ? high_0 : high_1, x_same = !er && y_low == 0;
  reg takes_low, takes_high, takes_v;
  always @* begin
    takes_low = under;
    takes_high = beyond && !under;
    takes_v = same && !under && !beyond;
    if (goes_along) begin
      takes_low = under && !beyond;
      takes_high = beyond;
      takes_v = 0;
    end
    if (is_x && (x_under || x_beyond || x_same)) begin
      takes_low = x_under;
      takes_high = x_beyond && !x_under;
      takes_v = !x_under && !x_beyond;
    end
    if ((state == E1 && !scaled) || state == A1 || state == A4 || state == A6 || state == D2) begin
      takes_low = 0;
      takes_high = 0;
      takes_v = 1;
    end
  end
  /* verilator lint_off UNUSEDSIGNAL */  // of carries
  wire [16:0] mapping = {mapped, 1'b1} + {negative ? ~whole[31:16] : whole[31:16], negative};
  function [16:0] divided(input [15:0] from, input [15:0] less);  // one bit of the quotient, and what is left; the complement of by what
    reg [17:0] minus;
    begin
      minus = {from, 2'b01} + {1'b1, less, 1'b1};
      divided = minus[17] ? {1'b0, from[14:0], 1'b0} : {1'b1, minus[16:1]};
    end
  endfunction
  /* verilator lint_on UNUSEDSIGNAL */
  wire [16:0] bit_3 = divided(rest, over), bit_2 = divided(bit_3[15:0], over), bit_1 = divided(bit_2[15:0], over),
              bit_0 = divided(bit_1[15:0], over);
  always @* begin
    {v, v_low, v_high, to_low, to_high} = 80'bx;
    case (state)
      K2: {v, v_low, v_high, to_low, to_high} = {~unsought, at_0, knot_of, at_1, knot_to};
      OU: {v, v_low, v_high, to_low, to_high} = {split, er ? lo_x : 16'd0, Y, 16'd0, hi_u};
      RE: {v, v_low, v_high, to_low, to_high} =
          er ? {hi_x, lo_x, split_x, turn_x, split} : {lo_x, split_x, hi_x, split_x, X};
      RD: {v, v_low, v_high, to_low, to_high} = {hi_x, split_x, X, split, X};
      RF: {v, v_low, v_high, to_low, to_high} = end_above ? {mapped, split, Y, split_y, hi_u} : {mapped, 16'd0, split, 16'd0, split_y};
      P0, L2: {v, v_low, v_high, to_low, to_high} = {along_u, lo_u, hi_u, of_low, of_high};
      E0: {v, v_low, v_high, to_low, to_high} = {pattern, first, last, y_low, y_high};
      E1: {v, v_low, v_high, to_low, to_high} = {mapped, of_low, of_high, lo_u, hi_u};
      E2: {v, v_high} = {mapped, along_u};
      EX0, EX1:
        {v, v_low, v_high, to_low, to_high} = {state == EX0 ? at_0 : at_1, er ? own_low : part_low, er ? own_high : X, part_low, part_high};
      W1, WA, Q1, AL: {v, v_low, v_high, to_low, to_high} = {along_u, p_low, p_high, p_x_low, p_x_high};
      A0: {v_low, v_high} = {lo_u, Y};
      A2: {v, v_low} = {word_, at_e};
      D6: {v, v_high} = {whole[31:16], hi_x};
      P1: {v, v_low} = {mapped, split_y};
      CU: {v, v_low, v_high} = {er ? hi_u : lo_u, p_low, p_high};
      B1: {v, v_low, v_high} = {count, kept_low, kept_high};
      A1: v = lo_u;
      A4: v = at_e;
      EX2, CX2, CUT, A6, D2: {v, v_low, v_high} = {state == EX2 || state == A6 || (state == CUT && !er) ? lo_x : hi_x, p_x_low, p_x_high};
      default: ;
    endcase
  end

  // What is multiplied.
  wire [10:0] cut = far ? 11'd2047 : size;
  wire [26:0] mean_shifted = {mean[25], mean} << PLACE_SHIFT, turn_shifted = {turn[25], turn} << PLACE_SHIFT;
  always @* begin
    factor = 27'bx;
    by = 16'bx;
    case (state)
      H2: {factor, by} = {11'd0, hash[15:0], 16'h0193};
      H3: {factor, by} = {11'd0, hash[31:16], 16'h0193};
      B2: {factor, by} = {off, word_};
      T1: {factor, by} = {top[25], top, 16'd13107};
      HI1: {factor, by} = {top[25], top, 16'd655};
      FO2: {factor, by} = {16'd0, cut, 5'd0, cut};
      FO3: {factor, by} = {5'd0, whole[21:0], step_share_of(samples)};
      FO4: {factor, by} = {off, part_of(samples)};
      FO6: {factor, by} = {off, WINDOW};
      Z1: {factor, by} = {mean_shifted, word_};
      Z2: {factor, by} = {turn_shifted, word_};
      A1: {factor, by} = {11'd0, ~over, word_};
      A4: {factor, by} = {11'd0, ~lo_x, share};
      A6: {factor, by} = {11'd0, ~lo_x, mapped};
      D1: {factor, by} = {11'd0, share, 16'd106};
      D2: {factor, by} = {11'd0, ~hi_x, whole[15:0]};
      D5: {factor, by} = {11'd0, share, word_};
      D6: {factor, by} = {11'd0, hi_u, word_};
      MUL: {factor, by} = {11'd0, rise, quotient};
      default: ;
    endcase
  end
  // The one sum of long words; of what is taken away the complement, and `plus`.
  reg signed [26:0] augend, addend;
  reg plus;
  /* verilator lint_off UNUSEDSIGNAL */  // of carries
  wire [27:0] sums = {augend, 1'b1} + {addend, plus};
  /* verilator lint_on UNUSEDSIGNAL */
  wire signed [26:0] sum = sums[27:1];
  wire signed [26:0] as_zero = {11'd0, count} << COUNT_SHIFT;
  wire [26:0] long_top = {top[25], top}, long_y = {y[25], y}, long_mean = {mean[25], mean},
              long_extreme = {extreme[25], extreme}, long_turn = {turn[25], turn};
  wire [26:0] lead = {19'd0, lead_of(extreme_samples)};
  always @* begin
    augend = 27'bx;
    addend = 27'bx;
    plus = 1;
    case (state)
      B1: {augend, addend} = {as_zero, ~kept_zero};
      B6: {augend, addend} = {long_top, ~off};
      CL: {augend, addend} = {off, ~long_y};
      CL2: {augend, addend} = {long_y, ~long_turn};
      R1: {augend, addend} = above ? {long_top, ~long_mean} : {long_mean, 27'h7FFFFFF};
      T1, HI1: {augend, addend} = {long_y, 27'h7FFFFFF};
      T3, HI3: {augend, addend} = {long_turn, ~long_y};
      T4: {augend, addend, plus} = {long_y, ~long_turn, 1'b0};
      HI4: {augend, addend} = {long_top, ~long_y};
      FO1: {augend, addend} = {long_y, ~long_mean};
      FO5: {augend, addend} = {long_turn, 11'h7FF, ~steps};
      FO6: {augend, addend, plus} = {long_turn, long_mean, 1'b0};
      Z0: {augend, addend} = rises ? {long_mean, ~long_extreme} : {long_extreme, ~long_mean};
      Z1: {augend, addend, plus} = {long_extreme, rises ? ~lead : lead, rises};
      Z2: {augend, addend} = rises ? {long_turn, ~long_mean} : {long_mean, ~long_turn};
      ST0: {augend, addend, plus} = {zero, 27'd1 << COUNT_SHIFT >> 1, 1'b0};
      ST1: {augend, addend, plus} = {off, 11'd0, word_, 1'b0};
      ST2: {augend, addend} = {off, 11'h7FF, ~word_};
      default: ;
    endcase
  end
  wire [15:0] sum_word = sum[26] ? 16'd0 : |sum[25:16] ? 16'd65535 : sum[15:0];

  // Addresses.
  always @* begin
    case (state)
      LOAD, H0: knot_at = item;
      SL: knot_at = next_left > 1 ? next_k + (next_left >> 1) : next_k;
      K1: knot_at = k + 5'd1;
      E2: knot_at = ends_knots || next_left <= 1 ? (next_low ? probe_k + 5'd1 : probe_k) : probe_k + (next_left >> 1);
      default: knot_at = LAST_KNOT >> 1;
    endcase
    case (state)
      LOAD, H0: word_at = item;
      IN0: word_at = ZERO;
      IN1: word_at = ZERO + 1;
      ST0: word_at = UP;
      ST1: word_at = DOWN;
      B2: word_at = TOP;
      B3: word_at = TOP + 1;
      B4: word_at = LIMIT;
      B5: word_at = LIMIT + 1;
      Z0, Z1: word_at = PLACE;
      F0: word_at = er ? SPLIT_SHORT : ALPHA_D;
      A0: word_at = BETA_A;
      A1: word_at = SPLIT_LONG;
      D0, D1, D2, D3, D4: word_at = ALPHA_D;
      D5: word_at = BETA_D;
      default: word_at = GAIN;
    endcase
    case (state)
      L0: point_at = left - 4'd1;
      L2: point_at = goal == FIND && !was_left ? 4'd15 : left;
      WB: point_at = zone == TURNED ? next_left_turns : 4'd15;
      default: point_at = 0;
    endcase
  end
  wire last_item = item == (phase == 1 ? SPLIT_LONG : LAST_KNOT), last_taxel = {1'b0, taxel} == LAST_TAXEL;
  wire last_word = phase == 2 && last_item && last_taxel && falls_;
  task next_word;
    begin
      item <= last_item ? 5'd0 : item + 5'd1;
      if (last_item)
        case (phase)
          0: phase <= 1;
          1: begin
            taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
            if (last_taxel) phase <= 2;
          end
          default: begin
            falls_ <= !falls_;
            if (falls_) taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
            if (last_word) phase <= 0;
          end
        endcase
    end
  endtask

  wire [15:0] counted = in_count ^ FLIP;
  wire [3:0] next_left_turns = (rises ? &mapped : mapped == 0) ? 4'd0 : below + 4'd1 < POINTS ? below + 4'd1 : below - 4'd1;
  reg turned, passed, jumps, moving, fresh, is_known;
  reg below_low, above;
  wire [15:0] step = |m[21:20] || m[19:4] > CEILING ? CEILING : m[19:4];
  wire ends = er ? left == 0 || point[15:0] == X : left == 0 || point[15:0] == 0;
  wire [15:0] next_end_x = !ends ? point[15:0] : er ? X : 16'd0, next_end_u = !ends ? point[31:16] : er ? Y : 16'd0;
  wire passes = looks_left && left >= 2 && (er ? beyond && v != v_high : past[16]);
  wire crossed = both && room[16];
  wire [15:0] cut_x = under || crossed ? p_x_low : beyond ? p_x_high : v;
  task forget(input knows);
    begin
      mean <= 0;
      extreme <= 0;
      steps <= CEILING;
      samples <= 0;
      extreme_samples <= 0;
      spikes <= 0;
      below <= 0;
      rises <= 1;
      begun <= knows;
      not_known <= !knows;
      searched <= 0;
      has_here <= 0;
      has_there <= 0;
    end
  endtask
  task take_extreme;
    begin
      extreme <= mean;
      extreme_samples <= samples;
      has_there <= 0;
    end
  endtask
  task map(input [6:0] to);
    begin
      state <= takes_low || takes_high || takes_v ? to : DIV;
      after <= to;
    end
  endtask
  task seek(input [15:0] what, input by_x, input [6:0] to);
    begin
      unsought <= ~what;
      on_x <= by_x;
      found <= to;
      k <= 0;
      left_knots <= LAST_KNOT;
      state <= SL;
    end
  endtask
  task search(input [1:0] why);
    begin
      goal <= why;
      er <= rises;
      left <= below;
      state <= L0;
    end
  endtask
  assign load_ready = state == LOAD;
  assign in_ready = state == IDLE;
  assign out_valid = state == OUT;
  assign out_pressure = pressure;
  assign out_status = status | {1'b0, not_known && !status[3], 5'd0};

  always @(posedge clk) begin
    if (state == DIV) begin
      rest <= bit_0[15:0];
      quotient <= {quotient[11:0], bit_3[16], bit_2[16], bit_1[16], bit_0[16]};
      turns <= turns + 2'd1;
    end else if (state != MUL) begin
      rest <= past[15:0];
      over <= ~room[15:0];
      rise <= climb[15:0];
      mapped <= takes_high ? to_high : takes_v ? v : to_low;
      if (state == MAP || state == A2 || state == A5 || state == A7 || state == D3) mapped <= mapping[16:1];
      turns <= 0;
    end
    case (state)
      LOAD:
      if (load_valid) begin
        next_word;
        if (last_word) state <= H0;
      end
      H0: state <= H1;
      H1: begin
        hash <= hash ^ {16'd0, phase == 0 ? x_knot : phase == 1 ? word_ : pattern};
        state <= H2;
      end
      H2: state <= H3;
      H3: begin  // times 2^24 + 0x193
        hash[15:0] <= whole[15:0];
        share <= whole[31:16] + {hash[7:0], 8'd0};
        state <= H4;
      end
      H4: begin
        hash[31:16] <= share + whole[15:0];
        next_word;
        state <= last_word ? IN0 : H0;
      end
      IN0: state <= IN1;
      IN1: begin
        zero[15:0] <= word_;
        state <= IN2;
      end
      IN2: begin
        zero[26:16] <= word_[10:0];
        is_known <= 0;
        state <= ST0;
      end
      ST0: begin
        forget(is_known);
        pressure <= 0;
        off <= sum >>> COUNT_SHIFT;
        state <= ST1;
      end
      ST1: begin
        limit_high <= sum_word;
        state <= ST2;
      end
      ST2: state <= ST3;
      ST3:
      if (loaded) state <= OUT;
      else begin
        taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
        loaded <= last_taxel;
        state <= last_taxel ? IDLE : IN0;
      end

      IDLE: begin
        count <= counted;
        event_ <= in_event;
        if (in_valid) begin
          if (taxel == 0) gap <= in_event != 1 ? 4'd0 : gap <= LONGEST_GAP ? gap + 4'd1 : gap;
          state <= B1;
        end
      end
      B1: begin
        {mean, extreme, steps, samples, extreme_samples, spikes, below, pressure} <= kept[101:6];
        {rises, begun, not_known, searched, has_here, has_there} <= kept[5:0];
        zero <= kept_zero;
        off <= sum;
        below_low <= past[16];
        above <= beyond && v != v_high;
        status <= 8;
        state <= word_ == 0 ? OUT : B2;
      end
      B2: state <= B3;
      B3: begin
        top[15:0] <= word_;
        y <= m[25:0];
        state <= B4;
      end
      B4: begin
        top[25:16] <= word_[9:0];
        state <= B5;
      end
      B5: begin
        off[15:0] <= word_;  // the limit
        is_known <= 0;
        status <= 64;
        case (event_)
          0: state <= below_low || above ? R1 : B7;
          1: begin
            steps <= CEILING;
            state <= gap > LONGEST_GAP ? ST0 : OUT;
          end
          default: state <= T1;
        endcase
      end
      T1: begin
        off <= sum;
        state <= T2;
      end
      T2: begin
        turn <= m[25:0];
        state <= T3;
      end
      T3: begin
        off <= sum;
        turn <= ~turn;
        state <= T4;
      end
      T4: begin
        off[26] <= off[26] || sum[26];
        state <= T5;
      end
      T5: begin
        is_known <= !off[26];
        if (!off[26]) zero <= as_zero;
        status <= off[26] ? 7'd4 : 7'd1;
        state <= ST0;
      end
      B7: begin
        off[26:16] <= word_[10:0];
        state <= B6;
      end
      B6: begin
        turn <= sum[25:0];
        state <= CL;
      end
      CL: begin
        if (sum[26]) y <= off[25:0];
        spikes <= 0;
        status <= 1;
        state <= CL2;
      end
      CL2: begin
        if (sum[26] && y[25]) y <= turn;
        state <= HI1;
      end
      R1: begin  // how far the mean lies before the end
        off <= sum;
        status <= 4;
        state <= R2;
      end
      R2:
      if (!(begun && near_band) && spikes < LONGEST_SPIKE) begin
        spikes <= spikes + 2'd1;
        state <= OUT;
      end else begin
        y <= begun && off[26] ? mean : above ? top : 26'sd0;
        state <= HI1;
      end
      HI1: begin
        off <= sum;
        state <= not_known ? HI2 : FO1;
      end
      HI2: begin
        turn <= m[25:0];
        low_zone <= near_band;
        state <= HI3;
      end
      HI3: begin
        off <= sum;
        state <= HI4;
      end
      HI4: begin
        if (at_zero) forget(1'b1);
        off <= sum;
        state <= at_zero ? FO1 : HI5;
      end
      HI5: begin
        if (near_band) not_known <= 0;
        state <= FO1;
      end

      FO1: begin
        off <= sum;
        moving <= steps > MOVING;
        begun <= 1;
        fresh <= !begun;
        if (!begun) mean <= y;
        state <= begun ? FO2 : Z0;
      end
      FO2: begin
        jumps <= exceeds;
        state <= FO3;
      end
      FO3: begin
        if (moving || jumps) samples <= 0;
        else if (samples != LONGEST_MEAN) samples <= samples + 3'd1;
        state <= FO4;
      end
      FO4: begin
        turn <= {10'd0, step};
        state <= FO5;
      end
      FO5: begin
        off <= sum;
        turn <= m[25:0];
        state <= FO6;
      end
      FO6: begin
        mean <= moving || jumps ? y : sum[25:0];
        state <= Z0;
      end
      Z0: begin
        if (!fresh) steps <= steps + m[15:0];
        passed <= sum[26] && !fresh;
        state <= Z1;
      end
      Z1: begin
        turn <= sum[25:0];
        state <= Z2;
      end
      Z2: begin  // how far behind the turn the mean is
        off <= sum;
        goal <= HERE;
        u <= mean[25] ? 16'd0 : m[19:4];
        state <= Z3;
      end
      Z3: begin
        turn_u <= turn[25] ? 16'd0 : m[19:4];
        turned <= passed && behind;
        state <= Z4;
      end
      Z4: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        along_u <= turned ? turn_u : u;
        state <= turned ? W1 : Q1;
        if (turned) zone <= TURNED;
        else if (passed && (!noisy || behind)) begin
          zone <= behind ? BACK : HELD;
          if (behind) begin
            goal <= FIND;
            state <= Z5;
          end
        end else begin
          take_extreme;
          zone <= AHEAD;
        end
      end
      Z5: state <= Q0;
      Q0: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        goal <= HERE;
        state <= Q1;
      end
      Q1: begin
        looks_left <= zone == AHEAD;
        if (between && (zone == BACK ? has_there : has_here)) map(AL2);
        else if (zone == BACK) begin
          along_u <= turn_u;
          state <= W0;
        end else search(HERE);
      end
      W0: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        state <= W1;
      end
      W1: begin
        looks_left <= 0;
        if (between && has_here) map(WB);
        else search(WAY);
      end
      WA: map(WB);
      WB: begin
        along_u <= u;
        left <= next_left_turns;
        er <= !rises;
        looks_left <= 1;
        was_left <= 0;
        goal <= FIND;
        if (zone == TURNED) begin
          goal <= HERE;
          below <= next_left_turns;
          rises <= !rises;
          searched <= 0;
          has_here <= 0;
          take_extreme;
        end
        state <= L0;
      end

      L0: state <= L1;
      L1: begin
        if (er) {hi_u, hi_x} <= {next_end_u, next_end_x};
        else {lo_u, lo_x} <= {next_end_u, next_end_x};
        state <= L2;
      end
      L2:
      if (passes) begin
        left <= left - 4'd2;
        was_left <= 1;
        state <= L0;
      end else state <= F0;
      F0: begin
        if (er) {lo_u, lo_x} <= {point[31:16] > Y ? Y : point[31:16], point[15:0]};
        else {hi_u, hi_x} <= point;
        known <= searched && (goal == WAY || (goal == HERE && left == below));
        if (goal == HERE && left != below) begin
          below <= left;
          searched <= 0;
        end
        negative <= 0;
        both <= 0;
        state <= er ? A0 : D0;
      end
      A0: begin
        if (known) {split, turn_x, reach} <= {kept_split, kept_turn_x, kept_reach};
        at_e <= word_;
        outer <= EXACT_OUTER && lo_x <= NEAR_END;
        state <= A1;
      end
      A1: state <= A2;
      A2: begin
        {negative, share} <= past;
        state <= A3;
      end
      A3: begin
        split_y <= mapped;  // (22)
        if (negative) share <= -share;
        state <= A4;
      end
      A4: state <= A5;
      A5: state <= A6;
      A6: begin
        negative <= 0;
        state <= A7;
      end
      A7: state <= A8;
      A8: begin
        split_x <= mapped;  // (21)
        if (known) state <= OU;
        else seek(split_y, 1'b0, SH1);
      end
      D0: begin
        if (known) {split, turn_x, reach} <= {kept_split, kept_turn_x, kept_reach};
        {low_zone, share} <= {1'b0, hi_u} - (Y - 16'd1228);
        state <= D1;
      end
      D1: begin
        high_zone <= share >= 614;
        state <= D2;
      end
      D2: state <= D3;
      D3: state <= D4;
      D4: begin
        share <= low_zone ? hi_x : high_zone ? X : mapped;
        state <= D5;
      end
      D5: state <= D6;
      D6: begin
        outer <= EXACT_OUTER && X - share <= NEAR_END;
        split_x <= beyond ? hi_x : whole[31:16];  // (14)
        state <= D7;
      end
      D7: begin
        split_y <= whole[31:16];  // (15)
        if (known) state <= OU;
        else seek(split_x, 1'b1, SH1);
      end

      SH1: begin
        split <= mapped;
        if (er) seek(lo_u, 1'b0, SH2);
        else state <= OU;
      end
      SH2: begin
        turn_x <= mapped;
        state <= OU;
      end
      OU: begin
        if (outer && er) split_x <= under ? lo_x : split;
        if (outer && !er) map(OU2);
        else state <= known ? P0 : RE;
      end
      OU2: begin
        split_y <= mapped;
        state <= known ? P0 : RE;
      end
      RE: begin  // (16) to (19), (23) to (26)
        end_above <= !under || at_low;
        if (er ? &hi_x : lo_x == 0) begin
          reach <= er ? Y : 16'd0;
          state <= P0;
        end else if (er ? under : beyond) begin
          reach <= er ? lo_u : hi_u;
          state <= P0;
        end else if (er && beyond) state <= RD;
        else if (er || !under || at_low) map(RX);
        else seek(lo_x, 1'b1, RF);
      end
      RD: map(RX);
      RX: seek(mapped, 1'b1, er ? RG : RF);
      RF: map(RG);
      RG: begin
        reach <= mapped;
        state <= P0;
      end

      P0: begin
        if (goal != FIND) searched <= 1;
        scaled <= !same;
        {p_low, p_high, p_x_low, p_x_high} <= {lo_u, hi_u, lo_x, hi_x};
        flat <= room[16];  // a turn beyond the end
        low_zone <= room[16] && er ? !beyond || v == v_high : under;
        if (under || beyond) state <= P2;
        else if (climb[16] || climb[15:0] == 0) state <= CU;
        else map(P1);
      end
      P2: begin
        if (low_zone) begin
          if (!(flat && er)) p_high <= p_low;
          p_low <= 0;
          p_x_high <= p_x_low;
        end else begin
          if (!(flat && !er)) p_low <= p_high;
          p_high <= 65535;
          p_x_low <= p_x_high;
        end
        state <= CU;
      end
      P1: begin
        upper <= !under || (at_low && !er);
        k <= 0;
        left_knots <= LAST_KNOT;
        {has_low, has_high, ends_knots} <= 0;
        state <= E0;
      end
      SL: begin
        k <= next_k;
        left_knots <= next_left;
        if (next_left <= 1) state <= K1;
      end
      K1: begin
        at_0 <= knot_of;
        at_1 <= knot_to;
        state <= K2;
      end
      K2: map(found);
      // The knots between whose outputs on the curve it lies, by halving: the same as by steps from a guess.
      E0: begin
        {at_e, low_e, high_e} <= {x_knot, under, beyond};
        map(E1);
      end
      E1: map(E2);
      E2: begin
        if (ends_knots ? ends_low : rises_to) begin
          p_low <= mapped;
          {at_0, low_0, high_0} <= {at_e, low_e, high_e};
          has_low <= 1;
        end else begin
          p_high <= mapped;
          {at_1, low_1, high_1} <= {at_e, low_e, high_e};
          has_high <= 1;
        end
        k <= probe_k;
        left_knots <= next_left;
        state <= E0;
        if (ends_knots) state <= EX0;
        else if (next_left <= 1) begin
          ends_knots <= 1;
          ends_low <= !next_low;
          if (next_low && (has_high || !rises_to)) state <= EX0;
        end
      end
      EX0: map(EX1);
      EX1: begin
        p_x_low <= mapped;
        map(EX2);
      end
      EX2: begin
        p_x_high <= mapped;
        if (!under) p_x_low <= lo_x;
        both <= 1;
        state <= CX2;
      end
      CX2: begin
        if (!beyond) p_x_high <= hi_x;
        state <= CU;
      end
      CU: begin  // the output from which another branch goes on ends the piece
        cuts <= left >= 2 && (er ? !beyond : !under);
        state <= CUT;
      end
      CUT: begin
        if (crossed) p_x_high <= p_x_low;
        if (cuts && er) begin
          p_high <= hi_u;
          p_x_high <= cut_x;
        end
        if (cuts && !er) begin
          p_low <= lo_u;
          p_x_low <= cut_x;
        end
        state <= goal == WAY ? WA : AL;
      end
      AL: begin
        if (goal == HERE) has_here <= 1;
        else has_there <= 1;
        map(AL2);
      end
      AL2: begin
        pressure <= mapped;
        state <= OUT;
      end
      DIV: if (turns == 3) state <= MUL;
      MUL: state <= MAP;
      MAP: state <= after;
      OUT:
      if (out_ready) begin
        taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
        state <= IDLE;
      end
      default: state <= LOAD;
    endcase
    if (reset) begin
      state <= LOAD;
      phase <= 0;
      item <= 0;
      falls_ <= 0;
      taxel <= 0;
      gap <= 0;
      hash <= 32'd2166136261;
      loaded <= 0;
    end
  end
endmodule
