#include "bench/guard/trip.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"

namespace tactbench::bench {

namespace {

namespace fs = std::filesystem;

std::string set_variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

[[noreturn]] void fail(const std::string& doing, const std::string& path) {
  throw std::system_error(errno, std::generic_category(), doing + " " + path);
}

class File {
 public:
  File(const std::string& path, int flags) : number_(open_private_file(path, flags)) {
    if (number_ < 0) fail("opening", path);
  }
  ~File() { ::close(number_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  void write(const std::string& text, const std::string& path) const {
    if (::write(number_, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || ::fsync(number_) != 0)
      fail("writing", path);
  }
  [[nodiscard]] std::string read() const {
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t size = 1; size > 0 && text.size() < kLongestFile;) {
      size = ::read(number_, part.data(), part.size());
      if (size > 0) text.append(part.data(), static_cast<std::size_t>(size));
    }
    return text;
  }

 private:
  static constexpr std::size_t kLongestFile = 1 << 20;
  int number_;
};

void sync_folder(const std::string& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = folder >= 0 && ::fsync(folder) == 0;
  if (folder >= 0) ::close(folder);
  if (!synced) fail("syncing", path);
}

}  // namespace

std::string state_folder(const std::string& machine) {
  fs::path base;
  if (const std::string given = set_variable("XDG_STATE_HOME"); !given.empty()) {
    base = given;
  } else if (is_group_folder(machine)) {
    if (::faccessat(AT_FDCWD, machine.c_str(), R_OK | W_OK | X_OK, AT_EACCESS) == 0) return machine;
    throw Error("TB-STATE-DENIED",
                fmt::format("user {} may not read the trip records of this machine's rigs", geteuid()), machine);
  } else if (const std::string home = set_variable("HOME"); !home.empty()) {
    base = fs::path(home) / ".local/state";
  } else {
    base = fs::path(temporary_folder()) / fmt::format("tactbench-state-{}", geteuid());
    make_private_folder(base.string());  // another user may have made it
  }
  std::error_code ignored;  // making the folder in it reports the error
  fs::create_directories(base, ignored);
  const fs::path folder = base / "tactbench";
  make_private_folder(folder.string());
  return folder.string();
}

void write_durably(const std::string& path, const std::string& text) {
  const std::string temporary = fmt::format("{}.{}", path, getpid());
  {
    const File file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    file.write(text, temporary);
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail("moving to", path);
  sync_folder(fs::path(path).parent_path().string());
}

TripFile::TripFile(const std::string& bench_id)
    : stem_(state_folder() + "/" + file_name(bench_id)), path_(stem_ + ".trip") {}

std::string TripFile::log_path() const { return stem_ + ".log"; }
std::string TripFile::dead_man_path() const { return stem_ + ".dead-man.json"; }

std::optional<Trip> TripFile::read() const {
  std::error_code unknown;
  if (fs::symlink_status(path_, unknown).type() == fs::file_type::not_found) return std::nullopt;
  std::string text;
  try {
    text = File(path_, O_RDONLY).read();
  } catch (const std::system_error&) {  // another user's, or a link: counts as a trip
  }
  const auto json = analysis::try_json(text);
  Trip trip{"TB-TRIP-UNREADABLE", "the trip's file cannot be read", 0, "unknown"};
  if (json.is_discarded() || !json.is_object()) return trip;
  trip.id = json.value("id", trip.id);
  trip.what = json.value("what", trip.what);
  trip.run = json.value("run", trip.run);
  trip.utc = json.value("utc", trip.utc);
  return trip;
}

bool TripFile::store(Trip trip) const noexcept {
  try {
    if (read()) return true;
    trip.utc = utc_now();
    const nlohmann::ordered_json json = {JSON_FIELDS(trip, utc, id, what, run)};
    write_durably(path_, analysis::printable_json(json, 2) + "\n");
    return true;
  } catch (...) {
    return false;
  }
}

void TripFile::reset(const Trip& trip, const std::string& operator_name) const {
  // The log line first: no reset without a record of it.
  try {
    File(log_path(), O_WRONLY | O_CREAT | O_APPEND)
        .write(fmt::format("{} reset by {}: {} of {}, run {}: {}\n", utc_now(), operator_name, trip.id, trip.utc,
                           trip.run, trip.what),
               log_path());
    fs::remove(path_);
  } catch (const std::system_error&) {
    throw Error("TB-FILE-WRITE", "cannot remove the trip or write its log", path_);
  }
}

void refuse_tripped(const BenchConfig& config) {
  if (config.in_process) return;
  const TripFile file(config.id);
  const std::optional<Trip> trip = file.read();
  if (!trip) return;
  throw Error("TB-BENCH-TRIPPED",
              fmt::format("bench '{}' tripped at {} ({}): {}", config.id, trip->utc, trip->id, trip->what),
              file.path());
}

}  // namespace tactbench::bench
