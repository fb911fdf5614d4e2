#include "bench/safety/trip.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "analysis/json_io.h"
#include "bench/config.h"
#include "bench/error.h"
#include "bench/utc.h"

namespace tactbench::bench {

namespace {

namespace fs = std::filesystem;

std::string set_variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

// Bench ids are free text.
std::string file_name(std::string id) {
  std::replace_if(
      id.begin(), id.end(), [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '-' && c != '_'; },
      '_');
  return id;
}

[[noreturn]] void fail(const std::string& doing, const std::string& path) {
  throw std::system_error(errno, std::generic_category(), doing + " " + path);
}

class File {
 public:
  File(const std::string& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {
    if (number_ < 0) fail("opening", path);
  }
  ~File() { ::close(number_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

}  // namespace

std::string state_folder() {
  fs::path base;
  if (const std::string given = set_variable("XDG_STATE_HOME"); !given.empty()) {
    base = given;
  } else if (const std::string home = set_variable("HOME"); !home.empty()) {
    base = fs::path(home) / ".local/state";
  } else {
    base = fs::temp_directory_path() / fmt::format("tactbench-state-{}", geteuid());
  }
  const fs::path folder = base / "tactbench";
  std::error_code ignored;  // whoever writes there will complain
  fs::create_directories(folder, ignored);
  ::chmod(folder.c_str(), 0700);
  return folder.string();
}

void write_durably(const std::string& path, const std::string& text) {
  const std::string beside = fmt::format("{}.{}", path, getpid());
  {
    const File file(beside, O_WRONLY | O_CREAT | O_TRUNC);
    if (::write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) || ::fsync(file.get()) != 0)
      fail("writing", beside);
  }
  if (::rename(beside.c_str(), path.c_str()) != 0) fail("moving to", path);
  const File folder(fs::path(path).parent_path().string(), O_RDONLY | O_DIRECTORY);
  if (::fsync(folder.get()) != 0) fail("syncing", path);
}

TripFile::TripFile(const std::string& bench_id)
    : stem_(state_folder() + "/" + file_name(bench_id)), path_(stem_ + ".trip") {}

std::string TripFile::log_path() const { return stem_ + ".log"; }
std::string TripFile::dead_man_path() const { return stem_ + ".dead-man.json"; }

std::optional<Trip> TripFile::read() const {
  std::error_code unknown;
  if (!fs::exists(path_, unknown) && !unknown) return std::nullopt;
  std::ifstream stream(path_);
  const auto json = analysis::try_json(std::string(std::istreambuf_iterator<char>(stream), {}));
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
    const nlohmann::ordered_json json = {{"utc", trip.utc}, {"id", trip.id}, {"what", trip.what}, {"run", trip.run}};
    write_durably(path_, analysis::printable_json(json, 2) + "\n");
    return true;
  } catch (...) {
    return false;
  }
}

void TripFile::reset(const Trip& trip, const std::string& operator_name) const {
  std::ofstream log(log_path(), std::ios::app);
  log << fmt::format("{} reset by {}: {} of {}, run {}: {}\n", utc_now(), operator_name, trip.id, trip.utc, trip.run,
                     trip.what);
  std::error_code error;
  // The line first: a reset that nobody can find again did not happen.
  if (log.flush()) fs::remove(path_, error);
  if (!log || error) {
    throw Error(ExitCode::kUsage, "TB-FILE-WRITE", "cannot remove the trip or write its log", path_,
                "check folder, space and permissions");
  }
}

void refuse_tripped(const BenchConfig& config) {
  if (config.in_process) return;
  const TripFile file(config.id);
  const std::optional<Trip> trip = file.read();
  if (!trip) return;
  throw Error(ExitCode::kStopped, "TB-BENCH-TRIPPED",
              fmt::format("bench '{}' tripped at {} ({}): {}", config.id, trip->utc, trip->id, trip->what), file.path(),
              "look at the rig and find the cause, then: tactbench devices reset --bench FILE --operator NAME");
}

}  // namespace tactbench::bench
