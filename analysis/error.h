// The error type of analysis/: a stable identifier, the fault, its place, and the remedy.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::analysis {

// Escapes NUL characters from file contents, because what() would end there.
inline std::string without_nul(std::string message) {
  for (std::size_t at = 0; (at = message.find('\0', at)) != std::string::npos;) message.replace(at, 1, "\\x00");
  return message;
}

// A name for use in a message; it may be empty.
inline std::string or_not_stated(const std::string& name) { return name.empty() ? "(not stated)" : name; }

class AnalysisError : public std::runtime_error {
 public:
  AnalysisError(std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(without_nul(message)), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string id_, remedy_;
};

}  // namespace tactbench::analysis
