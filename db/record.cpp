#include "db/record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tactbench::db {
namespace {

constexpr std::array kOutcomes = {"incomplete", "completed", "stopped", "aborted", "failed", "interrupted"};
constexpr std::array kSafeStates = {"unknown", "verified", "unverified", "failed"};

}  // namespace

const char* to_string(Outcome outcome) { return kOutcomes.at(static_cast<std::size_t>(outcome)); }
const char* to_string(SafeState state) { return kSafeStates.at(static_cast<std::size_t>(state)); }

std::optional<Outcome> outcome_from(const std::string& word) {
  for (std::size_t i = 0; i < kOutcomes.size(); ++i) {
    if (word == kOutcomes[i]) return static_cast<Outcome>(i);
  }
  return std::nullopt;
}

std::optional<SafeState> safe_state_from(const std::string& word) {
  for (std::size_t i = 0; i < kSafeStates.size(); ++i) {
    if (word == kSafeStates[i]) return static_cast<SafeState>(i);
  }
  return std::nullopt;
}

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double distance(double count, Nearby nearby) {
  const auto [low, high] = std::minmax(nearby.one, nearby.other);
  return std::max({low - count, count - high, 0.0});
}

double agreed_of_two(double a, double b, Nearby nearby) {
  if (std::isnan(nearby.one)) {
    const auto at_end = [](double count) { return count == 0.0 || count == kConverterLimit; };
    return at_end(a) == at_end(b) ? kNone : at_end(a) ? b : a;
  }
  const double of_a = distance(a, nearby), of_b = distance(b, nearby);
  if (2.0 * std::min(of_a, of_b) >= std::max(of_a, of_b)) return kNone;
  return of_a < of_b ? a : b;
}

}  // namespace

bool disagree(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel) {
  std::uint16_t low = kConverterLimit, high = 0;
  for (std::size_t i = taxel; i < counts.size(); i += counts.size() / scans) {
    low = std::min(low, counts[i]);
    high = std::max(high, counts[i]);
  }
  return high - low > kOutlierCounts;
}

bool scans_disagree(std::span<const std::uint16_t> counts, std::size_t scans) {
  for (std::size_t taxel = 0; taxel < counts.size() / scans; ++taxel)
    if (disagree(counts, scans, taxel)) return true;
  return false;
}

double consensus_count(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel, Nearby nearby) {
  if (!disagree(counts, scans, taxel)) return kNone;
  const std::size_t taxels = counts.size() / scans;
  if (scans == 2) return agreed_of_two(counts[taxel], counts[taxel + taxels], nearby);
  std::vector<double> own;
  for (std::size_t i = taxel; i < counts.size(); i += taxels) own.push_back(counts[i]);
  std::ranges::nth_element(own, own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2));
  const double middle = own[own.size() / 2];
  const auto agree =
      std::ranges::count_if(own, [&](double count) { return std::abs(count - middle) <= kOutlierCounts; });
  return 2 * static_cast<std::size_t>(agree) > scans ? middle : kNone;
}

std::vector<double> scan_means(std::span<const std::uint16_t> counts, std::size_t scans,
                               std::span<const double> before) {
  const std::size_t taxels = counts.size() / scans;
  std::vector<double> means(taxels);
  for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
    const double near = before.size() == taxels ? before[taxel] : kNone;
    const double agreed = consensus_count(counts, scans, taxel, {near, near});
    double sum = 0.0, kept = 0.0;
    for (std::size_t i = taxel; i < counts.size(); i += taxels) {
      if (std::abs(counts[i] - agreed) > kOutlierCounts) continue;
      sum += counts[i];
      kept += 1.0;
    }
    means[taxel] = sum / kept;
  }
  return means;
}

}  // namespace tactbench::db
