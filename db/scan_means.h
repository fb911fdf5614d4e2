// Mean of the scans of one frame without outliers: samples that the other scans of the frame contradict. Counts are
// scans x taxels, scan slowest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactbench::db {

// Scans of a frame follow each other within milliseconds: a sample further than 5 % of the converter from what the
// others agree on is an outlier.
inline constexpr double kOutlierCounts = 0.05 * 65535.0;
inline constexpr std::uint16_t kConverterLimit = 65535;

// Outputs of the same taxel in the previous and the next frame, in any order; NaN: there is no such frame.
struct Nearby {
  double one, other;
};

// The value on which most samples of a taxel agree within kOutlierCounts. Of two samples that differ, the one clearly
// nearer to the neighbouring frames or, if there are none, the one that is not at an end of the converter's range. NaN:
// no sample is left out, because all agree or the outlier cannot be identified.
double consensus_count(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel, Nearby nearby);

// True when the scans of a taxel, or of any taxel, differ by more than kOutlierCounts.
bool disagree(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel);
bool scans_disagree(std::span<const std::uint16_t> counts, std::size_t scans);

// The mean of each taxel's scans, without outliers. `before`: the means of the previous frame; empty: there is none.
std::vector<double> scan_means(std::span<const std::uint16_t> counts, std::size_t scans,
                               std::span<const double> before = {});

}  // namespace tactbench::db
