// What tb_elam does in each of its states, in the order of tb_fixed.h and tb_elam.h; included there.
  always @(posedge clk) begin
    if (state[DIV] || divides) begin
      rest <= digit_0[15:0];
      quotient <= {quotient[11:0], digit_1[17:16], digit_0[17:16]};
      turns <= turns + 2'd1;
    end else if (!state[MUL] && !state[CEIL]) begin
      rest <= past[15:0];
      over <= ~room[15:0];
      over_thrice <= ~({2'b00, room[15:0]} + {1'b0, room[15:0], 1'b0});
      rise <= climb[15:0];
      mapped <= moves ? v : to_low;
      turns <= 0;
      {is_taken, is_high, is_v} <= {takes_low || takes_high || takes_v, takes_high, takes_v};
      {is_under, is_beyond, is_between, falls_off} <= {under, beyond, between, climb[16]};
      passes <= looks_left && left >= 2 && (er ? beyond && v != v_high : past[16]);
    end
    if (divides || state[MAP] || state[A2] || state[A5] || state[A7]) mapped <= mapping[16:1];
    if (state[D3]) mapped <= low_zone ? mapped : high_zone ? X : mapping[16:1];
    (* parallel_case *) case (1'b1)
      state[LOAD]:
      if (load_valid) begin
        next_word;
        if (last_word) state <= only(H0);
      end
      state[H0]: state <= only(H1);
      state[H1]: begin
        crc <= crc ^ {16'd0, phase == 0 ? x_knot : phase == 1 ? word_ : pattern};
        left <= 0;
        state <= only(H2);
      end
      state[H2]: begin  // CRC-32, a bit a cycle
        crc <= {1'b0, crc[31:1]} ^ (crc[0] ? 32'hEDB88320 : 32'd0);
        left <= left + 4'd1;
        if (&left) begin
          next_word;
          state <= last_word ? only(IN0) : only(H0);
        end
      end
      state[IN0]: state <= only(IN1);
      state[IN1]: begin
        zero[15:0] <= word_;
        state <= only(IN2);
      end
      state[IN2]: begin
        zero[26:16] <= word_[10:0];
        is_known <= 0;
        state <= only(ST0);
      end
      state[ST0]: begin
        forget(is_known);
        pressure <= 0;
        off <= sum >>> COUNT_SHIFT;
        state <= only(ST1);
      end
      state[ST1]: begin
        turn <= sum[25:0];
        state <= only(ST2);
      end
      state[ST2]: begin
        limit_high <= limit;
        turn <= sum[25:0];
        state <= only(ST3);
      end
      state[ST3]:
      if (loaded) state <= only(OUT);
      else begin
        taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
        loaded <= last_taxel;
        state <= last_taxel ? only(IDLE) : only(IN0);
      end

      state[IDLE]: begin
        count <= counted;
        event_ <= in_event;
        if (in_valid) begin
          if (taxel == 0) gap <= in_event != 1 ? 4'd0 : gap <= LONGEST_GAP ? gap + 4'd1 : gap;
          state <= only(B1);
        end
      end
      state[B1]: begin
        {mean, extreme, steps, samples, extreme_samples, spikes, below, pressure} <= kept[101:6];
        {rises, begun, not_known, searched, has_here, has_there} <= kept[5:0];
        zero <= kept_zero;
        off <= sum;
        below_low <= past[16];
        above <= beyond && v != v_high;
        status <= 8;
        state <= word_ == 0 ? only(OUT) : only(B2);
      end
      state[B2]: state <= only(B3);
      state[B3]: begin
        top[15:0] <= word_;
        y <= m[25:0];
        state <= only(B4);
      end
      state[B4]: begin
        top[25:16] <= word_[9:0];
        state <= only(B5);
      end
      state[B5]: begin
        off[15:0] <= word_;  // the limit
        is_known <= 0;
        status <= 64;
        case (event_)
          0: state <= below_low || above ? only(R1) : only(B7);
          1: begin
            steps <= CEILING;
            state <= gap > LONGEST_GAP ? only(ST0) : only(OUT);
          end
          default: state <= only(T1);
        endcase
      end
      state[T1]: begin
        off <= sum;
        state <= only(T2);
      end
      state[T2]: begin
        turn <= m[25:0];
        state <= only(T3);
      end
      state[T3]: begin
        off <= sum;
        turn <= ~turn;
        state <= only(T4);
      end
      state[T4]: begin
        off[26] <= off[26] || sum[26];
        state <= only(T5);
      end
      state[T5]: begin
        is_known <= !off[26];
        if (!off[26]) zero <= as_zero;
        status <= off[26] ? 7'd4 : 7'd1;
        state <= only(ST0);
      end
      state[B7]: begin
        off[26:16] <= word_[10:0];
        state <= only(B6);
      end
      state[B6]: begin
        turn <= sum[25:0];
        state <= only(CL);
      end
      state[CL]: begin
        if (sum[26]) y <= off[25:0];
        spikes <= 0;
        status <= 1;
        state <= only(CL2);
      end
      state[CL2]: begin
        if (sum[26] && y[25]) y <= turn;
        state <= only(HI1);
      end
      state[R1]: begin  // how far the mean lies before the end
        off <= sum;
        status <= 4;
        state <= only(R2);
      end
      state[R2]:
      if (!(begun && near_band) && spikes < LONGEST_SPIKE) begin
        spikes <= spikes + 2'd1;
        state <= only(OUT);
      end else begin
        y <= begun && off[26] ? mean : above ? top : 26'sd0;
        state <= only(HI1);
      end
      state[HI1]: begin
        off <= sum;
        state <= not_known ? only(HI2) : only(FO1);
      end
      state[HI2]: begin
        turn <= m[25:0];
        low_zone <= near_band;
        state <= only(HI3);
      end
      state[HI3]: begin
        off <= sum;
        state <= only(HI4);
      end
      state[HI4]: begin
        if (at_zero) forget(1'b1);
        off <= sum;
        state <= at_zero ? only(FO1) : only(HI5);
      end
      state[HI5]: begin
        if (near_band) not_known <= 0;
        state <= only(FO1);
      end

      state[FO1]: begin
        off <= sum;
        moving <= steps > MOVING;
        begun <= 1;
        fresh <= !begun;
        if (!begun) mean <= y;
        state <= begun ? only(FO2) : only(Z0);
      end
      state[FO2]: begin
        jumps <= exceeds;
        state <= only(FO3);
      end
      state[FO3]: begin
        samples <= more;
        renews <= moving || jumps;
        state <= only(FO4);
      end
      state[FO4]: begin
        turn <= {10'd0, step};
        state <= only(FO5);
      end
      state[FO5]: begin
        off <= sum;
        turn <= m[25:0];
        state <= only(FO6);
      end
      state[FO6]: begin
        mean <= renews ? y : sum[25:0];
        state <= only(Z0);
      end
      state[Z0]: begin
        if (!fresh) steps <= steps + m[15:0];
        passed <= sum[26] && !fresh;
        state <= only(Z1);
      end
      state[Z1]: begin
        turn <= sum[25:0];
        state <= only(Z2);
      end
      state[Z2]: begin  // how far behind the turn the mean is
        off <= sum;
        goal <= HERE;
        u <= mean[25] ? 16'd0 : m[19:4];
        state <= only(Z3);
      end
      state[Z3]: begin
        turn_u <= turn[25] ? 16'd0 : m[19:4];
        turned <= passed && behind;
        state <= only(Z4);
      end
      state[Z4]: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        along_u <= turned ? turn_u : u;
        state <= turned ? only(W1) : only(Q1);
        if (turned) zone <= TURNED;
        else if (passed && (!noisy || behind)) begin
          zone <= behind ? BACK : HELD;
          if (behind) begin
            goal <= FIND;
            state <= only(Z5);
          end
        end else begin
          take_extreme;
          zone <= AHEAD;
        end
      end
      state[Z5]: state <= only(Q0);
      state[Q0]: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        goal <= HERE;
        state <= only(Q1);
      end
      state[Q1]: begin
        looks_left <= zone == AHEAD;
        after <= only(AL2);
        state <= only(Q2);
      end
      state[Q2]: begin
        if (is_between && (zone == BACK ? has_there : has_here)) go_on;
        else if (zone == BACK) begin
          along_u <= turn_u;
          state <= only(W0);
        end else search(HERE);
      end
      state[W0]: begin
        {p_low, p_high, p_x_low, p_x_high} <= kept_piece;
        state <= only(W1);
      end
      state[W1]: begin
        looks_left <= 0;
        after <= only(WB);
        state <= only(W2);
      end
      state[W2]: begin
        if (is_between && has_here) go_on;
        else search(WAY);
      end
      state[WA]: map(only(WB));
      state[WB]: begin
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
        state <= only(L0);
      end

      state[L0]: state <= only(L1);
      state[L1]: begin
        if (er) {hi_u, hi_x} <= {next_end_u, next_end_x};
        else {lo_u, lo_x} <= {next_end_u, next_end_x};
        state <= only(L2);
      end
      state[L2]: state <= only(L3);
      state[L3]:
      if (passes) begin
        left <= left - 4'd2;
        was_left <= 1;
        state <= only(L1);
      end else state <= only(F0);
      state[F0]: begin
        if (er) {lo_u, lo_x} <= {point[31:16] > Y ? Y : point[31:16], point[15:0]};
        else {hi_u, hi_x} <= point;
        known <= searched && (goal == WAY || (goal == HERE && left == below));
        if (goal == HERE && left != below) begin
          below <= left;
          searched <= 0;
        end
        {negative, rounds_up, both} <= 0;
        state <= er ? only(A0) : only(D0);
      end
      state[A0]: begin
        if (known) {split, turn_x, reach} <= {kept_split, kept_turn_x, kept_reach};
        at_0 <= word_;
        outer <= EXACT_OUTER && lo_x <= NEAR_END;
        state <= only(A1);
      end
      state[A1]: state <= only(A2);
      state[A2]: begin
        {negative, share} <= past;
        state <= only(A3);
      end
      state[A3]: begin
        split_y <= mapped;  // (22)
        if (negative) share <= -share;
        state <= only(A4);
      end
      state[A4]: state <= only(A5);
      state[A5]: state <= only(A6);
      state[A6]: begin
        negative <= 0;
        state <= only(A7);
      end
      state[A7]: state <= only(A8);
      state[A8]: begin
        split_x <= mapped;  // (21)
        if (known) state <= only(OU);
        else seek(1'b0, only(SH1));
      end
      state[D0]: begin
        if (known) {split, turn_x, reach} <= {kept_split, kept_turn_x, kept_reach};
        {low_zone, share} <= past;
        state <= only(D1);
      end
      state[D1]: begin
        high_zone <= share >= 614;
        state <= only(D2);
      end
      state[D2]: state <= only(D3);
      state[D3]: state <= only(D5);
      state[D5]: begin
        outer <= EXACT_OUTER && X - mapped <= NEAR_END;
        state <= only(D6);
      end
      state[D6]: begin
        split_x <= beyond ? hi_x : whole[31:16];  // (14)
        state <= only(D7);
      end
      state[D7]: begin
        split_y <= whole[31:16];  // (15)
        if (known) state <= only(OU);
        else seek(1'b1, only(SH1));
      end

      state[SH1]: begin
        split <= mapped;
        if (er) seek(1'b0, only(SH2));
        else state <= only(OU);
      end
      state[SH2]: begin
        turn_x <= mapped;
        state <= only(OU);
      end
      state[OU]: begin
        if (outer && er) split_x <= under ? lo_x : split;
        if (outer && !er) map(only(OU2));
        else state <= known ? only(P0) : only(RE);
      end
      state[OU2]: begin
        split_y <= mapped;
        state <= known ? only(P0) : only(RE);
      end
      state[RE]: begin  // (16) to (19), (23) to (26)
        end_above <= !under || at_low;
        after <= only(RX);
        state <= only(RE2);
      end
      state[RE2]: begin
        if (er ? &hi_x : lo_x == 0) begin
          reach <= er ? Y : 16'd0;
          state <= only(P0);
        end else if (er ? is_under : is_beyond) begin
          reach <= er ? lo_u : hi_u;
          state <= only(P0);
        end else if (er && is_beyond) state <= only(RD);
        else if (er || end_above) go_on;
        else seek(1'b1, only(RF));
      end
      state[RD]: map(only(RX));
      state[RX]: seek(1'b1, er ? only(RG) : only(RF));
      state[RF]: map(only(RG));
      state[RG]: begin
        reach <= mapped;
        state <= only(P0);
      end

      state[P0]: begin
        if (goal != FIND) searched <= 1;
        scaled <= !same;
        {p_low, p_high, p_x_low, p_x_high} <= {lo_u, hi_u, lo_x, hi_x};
        flat <= room[16];  // a turn beyond the end
        low_zone <= room[16] && er ? !beyond || v == v_high : under;
        after <= only(P1);
        state <= only(P3);
      end
      state[P3]:
      if (is_under || is_beyond) state <= only(P2);
      else if (falls_off || rise == 0) state <= only(CU);
      else go_on;
      state[P2]: begin
        if (low_zone) begin
          if (!(flat && er)) p_high <= p_low;
          p_low <= 0;
          p_x_high <= p_x_low;
        end else begin
          if (!(flat && !er)) p_low <= p_high;
          p_high <= 65535;
          p_x_low <= p_x_high;
        end
        state <= only(CU);
      end
      state[P1]: begin
        upper <= !under || (at_low && !er);
        rounds_up <= 1;
        state <= scaled ? only(PR) : only(PT);
      end
      // A knot is below the output where it is below w: for w between low and high, floor(floor(a 2^16 / b) c / 2^16) < w is
      // a < ceil(ceil(w 2^16 / c) b / 2^16). So w goes back through both maps, rounded up, and is searched on the pattern.
      state[PR]: begin
        quotient <= quotient + {15'd0, remains};
        after <= only(PT);
        state <= only(MUL);
      end
      state[PT]: begin
        strict <= !under;
        map(only(PS));
      end
      state[PS]: begin
        unsought <= ~v;
        rounds_up <= 0;
        on_x <= 0;
        found <= only(E0);
        k <= 0;
        left_knots <= LAST_KNOT;
        state <= only(SL);
      end
      state[SL]: begin
        k <= next_k;
        left_knots <= next_left;
        if (next_left <= 1) state <= found[E0] ? only(E0) : only(K1);
      end
      state[K1]: begin
        at_0 <= knot_of;
        at_1 <= knot_to;
        state <= only(K2);
      end
      state[K2]: map(found);
      state[E0]: begin  // the outputs on the curve of the knots on both sides
        {at_0, low_0, high_0} <= {x_knot, under, beyond};
        map(only(E1));
      end
      state[E1]: map(only(E2));
      state[E2]: begin
        p_low <= mapped;
        {at_1, low_1, high_1} <= {x_knot, under, beyond};
        map(only(E3));
      end
      state[E3]: map(only(EX0));
      state[EX0]: begin
        p_high <= mapped;
        map(only(EX1));
      end
      state[EX1]: begin
        p_x_low <= mapped;
        map(only(EX2));
      end
      state[EX2]: begin
        p_x_high <= mapped;
        if (!under) p_x_low <= lo_x;
        both <= 1;
        state <= only(CX2);
      end
      state[CX2]: begin
        if (!beyond) p_x_high <= hi_x;
        state <= only(CU);
      end
      state[CU]: begin  // the output from which another branch goes on ends the piece
        cuts <= left >= 2 && (er ? !beyond : !under);
        state <= only(CUT);
      end
      state[CUT]: begin
        crossed <= both && room[16];
        state <= only(CUT2);
      end
      state[CUT2]: begin
        if (crossed) p_x_high <= p_x_low;
        if (cuts && er) begin
          p_high <= hi_u;
          p_x_high <= cut_x;
        end
        if (cuts && !er) begin
          p_low <= lo_u;
          p_x_low <= cut_x;
        end
        state <= goal == WAY ? only(WA) : only(AL);
      end
      state[AL]: begin
        if (goal == HERE) has_here <= 1;
        else has_there <= 1;
        map(only(AL2));
      end
      state[AL2]: begin
        pressure <= mapped;
        state <= only(OUT);
      end
      state[DIV0]: go_on;
      state[DIV]: if (turns == 3) state <= rounds_up ? only(CEIL) : only(MUL);
      state[CEIL]: begin
        quotient <= quotient + {15'd0, |rest};
        state <= only(MUL);
      end
      state[MUL]: begin
        remains <= |rest;
        state <= only(MAP);
      end
      state[MAP]: state <= after;
      state[OUT]:
      if (out_ready) begin
        taxel <= last_taxel ? 8'd0 : taxel + 8'd1;
        state <= only(IDLE);
      end
      default: ;
    endcase
    if (reset) begin
      state <= only(LOAD);
      phase <= 0;
      item <= 0;
      falls_ <= 0;
      taxel <= 0;
      gap <= 0;
      crc <= 32'hFFFFFFFF;
      loaded <= 0;
    end
  end
