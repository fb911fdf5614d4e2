// Every error that reaches a person: what, where, how to mend it, and the state the rig was left in; its exit code
// (contract.md, "Exit codes") and its stable identifier.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::bench {

enum class ExitCode {
  kPass = 0,
  kCriterionFailed = 1,
  kUsage = 2,  // usage or configuration, nothing touched
  kDevice = 3,
  kStopped = 4,  // operator, interlock or limit
  kStore = 5,
  kInconclusive = 6,
  kUnsafe = 7,  // safe state not verified: outranks all
  kInternal = 70,
  kInterrupted = 130,
  kTerminated = 143,
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, std::string id, const std::string& message, std::string where, std::string remedy,
        std::string rig_state = {})
      : std::runtime_error(message),
        code_(code),
        id_(std::move(id)),
        where_(std::move(where)),
        remedy_(std::move(remedy)),
        rig_state_(std::move(rig_state)) {}
  [[nodiscard]] ExitCode code() const { return code_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }
  [[nodiscard]] const std::string& rig_state() const { return rig_state_; }

 private:
  ExitCode code_;
  std::string id_, where_, remedy_, rig_state_;
};

// The rooms' own errors as an Error. `where` is used where the room's error does not say.
Error as_error(const std::exception_ptr& exception, const std::string& where = {});

// The four lines of ux.md 4.3.
std::string error_text(const Error& error);
std::string error_json(const Error& error);

}  // namespace tactbench::bench
