// The error type of db/fleet/: a failure between a bench and the fleet's PostgreSQL, with an identifier TB-FLEET-*.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::db::fleet {

// The kind of failure; the exit code depends only on this.
enum class FleetCause {
  kLink,   // the server cannot be reached, refuses the login, or was lost: try again later
  kStore,  // the fleet cannot store or return the data: schema, disk, rights, or a difference in content
  kUsage,  // a named object does not exist, or the command is wrong; nothing was changed
};

class FleetError : public std::runtime_error {
 public:
  FleetError(FleetCause cause, std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(message), cause_(cause), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] FleetCause cause() const { return cause_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  FleetCause cause_;
  std::string id_, remedy_;
};

}  // namespace tactbench::db::fleet
