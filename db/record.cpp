#include "db/record.h"

#include <array>

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

}  // namespace tactbench::db
