// Internals of a frame compensator: the vectors' memory, the curves from which it is filled, and the work left by the
// vector pass.
#pragma once

#include "analysis/compensate/composed_curve.h"
#include "analysis/compensate/frame_compensator.h"
#include "analysis/compensate/frame_lanes.h"
#include "analysis/compensate/residual_bins.h"

namespace tactbench::analysis {

template <class Real>
struct FrameCompensator<Real>::State {
  explicit State(const FrameSetup& setup);

  // A piece of a curve as a lane's rows hold it, and where it came from, in the sensor's outputs.
  struct LanePiece {
    Real low, high, origin, at, slope;
    Real residual2;  // at its middle, squared
    CurvePiece piece;
    Real own = 0, worst = 0;  // look_up() sets them
    [[nodiscard]] bool holds(Real mean) const { return mean >= low && mean <= high; }
    [[nodiscard]] Real along(Real mean) const { return at + slope * (mean - origin); }
  };
  // Data of a taxel besides its lane.
  struct Taxel {
    bool rises = true;      // the lane's outputs are the sensor's, else their negatives
    bool unknown = false;   // its history is
    std::uint8_t here = 0;  // the piece in the lane's rows; the other one is that before it: noise goes to and fro
    LanePiece pieces[2];
    Real back_turn = 0;      // NaN: none yet
    LanePiece back;          // of the curve back from there
    ComposedCurve curve;     // since the last remembered turn
    ComposedCurve way_back;  // from the extreme
  };
  // Of a start from any state.
  struct History {
    ComposedCurve other;  // of the history that fell from the top
    Real extreme = 0, weight = 1;
    bool started = false, decided = false;
  };
  // Of a curve's knots (CurvePiece::index), and of the two places below and above them all. NaN: not computed yet.
  struct Sensitivity {
    Real own, reverse;
  };
  struct Reading {
    double pressure = 0.0, uncertainty = 0.0;
    bool flat = false;
  };
  struct Place {  // a taxel with its lane
    std::size_t taxel, i;
    LaneBlock<Real>& b;
    Taxel& t;
    const TaxelPattern& pattern;
    // In the sensor's direction.
    [[nodiscard]] double output(Real in_lane) const { return static_cast<double>(t.rises ? in_lane : -in_lane); }
    [[nodiscard]] double mean() const { return output(b.mean[i]); }
    [[nodiscard]] double turn() const { return output(b.turn[i]); }
  };

  // Streaming (frame_compensator.cpp).
  template <class Sample>
  void frame(std::span<const Sample> samples, AlignedVector<Sample>& whole_blocks, const Output& output);
  void start_lane(std::size_t taxel, bool unknown);
  void set_curve(const Place& at, const ComposedCurve& curve);  // and forgets the old one's pieces
  void face(const Place& at, bool rising);
  void take_extreme(const Place& at);
  void mark(const Output& output) const;       // outside, dead
  void mark_lost(const Output& output) const;  // after mark
  void check(std::size_t samples, const Output& output) const;
  Place place(std::size_t taxel);

  // After the pass (frame_events.cpp).
  void attend(const FrameResults<Real>& results);
  void attend_rare(const Place& at, bool turned, bool back, bool held, const FrameResults<Real>& results);
  Reading attend_turned(const Place& at);
  Reading attend_unknown(const Place& at, bool turned, bool back, bool held);
  void decide(const Place& at);
  void change_piece(const Place& at);
  void locate(const Place& at);
  void show(const Place& at);
  void fill_knot(const Place& at, std::size_t knot, double y, bool held);
  void fill_piece(const Place& at, bool held);
  void find_way_back(const Place& at);
  // Squared, of the model at a pressure.
  [[nodiscard]] Real residual2_at(const Place& at, double pressure) const;
  [[nodiscard]] LanePiece lane_piece(const Place& at, const CurvePiece& piece) const;
  void look_up(const Place& at);
  [[nodiscard]] Reading read(const Place& at, const ComposedCurve& curve, bool back, bool held) const;
  [[nodiscard]] Sensitivity* sensitivities_of(std::size_t taxel) { return sensitivities.data() + taxel * (knots + 3); }

  FrameLanes<Real> lanes;
  CompensatorOptions options;
  std::size_t count = 0, knots = 0;  // knots: of a pattern
  std::vector<TaxelPattern> patterns;
  std::vector<Taxel> taxels;
  std::vector<Sensitivity> sensitivities;  // taxel, knot
  std::vector<History> histories;
  std::vector<std::size_t> dead;
  std::vector<Real> residuals2;  // psi squared, `residual_size` a taxel; 0 where not known
  std::size_t residual_size = 0;
  // Whole blocks, where the caller's arrays are none.
  AlignedVector<std::uint16_t> counts, status;
  AlignedVector<Real> volts, pressures, uncertainties;
  double lowest_psi = 0.0, span_psi = 0.0, tare_share = 0.0;
  int gap = 0, longest_gap = 0;
  bool outside = false;
  Dispatch dispatch = Dispatch::kBase;
};

}  // namespace tactbench::analysis
