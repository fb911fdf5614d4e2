// The one error type of this room: a stable identifier, what was wrong where, and how to mend it.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::analysis {

class AnalysisError : public std::runtime_error {
 public:
  AnalysisError(std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(message), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string id_, remedy_;
};

}  // namespace tactbench::analysis
