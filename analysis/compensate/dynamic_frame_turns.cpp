// The events of a block: few one by one, many in vectors.
#include <bit>

#include "analysis/compensate/dynamic_frame_state.h"

namespace tactbench::analysis {

namespace {

// More events than take less time one by one. No population count: without its instruction it is a call of libgcc's.
bool many(unsigned events) {
  constexpr int kFew = 3;
  for (int i = 0; i < kFew; ++i) events &= events - 1;
  return events != 0;
}

}  // namespace

template <class Real>
void DynamicFrameCompensator<Real>::State::attend(std::size_t at, unsigned events) {
  DynamicBlock<Real>& b = blocks[at];
  events &= ~unsigned{lost[at]};
  if (many(events)) return attend_many(at, events);
  for (unsigned left = events; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const std::size_t taxel = at * kLanes + i;
    const Taxel& t = taxels[taxel];
    const bool turned = (marks[i] & kTurned) != 0, back = (marks[i] & kBack) != 0, is_held = (marks[i] & kHeld) != 0;
    if (t.unknown) {
      attend_unknown(taxel, turned, t.decided && back, t.decided && is_held);
      continue;
    }
    if (turned) {
      attend_turned(taxel);
      const Reading here = locate(taxel);
      show(taxel, here, here.slope, Real(0));
      continue;
    }
    const Real u = linear(taxel, b.mean[i]);
    if (!(b.low[i] <= u && u <= b.high[i])) (void)locate(taxel);
    rest(taxel, is_held, back);
  }
}

// The same in vectors but for the memories.
template <class Real>
void DynamicFrameCompensator<Real>::State::attend_many(std::size_t at, unsigned events) {
  DynamicBlock<Real>& b = blocks[at];
  const std::size_t first = at * kLanes;
  unsigned rests = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    DynamicMark<Real>& mark = marks[i];
    const std::size_t taxel = first + i;
    if ((events >> i & 1U) == 0) {
      mark = 0;
      continue;
    }
    if (taxels[taxel].unknown) {
      const bool decided = taxels[taxel].decided;
      attend_unknown(taxel, (mark & kTurned) != 0, decided && (mark & kBack) != 0, decided && (mark & kHeld) != 0);
      mark = 0;
      continue;
    }
    const bool turned = (mark & kTurned) != 0, top = (b.rising[i] > Real(0)) & (b.turn[i] >= taxels[taxel].top_from);
    if (turned & top) observe_top(taxel);
    rests |= (!turned & ((mark & (kBack | kHeld)) != 0)) ? 1U << i : 0U;
  }
  using Passes = DynamicPasses<Real>;
  const bool wide = dispatch == Dispatch::kAvx512, avx = dispatch == Dispatch::kAvx2;
  const auto turn = wide ? &Passes::turn_avx512 : avx ? &Passes::turn_avx2 : &Passes::turn_base;
  const auto locate_all = wide ? &Passes::locate_avx512 : avx ? &Passes::locate_avx2 : &Passes::locate_base;
  turn(b, marks, shared.lead, intervals_per, search);
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool want = ((marks[i] & kEvent) != 0) & (((marks[i] & kTurned) | search.outside[i]) != 0);
    search.wanted[i] = want ? 1 : 0;
    if (!want) continue;
    const std::size_t taxel = first + i;
    Taxel& t = taxels[taxel];
    if ((marks[i] & kTurned) != 0) {
      if (search.turn_known[i] != 0)
        t.memory.turn_at(search.turn_x[i], search.turn_u[i]);
      else
        t.memory.turn(everett(taxel), search.turn_u[i]);
      t.back_known = false;
    }
    const Real u = search.at[i];
    if (b.mean[i] == b.extreme[i]) t.memory.go(u);
    const auto from = t.memory.branch(u);
    search.rises[i] = t.memory.rises() ? Real(1) : Real(-1);
    search.x[i] = from.x;
    search.u[i] = from.u;
    search.end[i] = from.end;
    search.table[i] = static_cast<std::int32_t>(taxel * table_size);
  }
  locate_all(b, search, searched);
  for (unsigned left = rests; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    rest(first + i, (marks[i] & kHeld) != 0, (marks[i] & kBack) != 0);
  }
}

template struct DynamicFrameCompensator<float>::State;
template struct DynamicFrameCompensator<double>::State;

}  // namespace tactbench::analysis
