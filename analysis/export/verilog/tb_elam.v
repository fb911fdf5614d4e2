// ELAM in integers, one taxel after another: the steps of tb_fixed.h and tb_elam.h, whose names and numbers of equations stand here.
// One product, one restoring divider of twice two bits a cycle; the states stand in tb_steps.vh. Words are loaded in the order of tb_elam_hash and read back for the hash.
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
    output [31:0] hash,
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

  // One bit a state.
  localparam STATES = 113;
  localparam LOAD = 0, H0 = 1, H1 = 2, H2 = 3, IN0 = 4, IN1 = 5, IN2 = 6, ST0 = 7, ST1 = 8, ST2 = 9, ST3 = 10, IDLE = 11,
             B1 = 12, B2 = 13, B3 = 14, B4 = 15, B5 = 16, T1 = 17, T2 = 18, T3 = 19, T4 = 20, T5 = 21, B7 = 22, B6 = 23,
             CL = 24, CL2 = 25, R1 = 26, R2 = 27, HI1 = 28, HI2 = 29, HI3 = 30, HI4 = 31, HI5 = 32, FO1 = 33, FO2 = 34,
             FO3 = 35, FO4 = 36, FO5 = 37, FO6 = 38, Z0 = 39, Z1 = 40, Z2 = 41, Z3 = 42, Z4 = 43, Z5 = 44, Q0 = 45, Q1 = 46,
             Q2 = 47, W0 = 48, W1 = 49, W2 = 50, WA = 51, WB = 52, L0 = 53, L1 = 54, L2 = 55, L3 = 56, F0 = 57, A0 = 58,
             A1 = 59, A2 = 60, A3 = 61, A4 = 62, A5 = 63, A6 = 64, A7 = 65, A8 = 66, D0 = 67, D1 = 68, D2 = 69, D3 = 70,
             D5 = 71, D6 = 72, D7 = 73, SH1 = 74, SH2 = 75, OU = 76, OU2 = 77, RE = 78, RE2 = 79, RD = 80, RX = 81, RF = 82,
             RG = 83, P0 = 84, P3 = 85, P2 = 86, P1 = 87, PR = 88, PT = 89, PS = 90, SL = 91, K1 = 92, K2 = 93, E0 = 94,
             E1 = 95, E2 = 96, E3 = 97, EX0 = 98, EX1 = 99, EX2 = 100, CX2 = 101, CU = 102, CUT = 103, CUT2 = 104, AL = 105,
             AL2 = 106, DIV0 = 107, DIV = 108, CEIL = 109, MUL = 110, MAP = 111, OUT = 112;
  function [STATES-1:0] only(input integer number);
    only = {{STATES - 1{1'b0}}, 1'b1} << number;
  endfunction
  reg [STATES-1:0] state, after;  // `after` the map

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
  reg [15:0] taken;  // of a negative factor
  /* verilator lint_off UNUSEDSIGNAL */
  wire [26:0] m = whole_high + {11'd0, whole[31:16]} - {taken, 11'd0};  // M(factor, by)
  /* verilator lint_on UNUSEDSIGNAL */
  always @(posedge clk) begin
    whole <= product_low;
    whole_high <= product_high;
    taken <= factor[26] ? by : 16'd0;
  end

  // Memories.
  reg [1:0] phase;  // of the loader: x, words, patterns
  reg [31:0] crc;
  reg [4:0] item;
  reg falls_;
  wire loads = state[LOAD] && load_valid, hashes = state[LOAD] || state[H0] || state[H1];
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
  // One threshold or factor of the rule at a time, a state ahead.
  wire noisy = samples == LONGEST_MEAN && extreme_samples != LONGEST_MEAN;  // came to rest so near that the extreme was noise
  wire [2:0] more = moving || jumps ? 3'd0 : samples != LONGEST_MEAN ? samples + 3'd1 : samples;
  wire [2:0] fewer = samples < extreme_samples ? samples : extreme_samples;
  reg [5:0] rule_at;
  reg [15:0] rule;
  always @* begin
    (* parallel_case *) case (1'b1)
      state[FO1]: rule_at = {JUMP, samples};
      state[FO2]: rule_at = {STEP_SHARE, samples};
      state[FO3]: rule_at = {PART, more};
      state[Z0]: rule_at = {LEAD, extreme_samples};
      state[Z2]: rule_at = {BAND, fewer};
      state[Z3]: rule_at = noisy ? REST : {HOLD, fewer};
      state[B5]: rule_at = TOO_FAR;
      state[CL2], state[R2]: rule_at = NEAR_TOP;
      state[FO5]: rule_at = WINDOW;
      state[D0]: rule_at = SPLIT_FADE;
      default: rule_at = WIDEST_BAND;
    endcase
  end
  always @(posedge clk) rule <= rules[{2'd0, rule_at}];
  wire [10:0] threshold = rule[10:0];
  wire exceeds = far || size > threshold, behind = !off[26] && exceeds;
  wire near_band = !behind;
  wire at_zero = low_zone || !off[26];  // in HI4, where a history that is not known begins anew
  wire puts_point = state[WB] || (state[HI4] && at_zero) || state[ST3], forgets_points = !state[WB];
  tb_memory #(16, 14, "huge") points_x (clk, puts_point, {2'd0, taxel, point_at}, forgets_points ? 16'd0 : mapped, point[15:0]);
  tb_memory #(16, 14, "huge") points_u (clk, puts_point, {2'd0, taxel, point_at}, forgets_points ? 16'd0 : along_u, point[31:16]);

  wire [101:0] kept;
  tb_memory #(102, 8, "block") core (clk, state[OUT] || state[ST3], taxel,
    {mean, extreme, steps, samples, extreme_samples, spikes, below, pressure, rises, begun, not_known, searched, has_here,
     has_there}, kept);
  wire [26:0] kept_zero;
  wire [15:0] kept_high, kept_low;
  tb_memory #(59, 8, "block") limits (clk, state[ST3], taxel, {zero, limit_high, limit}, {kept_zero, kept_high, kept_low});
  reg [15:0] p_low, p_high, p_x_low, p_x_high;  // the piece
  wire [63:0] kept_piece;
  reg [1:0] goal;
  wire is_there = goal == FIND;
  tb_memory #(64, 9, "block") pieces (clk, state[AL], {is_there, taxel}, {p_low, p_high, p_x_low, p_x_high}, kept_piece);
  reg known;
  reg [15:0] split, turn_x, reach;  // tb_elam_shape
  wire [15:0] kept_split, kept_turn_x, kept_reach;
  tb_memory #(48, 8, "block") shapes (clk, state[P0] && !known && goal != FIND, taxel, {split, turn_x, reach},
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
  reg on_x, rounds_up, remains;  // of the map: both roundings up; the last division left something
  reg [STATES-1:0] found;
  wire [4:0] half = left_knots >> 1, next_left = left_knots - half;
  wire [15:0] knot_of = on_x ? x_knot : pattern, knot_to = on_x ? pattern : x_knot;
  /* verilator lint_off UNUSEDSIGNAL */
  wire [17:0] compared = {1'b0, knot_of, 1'b1} + {1'b0, unsought, strict};  // carries: the knot is above, or `strict` and the same
  /* verilator lint_on UNUSEDSIGNAL */
  wire [4:0] next_k = compared[17] ? k : k + half;
  reg both, low_0, high_0, low_1, high_1, strict;
  reg [15:0] at_0, at_1;

  // tb_map and tb_along.
  reg [15:0] v, v_low, v_high, to_low, to_high;
  reg [15:0] rest, over, rise, quotient, mapped;
  reg [17:0] over_thrice;
  reg [1:0] turns;
  wire goes_along = state[W1] || state[WA] || state[Q1] || state[AL], is_x = state[EX0] || state[EX1];
  wire [16:0] past = {1'b0, v} - {1'b0, v_low}, room = {1'b0, v_high} - {1'b0, v_low}, climb = {1'b0, to_high} - {1'b0, to_low};
  wire at_low = v == v_low, under = past[16] || at_low, beyond = v >= v_high, between = !under && !beyond, same = v_low == to_low && v_high == to_high;
  wire x_under = state[EX0] ? low_0 : low_1, x_beyond = state[EX0] ? high_0 : high_1, x_same = !er && y_low == 0;
  reg takes_low, takes_high, takes_v;
  // A cycle later, beside the first of the divider: what is decided by comparing.
  reg is_taken, is_high, is_v, is_under, is_beyond, is_between, falls_off, passes;
  wire divides = state[DIV0] || state[Q2] || state[W2] || state[RE2] || state[P3];
  wire moves = state[A1] || state[A4] || state[A6] || state[D2] || state[P1];
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
    if ((state[E1] || state[E3]) && !scaled) begin
      takes_low = 0;
      takes_high = 0;
      takes_v = 1;
    end
  end
  /* verilator lint_off UNUSEDSIGNAL */  // of carries
  wire [15:0] addition = divides ? (is_high ? rise : is_v ? rest : 16'd0) : negative ? ~whole[31:16] : whole[31:16];
  wire [16:0] mapping = {mapped, 1'b1} + {addition, !divides && (negative || (rounds_up && |whole[15:0]))};
  function [17:0] divided(input [15:0] from, input [15:0] less, input [17:0] less_thrice);  // two bits of the quotient, and what is left
    reg [19:0] once, twice, thrice;
    reg [1:0] digit;
    begin
      once = {1'b0, from, 3'b001} + {3'b011, less, 1'b1};
      twice = {1'b0, from, 3'b001} + {2'b01, less, 2'b11};
      thrice = {1'b0, from, 3'b001} + {1'b0, less_thrice, 1'b1};
      digit = {twice[19], thrice[19] || (once[19] && !twice[19])};
      case (digit)
        0: divided = {digit, from[13:0], 2'b00};
        1: divided = {digit, once[16:1]};
        2: divided = {digit, twice[16:1]};
        3: divided = {digit, thrice[16:1]};
      endcase
    end
  endfunction
  /* verilator lint_on UNUSEDSIGNAL */
  wire [17:0] digit_1 = divided(rest, over, over_thrice), digit_0 = divided(digit_1[15:0], over, over_thrice);
  always @* begin
    {v, v_low, v_high, to_low, to_high} = 80'bx;
    (* parallel_case *) case (1'b1)
      state[K2]: {v, v_low, v_high, to_low, to_high} = {~unsought, at_0, knot_of, at_1, knot_to};
      state[OU]: {v, v_low, v_high, to_low, to_high} = {split, er ? lo_x : 16'd0, Y, 16'd0, hi_u};
      state[RE]: {v, v_low, v_high, to_low, to_high} =
          er ? {hi_x, lo_x, split_x, turn_x, split} : {lo_x, split_x, hi_x, split_x, X};
      state[RD]: {v, v_low, v_high, to_low, to_high} = {hi_x, split_x, X, split, X};
      state[RF]: {v, v_low, v_high, to_low, to_high} = end_above ? {mapped, split, Y, split_y, hi_u} : {mapped, 16'd0, split, 16'd0, split_y};
      state[P0], state[PR], state[L2]: {v, v_low, v_high, to_low, to_high} = {along_u, lo_u, hi_u, of_low, of_high};
      state[PT]: {v, v_low, v_high, to_low, to_high} = {mapped, y_low, y_high, first, last};
      state[E0], state[E2]: {v, v_low, v_high, to_low, to_high} = {pattern, first, last, y_low, y_high};
      state[E1], state[E3]: {v, v_low, v_high, to_low, to_high} = {mapped, of_low, of_high, lo_u, hi_u};
      state[EX0], state[EX1]:
        {v, v_low, v_high, to_low, to_high} = {state[EX0] ? at_0 : at_1, er ? own_low : part_low, er ? own_high : X, part_low, part_high};
      state[W1], state[WA], state[Q1], state[AL]: {v, v_low, v_high, to_low, to_high} = {along_u, p_low, p_high, p_x_low, p_x_high};
      state[A0]: {v_low, v_high} = {lo_u, Y};
      state[D0]: {v, v_low} = {hi_u, Y - 16'd1228};
      state[A2]: {v, v_low} = {word_, at_0};
      state[D6]: {v, v_high} = {whole[31:16], hi_x};
      state[P1]: {v, v_low} = {mapped, split_y};
      state[CU]: {v, v_low, v_high} = {er ? hi_u : lo_u, p_low, p_high};
      state[B1]: {v, v_low, v_high} = {count, kept_low, kept_high};
      state[A1], state[SH1]: v = lo_u;
      state[A8]: v = split_y;
      state[D7]: v = split_x;
      state[RX], state[PS]: v = mapped;
      state[RE2]: v = lo_x;
      state[A4]: v = at_0;
      state[EX2], state[CX2], state[CUT], state[CUT2], state[A6], state[D2]: {v, v_low, v_high} = {state[EX2] || state[A6] || ((state[CUT] || state[CUT2]) && !er) ? lo_x : hi_x, p_x_low, p_x_high};
      default: ;
    endcase
  end

  // What is multiplied.
  wire [10:0] cut = far ? 11'd2047 : size;
  wire [26:0] mean_shifted = {mean[25], mean} << PLACE_SHIFT, turn_shifted = {turn[25], turn} << PLACE_SHIFT;
  always @* begin
    factor = 27'bx;
    by = 16'bx;
    (* parallel_case *) case (1'b1)
      state[B2]: {factor, by} = {off, word_};
      state[T1]: {factor, by} = {top[25], top, rule};
      state[HI1]: {factor, by} = {top[25], top, rule};
      state[FO2]: {factor, by} = {16'd0, cut, 5'd0, cut};
      state[FO3]: {factor, by} = {5'd0, whole[21:0], rule};
      state[FO4]: {factor, by} = {off, rule};
      state[FO6]: {factor, by} = {off, rule};
      state[Z1]: {factor, by} = {mean_shifted, word_};
      state[Z2]: {factor, by} = {turn_shifted, word_};
      state[A1]: {factor, by} = {11'd0, ~over, word_};
      state[A4]: {factor, by} = {11'd0, ~lo_x, share};
      state[A6]: {factor, by} = {11'd0, ~lo_x, mapped};
      state[D1]: {factor, by} = {11'd0, share, rule};
      state[D2]: {factor, by} = {11'd0, ~hi_x, whole[15:0]};
      state[D5]: {factor, by} = {11'd0, mapped, word_};
      state[D6]: {factor, by} = {11'd0, hi_u, word_};
      state[MUL]: {factor, by} = {11'd0, rise, quotient};
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
  wire [26:0] lead = {19'd0, rule[7:0]};
  always @* begin
    augend = 27'bx;
    addend = 27'bx;
    plus = 1;
    (* parallel_case *) case (1'b1)
      state[B1]: {augend, addend} = {as_zero, ~kept_zero};
      state[B6]: {augend, addend} = {long_top, ~off};
      state[CL]: {augend, addend} = {off, ~long_y};
      state[CL2]: {augend, addend} = {long_y, ~long_turn};
      state[R1]: {augend, addend} = above ? {long_top, ~long_mean} : {long_mean, 27'h7FFFFFF};
      state[T1], state[HI1]: {augend, addend} = {long_y, 27'h7FFFFFF};
      state[T3], state[HI3]: {augend, addend} = {long_turn, ~long_y};
      state[T4]: {augend, addend, plus} = {long_y, ~long_turn, 1'b0};
      state[HI4]: {augend, addend} = {long_top, ~long_y};
      state[FO1]: {augend, addend} = {long_y, ~long_mean};
      state[FO5]: {augend, addend} = {long_turn, 11'h7FF, ~steps};
      state[FO6]: {augend, addend, plus} = {long_turn, long_mean, 1'b0};
      state[Z0]: {augend, addend} = rises ? {long_mean, ~long_extreme} : {long_extreme, ~long_mean};
      state[Z1]: {augend, addend, plus} = {long_extreme, rises ? ~lead : lead, rises};
      state[Z2]: {augend, addend} = rises ? {long_turn, ~long_mean} : {long_mean, ~long_turn};
      state[ST0]: {augend, addend, plus} = {zero, 27'd1 << COUNT_SHIFT >> 1, 1'b0};
      state[ST1]: {augend, addend, plus} = {off, 11'd0, word_, 1'b0};
      state[ST2]: {augend, addend} = {off, 11'h7FF, ~word_};
      default: ;
    endcase
  end
  wire [15:0] limit = turn[25] ? 16'd0 : |turn[24:16] ? 16'd65535 : turn[15:0];

  // Addresses.
  always @* begin
    (* parallel_case *) case (1'b1)
      state[LOAD], state[H0]: knot_at = item;
      state[SL]: knot_at = next_left > 1 ? next_k + (next_left >> 1) : next_k;
      state[K1], state[DIV0], state[MAP]: knot_at = k + 5'd1;
      default: knot_at = LAST_KNOT >> 1;
    endcase
    (* parallel_case *) case (1'b1)
      state[LOAD], state[H0]: word_at = item;
      state[IN0]: word_at = ZERO;
      state[IN1]: word_at = ZERO + 1;
      state[ST0]: word_at = UP;
      state[ST1]: word_at = DOWN;
      state[B2]: word_at = TOP;
      state[B3]: word_at = TOP + 1;
      state[B4]: word_at = LIMIT;
      state[B5]: word_at = LIMIT + 1;
      state[Z0], state[Z1]: word_at = PLACE;
      state[F0]: word_at = er ? SPLIT_SHORT : ALPHA_D;
      state[A0]: word_at = BETA_A;
      state[A1]: word_at = SPLIT_LONG;
      state[D0], state[D1], state[D2], state[D3]: word_at = ALPHA_D;
      state[D5]: word_at = BETA_D;
      default: word_at = GAIN;
    endcase
    (* parallel_case *) case (1'b1)
      state[L0]: point_at = left - 4'd1;
      state[L3]: point_at = passes ? left - 4'd3 : goal == FIND && !was_left ? 4'd15 : left;
      state[WB]: point_at = zone == TURNED ? next_left_turns : 4'd15;
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
  reg turned, passed, jumps, moving, renews, fresh, is_known;
  reg below_low, above;
  wire [15:0] step = |m[21:20] || m[19:4] > CEILING ? CEILING : m[19:4];
  wire ends = er ? left == 0 || point[15:0] == X : left == 0 || point[15:0] == 0;
  wire [15:0] next_end_x = !ends ? point[15:0] : er ? X : 16'd0, next_end_u = !ends ? point[31:16] : er ? Y : 16'd0;
  reg crossed;
  wire [15:0] cut_x = is_under || crossed ? p_x_low : is_beyond ? p_x_high : v;
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
  task map(input [STATES-1:0] to);
    begin
      state <= only(DIV0);
      after <= to;
    end
  endtask
  task go_on;
    state <= is_taken ? after : only(DIV);
  endtask
  task seek(input by_x, input [STATES-1:0] to);  // of v
    begin
      unsought <= ~v;
      strict <= 0;
      on_x <= by_x;
      found <= to;
      k <= 0;
      left_knots <= LAST_KNOT;
      state <= only(SL);
    end
  endtask
  task search(input [1:0] why);
    begin
      goal <= why;
      er <= rises;
      left <= below;
      state <= only(L0);
    end
  endtask
  assign hash = ~crc;
  assign load_ready = state[LOAD];
  assign in_ready = state[IDLE];
  assign out_valid = state[OUT];
  assign out_pressure = pressure;
  assign out_status = status | {1'b0, not_known && !status[3], 5'd0};

  `include "tb_steps.vh"
endmodule
