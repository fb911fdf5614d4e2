// Frames of any number of taxels, whole blocks of lanes and parts of them: each taxel reads as it does alone.
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

template <class Real>
struct BlockReadings {
  std::vector<Real> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  explicit BlockReadings(std::size_t n) : pressure(n, Real(-7)), uncertainty(n, Real(-7)), status(n, 999) {}
};

// `whole` takes frames of all taxels, `alone` one taxel each.
template <class Real, class Frames>
class BesideEachOther {
 public:
  template <class Setup>
  BesideEachOther(const Setup& setup, std::size_t count) : count_(count), whole_(with(setup, 0, count)), read_(count) {
    for (std::size_t t = 0; t < count; ++t) alone_.push_back(std::make_unique<Frames>(with(setup, t, 1)));
  }
  void all(const auto& action) {
    action(whole_);
    for (auto& one : alone_) action(*one);
  }
  void frame(const std::vector<Real>& volts) {
    whole_.frame(std::span<const Real>(volts), {read_.pressure, read_.uncertainty, read_.status});
    compare([&](std::size_t t, auto& one, const auto& output) { one.frame(std::span(&volts[t], 1), output); });
  }
  void lost() {
    whole_.lost_frame({read_.pressure, read_.uncertainty, read_.status});
    compare([](std::size_t, auto& one, const auto& output) { one.lost_frame(output); });
  }

 private:
  template <class Setup>
  static Setup with(Setup setup, std::size_t first, std::size_t count) {
    const auto taxels = std::move(setup.taxels);
    setup.taxels.clear();
    for (std::size_t t = first; t < first + count; ++t) setup.taxels.push_back(taxels[t % taxels.size()]);
    return setup;
  }
  void compare(const auto& step) {
    for (std::size_t t = 0; t < count_; ++t) {
      CAPTURE(count_, t);
      BlockReadings<Real> own(1);
      step(t, *alone_[t], typename Frames::Output{own.pressure, own.uncertainty, own.status});
      const double near = sizeof(Real) == sizeof(float) ? 1e-3 : 1e-9;  // iterations end when all of a block are done
      REQUIRE(read_.pressure[t] == Approx(own.pressure[0]).margin(near).epsilon(near));
      REQUIRE(read_.uncertainty[t] == Approx(own.uncertainty[0]).margin(near).epsilon(near));
      REQUIRE(read_.status[t] == own.status[0]);
    }
  }
  std::size_t count_;
  Frames whole_;
  BlockReadings<Real> read_;
  std::vector<std::unique_ptr<Frames>> alone_;
};

// Up, down and up again by parts of 3 V, with a sample missing here and there, and two frames lost.
template <class Real>
void walk_blocks(auto& frames, std::size_t count) {
  const Real missing = std::numeric_limits<Real>::quiet_NaN();
  std::size_t k = 0;
  for (const double share : {0.2, 0.5, 0.45, 0.8, 0.6, 0.3, 0.32, 0.7, 1.0, 0.99, 0.4, 0.0, 0.1, 0.6}) {
    std::vector<Real> volts;
    for (std::size_t t = 0; t < count; ++t)
      volts.push_back((t + k) % 11 == 5 ? missing : static_cast<Real>(3.0 * share + 0.01 * static_cast<double>(t % 7)));
    frames.frame(volts);
    if (++k % 6 == 0) frames.lost();
  }
}

constexpr std::size_t kCounts[] = {1, 7, 8, 9, 15, 16, 17, 31, 32, 33, 48};

}  // namespace

TEMPLATE_TEST_CASE("blocks of taxels: dynamic frames of any number read each taxel as it does alone", "[dynamic]",
                   float, double) {
  for (const bool unknown : {false, true})
    for (const std::size_t count : kCounts) {
      DynamicSetup setup = dynamic_array(9, 0.002, 6).setup;
      setup.start_unknown = unknown;
      setup.longest_gap = 0;
      BesideEachOther<TestType, DynamicFrameCompensator<TestType>> frames(setup, count);
      frames.all([](auto& one) { one.set_interval(1.5); });
      walk_blocks<TestType>(frames, count);
    }
}

TEMPLATE_TEST_CASE("blocks of taxels: frames of any number read each taxel as it does alone", "", float, double) {
  FrameSetup setup = random_reversals(9, 2, 0.002, 5.0).setup;
  for (const bool unknown : {false, true})
    for (const std::size_t count : kCounts) {
      setup.start_unknown = unknown;
      setup.longest_gap = 0;
      BesideEachOther<TestType, FrameCompensator<TestType>> frames(setup, count);
      walk_blocks<TestType>(frames, count);
    }
}
