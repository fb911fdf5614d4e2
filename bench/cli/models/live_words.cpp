#include "bench/cli/models/live_words.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/counted.h"
#include "analysis/json_fields.h"

namespace tactbench::bench {

SummedFrame summed(const LiveFrame& frame) {
  SummedFrame sum;
  int counted = 0;
  for (std::size_t t = 0; t < frame.status.size(); ++t) {
    const unsigned bits = frame.status[t];
    sum.flags.flat += (bits & analysis::kTaxelFlat) != 0 ? 1 : 0;
    sum.flags.unknown += (bits & analysis::kTaxelUnknown) != 0 ? 1 : 0;
    sum.flags.out_of_range += (bits & analysis::kTaxelOutOfRange) != 0 ? 1 : 0;
    sum.flags.dead += (bits & analysis::kTaxelDead) != 0 ? 1 : 0;
    sum.flags.lost += (bits & analysis::kTaxelLost) != 0 ? 1 : 0;
    sum.flags.outside += (bits & analysis::kTaxelOutside) != 0 ? 1 : 0;
    if ((bits & analysis::kTaxelDead) != 0) continue;
    ++counted;
    const auto psi = static_cast<double>(frame.pressure_psi[t]);
    sum.mean_psi += psi;
    if (counted == 1 || psi > sum.highest_psi) {
      sum.highest_psi = psi;
      sum.highest = t;
    }
  }
  if (counted > 0) sum.mean_psi /= counted;
  return sum;
}

std::string frame_line(const LiveFrame& frame, const SummedFrame& sum, std::size_t columns,
                       analysis::PressureUnit unit) {
  const TaxelFlags& flags = sum.flags;
  return fmt::format(
      "frame {:>6}  mean {:>6} {}  highest {:>6} {} at {},{}  flat {} unknown {} out of range {} dead {} "
      "lost {}  {:.0f} us\n",
      frame.number, unit.fixed(sum.mean_psi, 2), unit.symbol(), unit.fixed(sum.highest_psi, 2), unit.symbol(),
      sum.highest / columns, sum.highest % columns, flags.flat, flags.unknown, flags.out_of_range, flags.dead,
      flags.lost, frame.latency_us);
}

std::string summary_line(const LiveSummary& summary) {
  return fmt::format(
      "{}, {} lost; request to compensated values: median {:.0f} us, p99 {:.0f} us, worst {:.0f} us (of it "
      "the compensation, median {:.1f} us)\n",
      analysis::counted(summary.frames, "frame"), summary.lost, summary.median_us, summary.p99_us, summary.worst_us,
      summary.compensation_median_us);
}

std::string frame_rows(const LiveFrame& frame) {
  std::string rows;
  for (std::size_t t = 0; t < frame.status.size(); ++t)
    rows += fmt::format("{},{:.6f},{},{:.4f},{:.4f},{}\n", frame.number, frame.time_s, t, frame.pressure_psi[t],
                        frame.uncertainty_psi[t], frame.status[t]);
  return rows;
}

nlohmann::ordered_json live_json(const LiveSummary& summary, const SummedFrame& last) {
  const TaxelFlags& flags = last.flags;
  return {{"other_scanner", summary.other_scanner},
          {"outside_validity", summary.outside},
          {"frames", summary.frames},
          {"lost_frames", summary.lost},
          {"latency_us",
           {{"median", summary.median_us},
            {"p99", summary.p99_us},
            {"worst", summary.worst_us},
            {"compensation_median", summary.compensation_median_us}}},
          {"last_frame",
           {JSON_FIELDS(last, mean_psi, highest_psi),
            JSON_FIELDS(flags, flat, unknown, out_of_range, dead),
            {"outside_validity", flags.outside},
            {"lost", flags.lost}}}};
}

}  // namespace tactbench::bench
