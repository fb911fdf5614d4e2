#include "bench/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/json_io.h"
#include "db/run_store.h"
#include "devices/fault.h"
#include "sequences/strict_toml.h"

namespace tactbench::bench {

namespace {

ExitCode code_of_fault(const std::string& id) {
  constexpr std::array kByLimit{"TB-CHAMBER-LIMIT", "TB-CHAMBER-TRIP",  "TB-CHAMBER-DISAGREE", "TB-CHAMBER-RATE",
                                "TB-CHAMBER-STALE", "TB-STAGE-LIMIT",   "TB-STAGE-ENVELOPE",   "TB-FORCE-TRIP",
                                "TB-FORCE-STALE",   "TB-GUARD-TRIPPED", "TB-GUARD-NOT-ARMED",  "TB-DEADMAN-FIRED"};
  return std::find(kByLimit.begin(), kByLimit.end(), id) != kByLimit.end() ? ExitCode::kStopped : ExitCode::kDevice;
}

// A table or a model that cannot be read is the user's to mend; data that carry no result are inconclusive.
ExitCode code_of_analysis(const std::string& id) {
  return id.starts_with("TB-TABLE-") || id.starts_with("TB-MODEL-") ? ExitCode::kUsage : ExitCode::kInconclusive;
}

}  // namespace

Error as_error(const std::exception_ptr& exception, const std::string& where) {
  try {
    std::rethrow_exception(exception);
  } catch (const Error& error) {
    return error;
  } catch (const devices::Fault& fault) {
    const std::string place = where.empty() ? fault.device() : where + ", " + fault.device();
    return {code_of_fault(fault.id()), fault.id(), fault.what(), place, fault.remedy()};
  } catch (const sequences::FileError& error) {
    return {ExitCode::kUsage, error.id(), error.what(), error.where(), error.remedy()};
  } catch (const db::StoreError& error) {
    constexpr std::array kByWords{"TB-STORE-NOT-FOUND", "TB-STORE-EXISTS", "TB-STORE-TAG"};
    const bool by_words = std::find(kByWords.begin(), kByWords.end(), error.id()) != kByWords.end();
    const ExitCode code = by_words ? ExitCode::kUsage : ExitCode::kStore;
    return {code, error.id(), error.what(), where, error.remedy()};
  } catch (const analysis::AnalysisError& error) {
    return {code_of_analysis(error.id()), error.id(), error.what(), where, error.remedy()};
  } catch (const std::exception& error) {
    return {ExitCode::kInternal, "TB-INTERNAL", error.what(), where, "this is a defect of tactbench: please report it"};
  } catch (...) {
    return {ExitCode::kInternal, "TB-INTERNAL", "unknown failure", where,
            "this is a defect of tactbench: please report it"};
  }
}

std::string error_text(const Error& error) {
  std::string text = fmt::format("error: {} [{}]\n", error.what(), error.id());
  if (!error.where().empty()) text += fmt::format("  at: {}\n", error.where());
  if (!error.remedy().empty()) text += fmt::format("  try: {}\n", error.remedy());
  text += fmt::format("  state: {}\n", error.rig_state().empty() ? "no device was touched" : error.rig_state());
  return text;
}

std::string error_json(const Error& error) {
  nlohmann::ordered_json json;
  json["schema"] = "tactbench.error";
  json["version"] = 1;
  json["id"] = error.id();
  json["exit_code"] = static_cast<int>(error.code());
  json["message"] = error.what();
  json["where"] = error.where();
  json["remedy"] = error.remedy();
  json["rig_state"] = error.rig_state().empty() ? "no device was touched" : error.rig_state();
  return analysis::printable_json(json, 2) + "\n";
}

}  // namespace tactbench::bench
