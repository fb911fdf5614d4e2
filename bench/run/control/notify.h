// --on-event: runs the user's command when a run is done, has failed or waits for a person.
#pragma once

#include <cstdint>
#include <string>

namespace tactbench::bench {

class Notify {
 public:
  Notify() = default;
  explicit Notify(std::string command) : command_(std::move(command)) {}
  // Starts `sh -c COMMAND` with TACTBENCH_EVENT (done, failed, waiting), TACTBENCH_RUN and TACTBENCH_REASON in its
  // environment and does not wait for it. A command that cannot be started is reported on standard error and changes
  // nothing.
  void tell(const std::string& event, std::int64_t run, const std::string& reason) const;

 private:
  std::string command_;
};

}  // namespace tactbench::bench
