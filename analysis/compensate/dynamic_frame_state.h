// Inside of a dynamic frame compensator: the vectors' memory, the staircases behind it, and the work left by the
// passes.
#pragma once

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/dynamic_lanes.h"
#include "analysis/compensate/everett.h"

namespace tactbench::analysis {

template <class Real>
struct DynamicFrameCompensator<Real>::State {
  explicit State(const DynamicSetup& setup);

  struct Taxel {
    bool usable = false, unknown = false;
    bool started = true, decided = true;         // of an unknown history
    Real first = 0, first_weight = 1;            // its extreme until the direction is known
    Real top = 0;                                // full output
    Real highest = 0, gain = 1, plain_gain = 1;  // of the observer; the lane's gain without it
    Real top_from = 0;                           // a turn from here on tells of the gain
    Staircase<Real> memory, other;
    BranchPiece<Real> back;  // of the branch back from the extreme `back_turn`
    Real back_turn = 0;
    bool back_known = false;
  };
  struct Reading {
    Real x, slope;  // psi from the lowest; psi an output
  };

  void start(std::size_t taxel, bool is_unknown);
  void set_unknown(Taxel& taxel, bool is_unknown) {
    unknowns = unknowns - (taxel.unknown ? 1 : 0) + (is_unknown ? 1 : 0);
    taxel.unknown = is_unknown;
  }
  template <class Sample>
  void frame(std::span<const Sample> from, const Output& output);
  void set_step(double seconds);
  void mark(const Output& output);
  void check(std::size_t size, const Output& output) const;

  // dynamic_frame_turns.cpp.
  void attend(std::size_t block, unsigned events);
  void attend_many(std::size_t block, unsigned events);
  // dynamic_frame_events.cpp.
  void rest(std::size_t taxel, bool is_held, bool back);
  void attend_turned(std::size_t taxel);
  void attend_unknown(std::size_t taxel, bool turned, bool back, bool is_held);
  void observe_top(std::size_t taxel);
  Reading locate(std::size_t taxel);
  [[nodiscard]] Reading located(std::size_t taxel) const;  // by what locate() put into the lane's rows
  [[nodiscard]] Real per_left(std::size_t taxel, Real output) const;
  void take_extreme(std::size_t taxel);
  void face(std::size_t taxel, bool rises) { block(taxel).rising[taxel % kLanes] = rises ? Real(1) : Real(-1); }
  void fill_reverse(std::size_t taxel);
  void show(std::size_t taxel, const Reading& reading, Real sensitivity, Real doubt);
  [[nodiscard]] DynamicBlock<Real>& block(std::size_t taxel) { return blocks[taxel / kLanes]; }
  [[nodiscard]] Everett<Real> everett(std::size_t taxel) const { return {&tables[taxel * table_size], intervals}; }
  [[nodiscard]] Real linear(std::size_t taxel, Real output) const;
  [[nodiscard]] Reading reading(std::size_t taxel, const BranchPiece<Real>& piece, Real output) const;
  [[nodiscard]] Reading read(std::size_t taxel, const Staircase<Real>& memory, Real output) const;
  [[nodiscard]] Real reverse_sensitivity(std::size_t taxel, const Staircase<Real>& memory) const;

  AlignedVector<DynamicBlock<Real>> blocks;
  AlignedVector<Real> samples, outputs;  // whole blocks
  AlignedVector<Real> pressures, uncertainties;
  AlignedVector<std::uint16_t> status;
  std::vector<std::uint16_t> lost;  // bits a block
  alignas(64) DynamicMark<Real> marks[kLanes] = {};
  DynamicSearch<Real> search;
  DynamicTables<Real> searched = {};
  DynamicBlock<Real> kept;
  DynamicFrame<Real> shared;
  Dynamics dynamics;
  DynamicsState begin;  // of every taxel at a start
  CompensatorOptions options;
  GainObserver observer;
  std::vector<Taxel> taxels;
  std::vector<Real> tables;
  std::vector<Real> residuals;  // by interval, rising and falling
  std::vector<std::size_t> dead;
  std::size_t count = 0, intervals = 0, table_size = 0, unknowns = 0;
  Real per_interval = 1, intervals_per = 1, counts_per_volt = 1;  // psi, and its reciprocal
  double interval_s = 0.0, tare_share = 0.0;
  int gap = 0, longest_gap = 0;
  bool outside = false, interval_known = false;
  Dispatch dispatch = Dispatch::kBase;
};

}  // namespace tactbench::analysis
