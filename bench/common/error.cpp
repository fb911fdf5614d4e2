#include "bench/common/error.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "analysis/error.h"
#include "analysis/json_io.h"
#include "bench/common/for_people.h"
#include "db/fleet/fleet_error.h"
#include "db/run_store.h"
#include "devices/fault.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

namespace {

ExitCode code_of(devices::Cause cause) {
  return cause == devices::Cause::kLimit ? ExitCode::kStopped : ExitCode::kDevice;
}

ExitCode code_of(db::Cause cause) { return cause == db::Cause::kUsage ? ExitCode::kUsage : ExitCode::kStore; }

ExitCode code_of(db::fleet::FleetCause cause) {
  switch (cause) {
    case db::fleet::FleetCause::kUsage:
      return ExitCode::kUsage;
    case db::fleet::FleetCause::kLink:
      return ExitCode::kDevice;
    case db::fleet::FleetCause::kStore:
      break;
  }
  return ExitCode::kStore;
}

ExitCode code_of(analysis::Cause cause) {
  switch (cause) {
    case analysis::Cause::kUsage:
      return ExitCode::kUsage;
    case analysis::Cause::kStored:
      return ExitCode::kStore;
    case analysis::Cause::kNoResult:
      break;
  }
  return ExitCode::kInconclusive;
}

}  // namespace

Error Error::by_word() const {
  Error copy = *this;
  copy.asked_for_ = true;
  return copy;
}

Error Error::with_rig_state(std::string rig_state, bool safe) const {
  Error copy = *this;
  copy.rig_state_ = std::move(rig_state);
  if (!safe) copy.code_ = ExitCode::kUnsafe;
  return copy;
}

Error as_error(const std::exception_ptr& exception, const std::string& where) {
  try {
    std::rethrow_exception(exception);
  } catch (const Error& error) {
    return error;
  } catch (const devices::Fault& fault) {
    const std::string place = where.empty() ? fault.device() : where + ", " + fault.device();
    return {code_of(fault.cause()), fault.id(), fault.what(), place, fault.remedy()};
  } catch (const sequences::FileError& error) {
    return {ExitCode::kUsage, error.id(), error.what(), error.where(), error.remedy()};
  } catch (const db::StoreError& error) {
    return {code_of(error.cause()), error.id(), error.what(), where, error.remedy()};
  } catch (const db::fleet::FleetError& error) {
    return {code_of(error.cause()), error.id(), error.what(), where, error.remedy()};
  } catch (const analysis::AnalysisError& error) {
    return {code_of(error.cause()), error.id(), error.what(), where, error.remedy()};
  } catch (const std::exception& error) {
    return {ExitCode::kInternal, "TB-INTERNAL", error.what(), where, "this is a defect of tactbench: please report it"};
  } catch (...) {
    return {ExitCode::kInternal, "TB-INTERNAL", "unknown failure", where,
            "this is a defect of tactbench: please report it"};
  }
}

std::string error_text(const Error& error, bool devices) {
  const bool asked = error.asked_for() && error.code() != ExitCode::kUnsafe;
  const auto line = [](const std::string& text) { return one_line(text, kLongestText); };
  std::string text = fmt::format("{}{} [{}]\n", asked ? "" : "error: ", line(error.what()), line(error.id()));
  if (!error.where().empty()) text += fmt::format("  at: {}\n", line(error.where()));
  if (!error.remedy().empty()) text += fmt::format("  try: {}\n", line(error.remedy()));
  if (!error.rig_state().empty()) {
    text += fmt::format("  state: {}\n", line(error.rig_state()));
  } else if (devices) {
    text += "  state: no device was touched\n";
  }
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
