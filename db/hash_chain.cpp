#include "db/hash_chain.h"

#include <openssl/evp.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "db/run_reader.h"
#include "db/store_error.h"

namespace tactbench::db {

struct HashChain::Context {
  // Fetched once: otherwise OpenSSL 3 searches for the algorithm at every digest, which costs more than hashing a
  // frame.
  std::unique_ptr<EVP_MD, decltype(&EVP_MD_free)> algorithm{EVP_MD_fetch(nullptr, "SHA256", nullptr), &EVP_MD_free};
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> state{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

HashChain::HashChain() : context_(std::make_unique<Context>()) {
  if (context_->algorithm && context_->state) return;
  throw StoreError("TB-STORE-SQL", "OpenSSL offers no SHA-256", "check the OpenSSL installation and its configuration");
}
HashChain::~HashChain() = default;

Digest HashChain::digest(std::span<const std::uint8_t> bytes) {
  Digest result{};
  EVP_MD_CTX* state = context_->state.get();
  if (EVP_DigestInit_ex2(state, context_->algorithm.get(), nullptr) != 1 ||
      EVP_DigestUpdate(state, bytes.data(), bytes.size()) != 1 ||
      EVP_DigestFinal_ex(state, result.data(), nullptr) != 1) {
    throw StoreError("TB-STORE-SQL", "OpenSSL failed to compute a SHA-256", "check the OpenSSL installation");
  }
  return result;
}

void HashChain::begin(std::string_view name) {
  bytes_.clear();
  add(name);
}

void HashChain::raw(char kind, std::uint64_t value) {
  std::array<std::uint8_t, 9> bytes{static_cast<std::uint8_t>(kind)};
  for (std::size_t i = 0; i < 8; ++i) bytes[i + 1] = static_cast<std::uint8_t>(value >> (8 * i));
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

void HashChain::add(double value) {
  if (value == 0.0) value = 0.0;
  if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
  raw('r', std::bit_cast<std::uint64_t>(value));
}

void HashChain::add(std::string_view text) {
  raw('t', text.size());
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void HashChain::add(std::span<const std::uint8_t> bytes) {
  raw('b', bytes.size());
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

void HashChain::add(const std::vector<double>& values) {
  add(std::span(reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(double)));
}

Digest HashChain::header(const RunRecord& run) {
  begin("tactbench run 1");
  add(run.content());
  add(run.sequences.size());
  for (const SequenceRecord& sequence : run.sequences) add(sequence.row());
  add(run.devices.size());
  for (const DeviceRecord& device : run.devices) add(device.row());
  return finish();
}

void HashChain::place(const BranchRecord& branch) {
  add(std::tie(branch.sequence, branch.repeat, branch.ordinal, branch.attempt));
}

Digest HashChain::frame(const Digest& before, const BranchRecord& branch, const FrameRecord& frame) {
  begin("frame");
  add(std::span(before));
  place(branch);
  add(std::tie(frame.ordinal, frame.setpoint_psi, frame.feedback_psi, frame.reference_psi, frame.setpoint_counts,
               frame.feedback_counts, frame.reference_counts, frame.time_ns, frame.since_command_ns, frame.in_band_ns,
               frame.device_time_us));
  add("uint16le");
  add(std::tie(frame.status, frame.exchanges, frame.rows, frame.columns, frame.scans));
  const std::size_t size = frame.counts.size() * sizeof(std::uint16_t);
  raw('b', size);
  const std::size_t start = bytes_.size();
  bytes_.resize(start + size);
  if (size > 0) std::memcpy(bytes_.data() + start, frame.counts.data(), size);  // little-endian: see sqlite.h
  if (!frame.flags.empty()) {
    add("flags");
    add(frame.flags);
  }
  if (!frame.trace.empty()) {
    add("trace");
    add(std::span(reinterpret_cast<const std::uint8_t*>(frame.trace.data()), frame.trace.size() * sizeof(TracePoint)));
  }
  if (frame.wrench) {
    add("wrench");
    add(frame.wrench->target_n);
    add(frame.wrench->force_start_n);
    for (const double value : frame.wrench->wrench) add(value);
    for (const double value : frame.wrench->raw) add(value);
    for (const double value : frame.wrench->place_mm) add(value);
  }
  return finish();
}

Digest HashChain::close(const Digest& before, std::int64_t frames, const RunEnd& run_end) {
  begin("end");
  add(std::span(before));
  add(frames);
  add(run_end.events.size());
  for (const EventRecord& event : run_end.events) add(event.row());
  add(run_end.branches.size());
  for (const BranchRecord& branch : run_end.branches) {
    place(branch);
    add(std::tie(branch.is_void, branch.void_reason, branch.from_psi, branch.to_psi));
    if (branch.from_n || branch.to_n) {
      add("force");
      add(branch.from_n.value_or(std::numeric_limits<double>::quiet_NaN()));
      add(branch.to_n.value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  if (!run_end.checks.empty()) {
    add("checks");
    add(run_end.checks.size());
    for (const CheckRecord& check : run_end.checks) {
      add(std::tie(check.time_ns, check.kind, check.verdict, check.detail_json));
      add(check.data.size());
      for (const double value : check.data) add(value);
    }
  }
  if (!run_end.series.empty()) {
    add("series");
    add(run_end.series.size());
    for (const SeriesRecord& series : run_end.series) add(series.row());
  }
  add(to_string(run_end.outcome));
  add(run_end.reason);
  add(to_string(run_end.safe));
  return finish();
}

Digest HashChain::fits(const std::vector<FitRecord>& fits) {
  begin("fits");
  for (const FitRecord& fit : fits) {
    add(fit.fit);
    add(fit.row());
  }
  return finish();
}

Digest HashChain::verdicts(const std::vector<VerdictRecord>& verdicts) {
  begin("verdicts");
  for (const VerdictRecord& v : verdicts) {
    add(v.fit);
    add(v.row());
  }
  return finish();
}

Digest HashChain::approvals(const std::vector<ReportRecord>& reports) {
  begin("approvals");
  for (const ReportRecord& r : reports) {
    add(r.row());
    if (!r.reason.empty()) add("reason: " + r.reason);  // no number begins so
    for (const ReportRecord::Evidence& one : r.evidence) add("evidence: " + one.content_sha256);
  }
  return finish();
}

Digest HashChain::voided(const RunRecord& run) {
  begin("void");
  add(std::tie(run.void_reason, run.void_by, run.void_utc));
  return finish();
}

RunEnd end_of(const RunReader& store, const RunRecord& run) {
  return {store.events(run.run), store.branches(run.run),
          store.checks(run.run), store.series(run.run),
          run.outcome,           run.reason,
          run.safe_state};
}

std::string hex(const Digest& digest) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string sha256_hex(const std::string& text) {
  HashChain chain;
  return hex(chain.digest({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
}

std::string frames_hash(const RunReader& store, std::int64_t run) {
  if (const std::optional<PrunedRecord> pruned = store.pruned(run)) return pruned->frames_sha256;
  std::map<std::int64_t, BranchRecord> branches;
  for (const BranchRecord& branch : store.branches(run)) branches[branch.branch] = branch;
  HashChain hasher;
  Digest chain{};
  store.for_each_frame(run,
                       [&](const FrameRecord& frame) { chain = hasher.frame(chain, branches[frame.branch], frame); });
  return hex(chain);
}

}  // namespace tactbench::db
