// One vector level of the dynamic passes; dynamic_pass.cpp includes it once for each and defines the level's names and
// target. Hence no include guard. The loops have no branch that depends on a sample: the compiler makes vectors of
// them.

namespace tactbench::analysis {

template <class Real>
TACTBENCH_PASS_TARGET unsigned DynamicPasses<Real>::TACTBENCH_PASS_LEVEL(DynamicBlock<Real>& b,
                                                                         const Real* __restrict samples,
                                                                         const DynamicFrame<Real>& frame,
                                                                         Real* __restrict outputs,
                                                                         Mark* __restrict marks) {
  const DynamicFrame<Real> f = frame;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real one = 1, zero = 0;
    const Real above = b.gain[i] * (samples[i] - b.zero[i]);
    // The creep's target needs the pressure: guessed along the slope of the last reading.
    const Real guessed = b.last_x[i] + b.last_slope[i] * (above * b.last_share[i] - b.last_mean[i]);
    const Real guess = std::min(std::max(guessed, zero), f.span);
    const Real target = guess / (guess + f.half);
    Real sum = target * f.creep_new - f.creep_all;
    for (std::size_t j = 0; j < kCreepElements; ++j) sum += f.creep_kept[j] * b.psi[j][i];
    const Real share = one / (one + b.creep_scale[i] * sum), y = above * share;
    b.last_share[i] = share;
    outputs[i] = y;
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real one = 1, zero = 0, y = outputs[i];
    const Real weight0 = b.weight[i], mean0 = b.mean[i], steps0 = b.steps[i];
    const Real off = y - mean0, off2 = off * off;
    const Real step = off2 * (one - Real(0.5) * weight0);
    const Real averaged_weight = std::max(weight0 / (one + weight0), f.least);
    const bool jumps = (f.moving < steps0) | (f.jump2 * (one + weight0) < off2);
    b.steps[i] = steps0 + (std::min(step, Real(kStepCeiling)) - steps0) * Real(1.0 / kStepWindow);
    const Real averaged = mean0 + averaged_weight * off;
    const Real mean = jumps ? y : averaged, weight = jumps ? one : averaged_weight;
    b.mean[i] = mean;
    b.weight[i] = weight;
    const Real root = std::sqrt(weight), lead = f.lead * root * (one - weight);
    const Real direction = b.rising[i], extreme0 = b.extreme[i], extreme_weight0 = b.extreme_weight[i];
    const Real ahead = direction * (mean - extreme0), forward = std::max(zero, ahead);
    const Real behind = std::max(zero, direction * (b.turn[i] - mean)), behind2 = behind * behind;
    const Real wider = std::max(weight, extreme_weight0), hold = f.hold2 * wider;
    const bool holds = forward * forward <= hold;
    const bool turns = (ahead < zero) & (behind2 > f.band2 * wider);
    const bool rested = (weight <= f.least) & (weight < extreme_weight0) & (behind2 <= f.rest2);
    const bool taken = (!turns) & ((ahead >= zero) | rested);
    const Real extreme_before = extreme0, turn_before = b.turn[i];
    b.extreme[i] = taken ? mean : extreme_before;
    b.extreme_weight[i] = taken ? weight : extreme_weight0;
    b.turn[i] = taken ? mean - direction * lead : turn_before;
    const Real left = one - std::min(mean * b.divider[i], Real(Divider::kMost)), per_left = one / left;
    const Real u = mean * per_left;
    const Real x = b.x[i] + b.slope[i] * (u - b.u[i]);
    const Real slope = b.slope[i] * per_left * per_left, reverse = b.reverse[i];
    const Real sensitivity = holds ? std::max(slope, reverse) : slope;
    b.uncertainty[i] = std::min(root * sensitivity, f.span);
    b.last_x[i] = x;
    b.last_slope[i] = std::min(slope, b.steepest[i]);
    b.last_mean[i] = mean;
    const bool fits = (b.low[i] <= u) & (u <= b.high[i]) & ((!holds) | (reverse == reverse));
    const bool back = (!taken) & (behind2 > hold);
    const Mark event = ((!fits) | back | turns) ? kEvent : 0;
    marks[i] = event | (holds ? kHeld : 0) | (back ? kBack : 0) | (turns ? kTurned : 0);
  }
  unsigned events = 0;
  for (std::size_t i = 0; i < kLanes; ++i) events |= static_cast<unsigned>(marks[i] & kEvent) << i;
  return events;
}

template <class Real>
TACTBENCH_PASS_TARGET void DynamicPasses<Real>::TACTBENCH_PASS_TURN(DynamicBlock<Real>& __restrict b,
                                                                    const Mark* __restrict marks, Real lead,
                                                                    Real intervals_per,
                                                                    DynamicSearch<Real>& __restrict s) {
  const Real zero = 0, one = 1;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool turned = (marks[i] & kTurned) != 0;
    const Real turn = b.turn[i], mean = b.mean[i], weight = b.weight[i], divider = b.divider[i];
    const Real turn_u = turn * (one / (one - std::min(turn * divider, Real(Divider::kMost))));
    const Real u = mean * (one / (one - std::min(mean * divider, Real(Divider::kMost))));
    const Real low = b.low[i], high = b.high[i];
    s.turn_u[i] = turn_u;
    s.turn_x[i] = (b.x[i] + b.slope[i] * (turn_u - b.u[i])) * intervals_per;
    s.turn_known[i] = ((low <= turn_u) & (turn_u <= high)) ? 1 : 0;
    const Real rising0 = b.rising[i], rising = turned ? -rising0 : rising0;
    const Real extreme0 = b.extreme[i], extreme_weight0 = b.extreme_weight[i];
    b.rising[i] = rising;
    b.extreme[i] = turned ? mean : extreme0;
    b.extreme_weight[i] = turned ? weight : extreme_weight0;
    const Real from = turned ? mean : turn, leads = turned ? rising * lead : zero;
    b.turn[i] = from - leads * std::sqrt(weight) * (one - weight);
    s.at[i] = u;
    const bool outside = (u < low) | (high < u);
    s.outside[i] = outside ? 1 : 0;
  }
}

// The memory's piece_of() and State::locate() without a branch, lane by lane: grid lines are passed by halving.
template <class Real>
TACTBENCH_PASS_TARGET void DynamicPasses<Real>::TACTBENCH_PASS_LOCATE(DynamicBlock<Real>& __restrict b,
                                                                      const DynamicSearch<Real>& __restrict s,
                                                                      const DynamicTables<Real>& tables) {
  using Index = std::int32_t;
  constexpr Real kFar = std::numeric_limits<Real>::max(), unknown = std::numeric_limits<Real>::quiet_NaN();
  const Real zero = 0, one = 1;
  const DynamicTables<Real> t = tables;
  const Real* const __restrict everett = t.everett;
  const Index n = t.intervals;
  const Real last = static_cast<Real>(n - 1);  // held before the cast: what is no number becomes no index
  alignas(64) Index place[kLanes], lines[kLanes], passed[kLanes];
  alignas(64) Real share[kLanes], way[kLanes], far[kLanes], root[kLanes];
  alignas(64) Real piece_low[kLanes], piece_high[kLanes], piece_u[kLanes], piece_x[kLanes], piece_slope[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    const auto p = static_cast<Index>(std::min(std::max(zero, s.x[i]), last));
    place[i] = p;
    lines[i] = s.rises[i] > zero ? n - p : p + 1;  // ahead
    share[i] = s.x[i] - static_cast<Real>(p);
    way[i] = s.rises[i] * (s.at[i] - s.u[i]);
    passed[i] = 0;
    root[i] = std::sqrt(b.weight[i]);
  }
  // Line k ahead of the corner; `next` leads from a value on the grid line below the corner to that on the one above.
  for (Index step = t.first_step; step > 0; step /= 2)
    for (std::size_t i = 0; i < kLanes; ++i) {
      const bool rises = s.rises[i] > zero;
      const Index p = place[i], k = std::min(passed[i] + step, lines[i]);
      const Index row = rises ? p + k : p, column = rises ? p : p + 1 - k, next = rises ? 1 : p + 1;
      const Index at = s.table[i] + row * (row + 1) / 2 + column;
      const Real below = everett[at], above = everett[at + next];
      passed[i] += below + share[i] * (above - below) < way[i] ? step : 0;
    }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool rises = s.rises[i] > zero;
    const Index p = place[i], k = lines[i], next = rises ? 1 : p + 1;
    const Index row = rises ? n : p, column = rises ? p : 0;
    const Index at = s.table[i] + row * (row + 1) / 2 + column;
    const Real below = everett[at], above = everett[at + next];
    far[i] = below + share[i] * (above - below);
    passed[i] = std::min(passed[i], k - 1);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool rises = s.rises[i] > zero;
    const Real sign = s.rises[i], part = share[i], along = way[i], u0 = s.u[i], x0 = s.x[i];
    const Real whole = far[i];
    const Index p = place[i], k = passed[i], next = rises ? 1 : p + 1;
    const bool first = k == 0;
    const Index then_row = rises ? p + k + 1 : p, then_column = rises ? p : p - k;
    const Index then = s.table[i] + then_row * (then_row + 1) / 2 + then_column;
    const Index row = rises ? p + k : p, column = rises ? p : p + 1 - k;
    const Index at = first ? then : s.table[i] + row * (row + 1) / 2 + column;
    const Real below = everett[at], above = everett[at + next];
    const Real then_below = everett[then], then_above = everett[then + next];
    const Real last_e = below + part * (above - below), next_e = then_below + part * (then_above - then_below);
    const Real corner = rises ? above : below;
    const Real kink = corner + ((rises ? then_above : above) - corner) * part +
                      ((rises ? below : then_below) - corner) * (one - part);
    const Real line_x = static_cast<Real>(rises ? p + k : p + 1 - k);
    const Real kink_x = (rises ? line_x : line_x - one) + part;
    const bool behind = (along > kink) | ((!rises) & (along == kink)), to_line = first | behind;
    const Real xa = first ? x0 : behind ? kink_x : line_x, ea = first ? zero : behind ? kink : last_e;
    const Real xb = to_line ? line_x + sign : kink_x, eb = to_line ? next_e : kink;
    const Real ua = u0 + sign * ea, ub = u0 + sign * eb;
    const Real steep = sign * (ub - ua) > Real(kLeastRise) ? (xb - xa) / (ub - ua) : zero;
    const Real u_whole = u0 + sign * whole;
    // Before the corner and beyond the end the branch is constant.
    const bool beyond = along > whole, inside = (along <= whole) & (along >= zero);
    const Real u_flat = beyond ? u_whole : u0, x_end = rises ? static_cast<Real>(n) : zero;
    const bool upward = (beyond ? -sign : sign) < zero;
    const Real low = inside ? std::min(ua, ub) : upward ? u_flat : -kFar;
    const Real high = inside ? std::max(ua, ub) : upward ? kFar : u_flat;
    piece_low[i] = low;
    piece_high[i] = high;
    piece_u[i] = inside ? ua : u_flat;
    piece_x[i] = inside ? xa : beyond ? x_end : x0;
    piece_slope[i] = inside ? steep : zero;
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool wanted = s.wanted[i] != 0, rises = s.rises[i] > zero;
    const Real u_a = piece_u[i], x_a = t.per_interval * piece_x[i], slope = t.per_interval * piece_slope[i];
    const Real end = s.end[i], low = piece_low[i], high = piece_high[i], mean = b.mean[i];
    const Real higher = std::max(low, end), lower = std::min(high, end);
    const Real left = one - std::min(mean * b.divider[i], Real(Divider::kMost)), per_left = one / left;
    const Real along = piece_x[i] + piece_slope[i] * (s.at[i] - u_a), x = t.per_interval * along;
    const Real sensitivity = slope * per_left * per_left;
    const Real last_slope = std::min(sensitivity, b.steepest[i]), uncertainty = std::min(root[i] * sensitivity, t.span);
    way[i] = along;
    const Real low0 = b.low[i], high0 = b.high[i], u_0 = b.u[i], x_0 = b.x[i], slope0 = b.slope[i];
    const Real reverse0 = b.reverse[i], last_x0 = b.last_x[i], last_slope0 = b.last_slope[i];
    const Real last_mean0 = b.last_mean[i], uncertainty0 = b.uncertainty[i];
    const Real new_low = rises ? low : higher, new_high = rises ? lower : high;
    b.low[i] = wanted ? new_low : low0;
    b.high[i] = wanted ? new_high : high0;
    b.u[i] = wanted ? u_a : u_0;
    b.x[i] = wanted ? x_a : x_0;
    b.slope[i] = wanted ? slope : slope0;
    b.reverse[i] = wanted ? unknown : reverse0;
    b.last_x[i] = wanted ? x : last_x0;
    b.last_slope[i] = wanted ? last_slope : last_slope0;
    b.last_mean[i] = wanted ? mean : last_mean0;
    b.uncertainty[i] = wanted ? uncertainty : uncertainty0;
  }
  if (t.residuals == nullptr) return;
  const Real* const __restrict residuals = t.residuals;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const auto at = static_cast<Index>(std::min(std::max(zero, way[i]), last));
    const Real own = b.residual_scale[i] * residuals[b.rising[i] > zero ? at : n + at];
    const Real changed = b.doubted[i] * (static_cast<Real>(at) + Real(0.5));
    root[i] = std::sqrt(own * own + changed * changed);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real now = root[i], before = b.residual[i];
    b.residual[i] = s.wanted[i] != 0 ? now : before;
  }
}

template <class Real>
TACTBENCH_PASS_TARGET void DynamicPasses<Real>::TACTBENCH_PASS_FINISH(DynamicBlock<Real>& b,
                                                                      const DynamicFrame<Real>& frame,
                                                                      const Real* __restrict outputs,
                                                                      const FrameResults<Real>& to) {
  const DynamicFrame<Real> f = frame;
  Real* const __restrict pressures = to.pressure;
  Real* const __restrict uncertainties = to.uncertainty;
  std::uint16_t* const __restrict status = to.status;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Real left = b.lag_share[i] * f.lag_kept;
    const Real undone = (b.last_x[i] - left * b.late[i]) / (Real(1) - left);
    const Real p = std::min(std::max(undone, Real(0)), f.span), target = p / (p + f.half);
    for (std::size_t j = 0; j < kCreepElements; ++j) b.psi[j][i] = target + (b.psi[j][i] - target) * f.kept[j];
    b.late[i] = p + (b.late[i] - p) * f.lag_kept;
    pressures[i] = b.pressure[i] = f.lowest + p;
    const Real noise = b.uncertainty[i], residual = b.residual[i];
    uncertainties[i] = std::min(std::sqrt(noise * noise + residual * residual), f.span);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool outside = (outputs[i] < -f.band) | (outputs[i] > b.highest[i]);
    const unsigned range = outside ? unsigned{kTaxelOutOfRange} : unsigned{kTaxelValid};
    const unsigned flat = b.uncertainty[i] > f.flat ? unsigned{kTaxelFlat} : 0U;
    status[i] = static_cast<std::uint16_t>(range | flat);
  }
}

}  // namespace tactbench::analysis
