#include "bench/common/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>

#include "analysis/error.h"
#include "analysis/json_io.h"
#include "bench/common/terminal.h"
#include "db/fleet/postgres.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

namespace {

const ErrorRow& row_of(std::string_view id) {
  const ErrorRow* row = error_row(id);
  return row != nullptr ? *row : ErrorId("TB-INTERNAL").row();
}

}  // namespace

Error::Error(ExitCode code, std::string id, const std::string& message, std::string where, std::string remedy,
             std::string rig_state)
    : std::runtime_error(message),
      code_(code),
      id_(std::move(id)),
      where_(std::move(where)),
      remedy_(remedy.empty() ? std::string(row_of(id_).remedy) : std::move(remedy)),
      rig_state_(std::move(rig_state)) {}

Error Error::by_text(const std::string& id, const std::string& message, std::string where, std::string remedy) {
  return {row_of(id).exit_code, id, message, std::move(where), std::move(remedy)};
}

std::string_view Error::cause() const { return row_of(id_).cause; }

Error Error::by_command() const {
  Error copy = *this;
  copy.asked_for_ = true;
  return copy;
}

Error Error::with_message(const std::string& message) const {
  Error copy = *this;
  static_cast<std::runtime_error&>(copy) = std::runtime_error(message);
  return copy;
}

Error Error::with_remedy(std::string remedy) const {
  Error copy = *this;
  copy.remedy_ = std::move(remedy);
  return copy;
}

Error Error::by_signal(int signal) const {
  Error copy = *this;
  if (signal != 0) copy.code_ = code_of_signal(signal);
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
    return Error::by_text(fault.id(), fault.what(), place, fault.remedy());
  } catch (const sequences::FileError& error) {
    return Error::by_text(error.id(), error.what(), error.where(), error.remedy());
  } catch (const db::StoreError& error) {
    return Error::by_text(error.id(), error.what(), where, error.remedy());
  } catch (const db::fleet::FleetError& error) {
    return Error::by_text(error.id(), error.what(), where, error.remedy());
  } catch (const analysis::AnalysisError& error) {
    return Error::by_text(error.id(), error.what(), where, error.remedy());
  } catch (const std::bad_alloc&) {
    return {"TB-SYSTEM-LIMIT", "too little memory", where};
  } catch (const std::system_error& error) {
    const int number = error.code().value();  // of a thread or process that could not be made
    const bool limit = number == EAGAIN || number == ENOMEM || number == EMFILE || number == ENFILE;
    return {limit ? ErrorId("TB-SYSTEM-LIMIT") : ErrorId("TB-INTERNAL"), error.what(), where};
  } catch (const std::exception& error) {
    return {"TB-INTERNAL", error.what(), where};
  } catch (...) {
    return {"TB-INTERNAL", "unknown failure", where};
  }
}

std::string error_text(const Error& error, bool devices) {
  const bool asked = error.asked_for() && error.code() != ExitCode::kUnsafe;
  const auto line = [](const std::string& text) { return one_line(text, kMaxTextLength); };
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
  json["cause"] = error.cause();
  json["message"] = error.what();
  json["where"] = error.where();
  json["remedy"] = error.remedy();
  json["rig_state"] = error.rig_state().empty() ? "no device was touched" : error.rig_state();
  return analysis::printable_json(json, 2) + "\n";
}

}  // namespace tactbench::bench
