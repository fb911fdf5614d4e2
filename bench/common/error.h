// Every error that reaches a person: what, where, how to mend it, and the state the rig was left in; its exit code
// (docs/rules.md, Exit codes) and its stable identifier.
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
  kHungUp = 129,  // from here on 128 and the signal's number, after the safe state
  kInterrupted = 130,
  kQuit = 131,
  kUser1 = 138,
  kUser2 = 140,
  kTerminated = 143,
};
constexpr ExitCode code_of_signal(int number) { return static_cast<ExitCode>(128 + number); }

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

  // The same as the result of an operator's command, not a failure: error_text() does not call it an error.
  [[nodiscard]] Error by_word() const;
  [[nodiscard]] bool asked_for() const { return asked_for_; }
  // The same error with the state that the rig was left in; `safe` false: with the exit code kUnsafe.
  [[nodiscard]] Error with_rig_state(std::string rig_state, bool safe) const;

 private:
  ExitCode code_;
  std::string id_, where_, remedy_, rig_state_;
  bool asked_for_ = false;
};

// Converts the rooms' own errors. `where` is used when the room's error names no place.
Error as_error(const std::exception_ptr& exception, const std::string& where = {});

// Up to four lines, each through for_people() and of bounded length: what (without "error" where the operator asked for
// it), where, how to mend it, and the rig's state; without a state "no device was touched", where a device could have
// been.
std::string error_text(const Error& error, bool devices = true);
std::string error_json(const Error& error);

}  // namespace tactbench::bench
