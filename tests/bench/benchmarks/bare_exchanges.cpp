// `benchmark sequence`: which exchanges a run's frames and their traces stand for.
#include <catch2/catch.hpp>
#include <ostream>
#include <vector>

#include "bench/benchmarks/sequence.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

using ExchangeKind = BareExchange::Kind;
constexpr std::int64_t kMillisecond = 1'000'000;

db::FrameRecord traced_frame(std::int64_t time_ms, std::int64_t since_command_ms, double psi, int scans,
                             const std::vector<double>& before_s) {
  db::FrameRecord frame;
  frame.time_ns = time_ms * kMillisecond;
  frame.since_command_ns = since_command_ms * kMillisecond;
  frame.setpoint_psi = psi;
  frame.scans = scans;
  for (const double one : before_s) frame.trace.push_back({static_cast<float>(one), 0.0F, 0.0F, 0.0F});
  return frame;
}

}  // namespace

TEST_CASE("benchmark sequence: polls at the times of the trace, the command before the first poll behind it") {
  const std::vector<BareExchange> exchanges =
      bare_exchanges({traced_frame(10000, 2000, 4.0, 2, {3.0, 2.0, 1.5, 0.25}),
                      traced_frame(13000, 2500, 6.0, 3, {2.75, 0.5}), traced_frame(14000, 5000, 8.0, 1, {})});
  const std::vector<BareExchange> expected{
      {ExchangeKind::kPoll, 7000 * kMillisecond, 0.0, 0},
      {ExchangeKind::kPoll, 8000 * kMillisecond, 0.0, 0},  // at the very time of the command
      {ExchangeKind::kCommand, 8000 * kMillisecond, 4.0, 0},
      {ExchangeKind::kPoll, 8500 * kMillisecond, 0.0, 0},
      {ExchangeKind::kPoll, 9750 * kMillisecond, 0.0, 0},
      {ExchangeKind::kFrame, 10000 * kMillisecond, 0.0, 2},
      {ExchangeKind::kPoll, 10250 * kMillisecond, 0.0, 0},
      {ExchangeKind::kCommand, 10500 * kMillisecond, 6.0, 0},
      {ExchangeKind::kPoll, 12500 * kMillisecond, 0.0, 0},
      {ExchangeKind::kFrame, 13000 * kMillisecond, 0.0, 3},
      {ExchangeKind::kFrame, 14000 * kMillisecond, 0.0, 1}};
  REQUIRE(exchanges.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO("exchange " << i);
    CHECK((exchanges[i] == expected[i]));
  }
}
