#include "tests/benchmarks/study/specimen_walk.h"

#include <algorithm>
#include <cmath>

namespace tactbench::bench {

namespace {

constexpr int kSteps = kLevels - 1;
constexpr double kWalkStep = kTopPsi / kSteps, kPiece = 0.25;

}  // namespace

SpecimenWalk::SpecimenWalk(const SpecimenOptions& options) : specimen_(options) {}

void SpecimenWalk::go(double to_psi, double piece_psi, double seconds_a_piece) {
  const double from = pressure_;
  const int pieces = static_cast<int>(std::ceil(std::abs(to_psi - from) / piece_psi - 1e-9));
  for (int k = 1; k <= pieces; ++k) specimen_.advance(from + (to_psi - from) * k / pieces, seconds_a_piece);
  pressure_ = to_psi;
}

void SpecimenWalk::step(double to_psi) {
  go(to_psi, 0.5, 0.1);
  for (int k = 0; k < 4; ++k) specimen_.advance(pressure_, 0.5);
}

void SpecimenWalk::condition() {
  for (int cycle = 0; cycle < 3; ++cycle) (void)loop();
}

std::vector<std::vector<double>> SpecimenWalk::loop() {
  std::vector<std::vector<double>> frames = {output()};
  for (int k = 1; k <= 2 * kSteps; ++k) {
    step(kWalkStep * (k <= kSteps ? k : 2 * kSteps - k));
    frames.push_back(output());
  }
  return frames;
}

void SpecimenWalk::jump(double to_psi) { go(to_psi, kPiece, kPiece / 40.0); }

void SpecimenWalk::at_once(std::initializer_list<double> turning_points) {
  for (const double point : turning_points) go(point, kPiece, 1e-9);
}

void SpecimenWalk::condition_at_once() {
  for (int cycle = 0; cycle < 6; ++cycle) at_once({kTopPsi, 0.0});
}

void SpecimenWalk::hold(double seconds) {
  double done = 0.0;
  for (double cut = 0.05; done < seconds; cut = std::min(2.0 * cut, 600.0)) {
    const double piece = std::min(cut, seconds - done);
    specimen_.advance(pressure_, piece);
    done += piece;
  }
}

void SpecimenWalk::press(std::span<const double> contact_psi) {
  std::vector<double> part(contact_psi.begin(), contact_psi.end());
  for (int k = 1; k <= 4; ++k) {
    for (std::size_t i = 0; i < part.size(); ++i) part[i] = contact_psi[i] * k / 4.0;
    specimen_.advance(0.0, 0.1, part);
  }
}

std::vector<double> SpecimenWalk::output() const {
  const SpecimenOptions& options = specimen_.options();
  std::vector<double> volts(static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns));
  specimen_.output(volts);
  return volts;
}

}  // namespace tactbench::bench
