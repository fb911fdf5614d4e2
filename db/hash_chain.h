// SHA-256 over the canonical content of a run: a header, then one link per frame, then the closing part.
// Canonical content is everything in a run except UUID, wall-clock times and time zone, host, tags, notes, and the keys
// that a file assigns (run, branch, frame and event). Program version, commit and build are part of it.
//   chain(0) = H(header: origin, operator, purpose, serials, bench, sensor and recipe texts, overrides, program, seeds,
//                devices)
//   chain(i) = H(chain(i - 1), the i-th frame with the place and attempt of its branch, its counts)
//   content  = H(chain(n), n, events, branches with their voids, checks, series, outcome, reason, safe state)
// Optional data (flags, trace, wrench, checks, series) are included if present, each after its keyword.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/record.h"

namespace tactbench::db {

class RunReader;

using Digest = std::array<std::uint8_t, 32>;
std::string hex(const Digest& digest);

// The content of a run besides its header and its frames.
struct RunEnd {
  std::vector<EventRecord> events;
  std::vector<BranchRecord> branches;
  std::vector<CheckRecord> checks;
  std::vector<SeriesRecord> series;
  Outcome outcome = Outcome::kIncomplete;
  std::string reason;
  SafeState safe = SafeState::kUnknown;
};

// Read from the store, except outcome, reason and safe state, which are those of `run`.
RunEnd end_of(const RunReader& store, const RunRecord& run);

class HashChain {
 public:
  HashChain();
  ~HashChain();
  HashChain(const HashChain&) = delete;
  HashChain& operator=(const HashChain&) = delete;

  // A link is assembled in memory and hashed in one call; the memory is reused for the next link.
  [[nodiscard]] Digest header(const RunRecord& run);
  [[nodiscard]] Digest frame(const Digest& before, const BranchRecord& branch, const FrameRecord& frame);
  [[nodiscard]] Digest close(const Digest& before, std::int64_t frames, const RunEnd& run_end);
  // Digests of the rows stored next to the content.
  [[nodiscard]] Digest fits(const std::vector<FitRecord>& fits);
  [[nodiscard]] Digest verdicts(const std::vector<VerdictRecord>& verdicts);
  [[nodiscard]] Digest approvals(const std::vector<ReportRecord>& reports);
  [[nodiscard]] Digest voided(const RunRecord& run);
  [[nodiscard]] Digest digest(std::span<const std::uint8_t> bytes);

 private:
  // Each value is one letter for its kind, then 8 bytes little-endian: an integer, the bits of a double, or the length
  // of the bytes that follow. Different contents therefore never have the same bytes.
  void begin(std::string_view name);
  template <std::integral Value>
  void add(Value value) {
    raw('i', static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
  }
  void add(double value);  // -0.0 as 0.0 and every NaN as one, since SQLite does not distinguish them
  void add(std::string_view text);
  void add(std::span<const std::uint8_t> bytes);
  void add(const std::vector<double>& values);
  template <class... Values>
  void add(const std::tuple<Values&...>& row) {
    std::apply([&](const auto&... values) { (add(values), ...); }, row);
  }
  void raw(char kind, std::uint64_t value);
  void place(const BranchRecord& branch);
  [[nodiscard]] Digest finish() { return digest(bytes_); }

  struct Context;
  std::unique_ptr<Context> context_;
  std::vector<std::uint8_t> bytes_;
};

// SHA-256 chained over the run's frames, each with the place of its branch, as above but without header and
// closing part: equal for two runs with the same measured frames, whatever program, commit or build carried them out.
// In hex digits. For a run with removed frames, the stored hash. StoreError as RunReader::for_each_frame().
std::string frames_hash(const RunReader& store, std::int64_t run);

}  // namespace tactbench::db
