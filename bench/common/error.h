// The error type of the program, for every error that is shown to a person: what happened, where, the remedy, and the
// state in which the rig was left. The identifier is in bench/common/error_table.h, which gives exit code, cause and
// remedy.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/common/error_table.h"

namespace tactbench::bench {

// An identifier of the table; any other literal does not compile.
class ErrorId {
 public:
  consteval ErrorId(const char* id) : row_(error_row(id)) {  // NOLINT: Error("TB-USAGE", ...)
    if (row_ == nullptr) throw "not in kErrorTable";
  }
  [[nodiscard]] const ErrorRow& row() const { return *row_; }

 private:
  const ErrorRow* row_;
};

class Error : public std::runtime_error {
 public:
  // `remedy`: only where the caller knows more than the table (a name, a number, a command with its arguments).
  Error(ErrorId id, const std::string& message, std::string where, std::string remedy = {}, std::string rig_state = {})
      : Error(id.row().exit_code, std::string(id.row().id), message, std::move(where), std::move(remedy),
              std::move(rig_state)) {}
  // For an identifier that comes from another library or process; one that the table lacks has the exit code kInternal.
  static Error by_text(const std::string& id, const std::string& message, std::string where, std::string remedy);
  Error(ExitCode code, std::string id, const std::string& message, std::string where, std::string remedy,
        std::string rig_state = {});
  [[nodiscard]] ExitCode code() const { return code_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }
  [[nodiscard]] const std::string& rig_state() const { return rig_state_; }

  [[nodiscard]] std::string_view cause() const;  // from the table

  // The same error marked as the result of an operator's command, not a failure: error_text() then omits "error".
  [[nodiscard]] Error by_command() const;
  [[nodiscard]] bool asked_for() const { return asked_for_; }
  [[nodiscard]] Error with_message(const std::string& message) const;
  [[nodiscard]] Error with_remedy(std::string remedy) const;
  // With the exit code of the signal that ended the program; 0: none did.
  [[nodiscard]] Error by_signal(int signal) const;
  // The same error with the state that the rig was left in; `safe` false: with the exit code kUnsafe.
  [[nodiscard]] Error with_rig_state(std::string rig_state, bool safe) const;

 private:
  ExitCode code_;
  std::string id_, where_, remedy_, rig_state_;
  bool asked_for_ = false;
};

// Converts the error types of the libraries. `where` is used if the error does not name a place.
Error as_error(const std::exception_ptr& exception, const std::string& where = {});

// Up to four lines, each through terminal_safe() and of bounded length: what happened (without "error" for an
// operator's command), where, the remedy, and the rig's state; without a state "no device was touched", if `devices`.
std::string error_text(const Error& error, bool devices = true);
std::string error_json(const Error& error);

}  // namespace tactbench::bench
