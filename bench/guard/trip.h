// A trip that survives restarts of the program and the computer: one small file per bench, which only a person removes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bench/config/config.h"

namespace tactbench::bench {

struct Trip {
  std::string id;    // "TB-CHAMBER-TRIP"
  std::string what;  // for people
  std::int64_t run = 0;
  std::string utc;  // when; filled in by store()
};

// The machine's folder for trips, shared by all users who may run a rig; the installed package creates it.
inline constexpr const char* kMachineState = "/var/lib/tactbench";

// $XDG_STATE_HOME/tactbench, else `machine` if it exists, else ~/.local/state/tactbench, else (no HOME) below the
// system's temporary folder; the user's own folders are made when absent, mode 0700. Throws Error TB-FOLDER-UNSAFE if
// it belongs neither to this user alone nor to root for a group, TB-STATE-DENIED when the machine's is closed to this
// user.
std::string state_folder(const std::string& machine = kMachineState);

class TripFile {
 public:
  explicit TripFile(const std::string& bench_id);
  // None: not tripped. A file that cannot be read, a link and another user's file are trips, too.
  [[nodiscard]] std::optional<Trip> read() const;
  // Written to a temporary file, synced and renamed; an earlier trip is kept, because the first cause counts. False:
  // could not be stored.
  bool store(Trip trip) const noexcept;
  // Removes the trip and appends a line to the log next to it. Throws Error TB-FILE-WRITE.
  void reset(const Trip& trip, const std::string& operator_name) const;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string log_path() const;
  [[nodiscard]] std::string dead_man_path() const;  // record of what the dead-man did last

 private:
  std::string stem_, path_;
};

// Throws Error TB-BENCH-TRIPPED (exit 4), naming the trip and how to reset it. A bench simulated in its own process
// keeps trips only in memory.
void refuse_tripped(const BenchConfig& config);

// Replaces `path` by `text`: written next to it, synced, moved. Throws std::system_error.
void write_durably(const std::string& path, const std::string& text);

}  // namespace tactbench::bench
