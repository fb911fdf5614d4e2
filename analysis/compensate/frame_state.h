// A frame compensator from inside: vectors' memory, the curves behind it, and what the vector pass leaves to do.
#pragma once

#include "analysis/compensate/frame_compensator.h"
#include "analysis/compensate/frame_lanes.h"

namespace tactbench::analysis {

template <class Real>
struct FrameCompensator<Real>::State {
  explicit State(const FrameSetup& setup);

  // Of a start from anywhere.
  struct History {
    ComposedCurve other;  // of the history that fell from the top
    Real extreme = 0, weight = 1;
    bool unknown = false, started = false, decided = false;
  };
  struct SavedLane {
    std::size_t taxel;
    Real steps, mean, weight, root_weight, extreme, extreme_weight, turn, pressure, uncertainty;
  };
  struct Reading {
    double pressure = 0.0, uncertainty = 0.0;
    bool flat = false;
  };

  // Streaming (frame_stream.cpp).
  void start_lane(std::size_t taxel, bool unknown);
  void set_curve(std::size_t taxel, const ComposedCurve& curve);  // and forgets the old one's pieces
  void take_extreme(std::size_t taxel);
  void write(const Output& output, bool all_lost) const;
  void save_lane(std::size_t taxel);
  void restore_lanes();
  void check(std::size_t samples, const Output& output) const;

  // After the pass (frame_events.cpp).
  void attend();
  void attend_known(std::size_t taxel, std::uint32_t what);
  void attend_unknown(std::size_t taxel, std::uint32_t what);
  void decide(std::size_t taxel);
  void fill_knot(std::size_t taxel, std::size_t knot, double y, bool held);
  void fill_piece(std::size_t taxel, bool held);
  void find_way_back(std::size_t taxel);
  [[nodiscard]] Reading read(std::size_t taxel, const ComposedCurve& curve, bool back, bool held) const;
  void put(std::size_t taxel, const Reading& reading, std::uint16_t more_bits);

  FrameLanes<Real> lanes;
  std::vector<ComposedCurve> ways_back;  // from the block's back_turn
  std::vector<History> histories;
  std::vector<std::size_t> dead;
  AlignedVector<std::uint16_t> counts;  // whole blocks
  AlignedVector<Real> volts;
  std::vector<SavedLane> saved;  // of the samples that are not numbers; room for all
  std::vector<bool> lost;
  double lowest_psi = 0.0, span_psi = 0.0, tare_share = 0.0;
  int gap = 0, longest_gap = 0;
  bool outside = false;
  Dispatch dispatch = Dispatch::kBase;
};

}  // namespace tactbench::analysis
