// What `run` and `resume` share: a run of the store opened again.
#pragma once

#include <cstdint>
#include <string>

namespace tactbench::bench {

struct Session;

struct ResumeOptions {
  std::string bench;     // bench file; empty: as stored with the run
  std::string on_event;  // command; empty: none
  bool assume_yes = false;
};

// Opens run `number` of session.db again and carries it to its end; prints as `run` does. Throws Error and what a run
// throws.
void resume_run(std::int64_t number, const ResumeOptions& options, Session& session);

}  // namespace tactbench::bench
