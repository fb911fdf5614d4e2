// The error type of this room: a stable identifier, the fault and its place, and how to correct it.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::analysis {

// Escapes NUL characters from file contents, at which what() would end.
inline std::string without_nul(std::string message) {
  for (std::size_t at = 0; (at = message.find('\0', at)) != std::string::npos;) message.replace(at, 1, "\\x00");
  return message;
}

// A name for a message; it may be empty.
inline std::string or_not_stated(const std::string& name) { return name.empty() ? "(not stated)" : name; }

// What kind of failure it is; the exit code depends on this alone, not on the id.
enum class Cause {
  kNoResult,  // the data carry no result
  kUsage,     // a file, a model or a name that the user gave, and can correct
  kStored,    // what the store holds cannot be read
};

class AnalysisError : public std::runtime_error {
 public:
  AnalysisError(Cause cause, std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(without_nul(message)), cause_(cause), id_(std::move(id)), remedy_(std::move(remedy)) {}
  // With cause kNoResult.
  AnalysisError(std::string id, const std::string& message, std::string remedy)
      : AnalysisError(Cause::kNoResult, std::move(id), message, std::move(remedy)) {}
  [[nodiscard]] Cause cause() const { return cause_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  Cause cause_;
  std::string id_, remedy_;
};

}  // namespace tactbench::analysis
