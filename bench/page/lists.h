// The store's runs and sensors for the page, as `tactbench runs list --json` and `sensors list --json` tell them.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "db/run_store.h"

namespace tactbench::bench {

inline constexpr std::size_t kListedRuns = 500;  // the newest

// Newest first, void ones too; `left_out`: older ones.
nlohmann::ordered_json runs_list(const db::RunStore& store);
// With the numbers of each sensor's runs, newest first, and whether figures of it are kept.
nlohmann::ordered_json sensors_list(const db::RunStore& store);
// Whether the store keeps figures of nights, and of which subjects.
nlohmann::ordered_json nights_list(const db::RunStore& store);

}  // namespace tactbench::bench
