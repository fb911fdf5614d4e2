#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "bench/common/file_text.h"
#include "bench/common/utc.h"
#include "bench/selfcheck/selfcheck.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

namespace fs = std::filesystem;

constexpr int kCheckedFrames = 60;

db::FrameRecord checked_frame(int i) {
  db::FrameRecord frame;
  frame.rows = frame.columns = 16;
  frame.scans = 1;
  frame.ordinal = i;
  frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = 0.1 * i;
  frame.time_ns = 2'000'000'000LL * i;
  for (std::size_t t = 0; t < 256; ++t)
    frame.counts.push_back(static_cast<std::uint16_t>(static_cast<std::size_t>(i) * 251 + t * 7 + 1));
  return frame;
}

struct CheckedRun {
  std::int64_t run = 0, branch = 0;
};
CheckedRun begin_checked(db::RunStore& store) {
  store.add_sensor({"SELFCHECK", "synthetic", "", db::sha256_hex(""), "SIM-SCANNER-1", "", utc_now()});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = "SELFCHECK";
  run.started_utc = utc_now();
  run.sequences = {{0, "frames", "", "", 1, kCheckedFrames}};
  CheckedRun begun;
  begun.run = store.begin_run(run);
  begun.branch = store.begin_branch(begun.run, {});
  return begun;
}

void append_checked(db::RunStore& store, const CheckedRun& begun, int i) {
  db::FrameRecord frame = checked_frame(i);
  frame.branch = begun.branch;
  store.append_frame(begun.run, frame);
}

std::int64_t write_checked(const std::string& path) {
  db::RunStore store = db::RunStore::open(path);
  const CheckedRun begun = begin_checked(store);
  for (int i = 0; i < kCheckedFrames; ++i) append_checked(store, begun, i);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, utc_now());
  return begun.run;
}

SelfcheckAnswer durable_write(const std::string& folder) {
  const std::string path = folder + "/durable";
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) throw std::system_error(errno, std::generic_category(), path);
  const std::array<char, 512> bytes{};
  constexpr int kWrites = 50;
  const auto start = std::chrono::steady_clock::now();
  bool good = true;
  for (int i = 0; i < kWrites; ++i)
    good = good && ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()) &&
           ::fdatasync(file) == 0;
  const int reason = errno;
  const double taken = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ::close(file);
  if (!good) throw std::system_error(reason, std::generic_category(), "write and fdatasync");
  return {taken / kWrites < 500.0, fmt::format("{:.2g} ms each", taken / kWrites)};
}

SelfcheckAnswer read_back(const std::string& path) {
  const std::int64_t run = write_checked(path);
  const db::RunStore store = db::RunStore::open_read_only(path);
  int equal = 0;
  const std::vector<db::FrameRecord> frames = store.frames(run);
  for (int i = 0; i < kCheckedFrames && static_cast<std::size_t>(i) < frames.size(); ++i) {
    const db::FrameRecord written = checked_frame(i);
    const db::FrameRecord& read = frames[static_cast<std::size_t>(i)];
    equal +=
        read.counts == written.counts && read.time_ns == written.time_ns && read.reference_psi == written.reference_psi
            ? 1
            : 0;
  }
  const std::vector<std::string> wrong = store.check_structure();
  const bool content = store.check_content(run).holds();
  return {
      equal == kCheckedFrames && frames.size() == static_cast<std::size_t>(kCheckedFrames) && wrong.empty() && content,
      fmt::format("{} of {} frames equal, content hash {}, structure {}", equal, frames.size(),
                  content ? "holds" : "DIFFERS", wrong.empty() ? "sound" : wrong.front())};
}

// A child process writes frames endlessly and reports each commit; it is killed after 25.
int killed_writer(const std::string& path) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const pid_t writer = ::fork();
  if (writer < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (writer == 0) {
    ::close(ends[0]);
    ::signal(SIGPIPE, SIG_IGN);
    try {
      db::RunStore store = db::RunStore::open(path);
      const CheckedRun begun = begin_checked(store);
      for (int i = 0; i < 100000; ++i) {
        append_checked(store, begun, i);
        const char done = 1;
        if (::write(ends[1], &done, 1) != 1) break;
      }
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  ::close(ends[1]);
  int acknowledged = 0;
  for (char done = 0; acknowledged < 25 && ::read(ends[0], &done, 1) == 1;) ++acknowledged;
  ::kill(writer, SIGKILL);
  for (char done = 0; ::read(ends[0], &done, 1) == 1;) ++acknowledged;  // committed before the signal came
  ::close(ends[0]);
  int status = 0;
  ::waitpid(writer, &status, 0);
  return acknowledged;
}

SelfcheckAnswer survive_kill(const std::string& path) {
  const int acknowledged = killed_writer(path);
  db::RunStore store = db::RunStore::open(path);
  const int closed = store.mark_interrupted(utc_now());
  const std::int64_t frames = store.frame_count(1);
  const bool content = store.check_content(1).holds(), sound = store.check_structure().empty();
  return {acknowledged >= 25 && frames >= acknowledged && closed == 1 && content && sound,
          fmt::format("{} acknowledged, {} there, content hash {}", acknowledged, frames,
                      content && sound ? "holds" : "DIFFERS")};
}

// A byte of the counts of each tenth frame, found in the file by the frame's own bytes.
SelfcheckAnswer name_flipped(const std::string& path, std::int64_t run) {
  const std::string whole = file_text(path), copy = path + ".flipped";
  int flipped = 0, named = 0;
  std::string last;
  for (int i = 5; i < kCheckedFrames; i += 10) {
    const db::FrameRecord frame = checked_frame(i);
    const std::string counts(reinterpret_cast<const char*>(frame.counts.data()), 2 * frame.counts.size());
    const std::size_t place = whole.find(counts);
    if (place == std::string::npos) continue;
    std::string damaged = whole;
    damaged[place + 100] = static_cast<char>(damaged[place + 100] ^ 0x10);
    std::ofstream(copy, std::ios::binary | std::ios::trunc) << damaged;
    ++flipped;
    last = db::RunStore::open_read_only(copy).check_content(run).difference;
    named += last.find(fmt::format("frame {} (", i + 1)) != std::string::npos ? 1 : 0;
  }
  return {flipped == 6 && named == 6, fmt::format("{} of {} named; the last: {}", named, flipped, last)};
}

}  // namespace

SelfcheckLines check_store(const std::string& folder) {
  const std::string path = folder + "/selfcheck.db";
  SelfcheckLines lines;
  lines.push_back(selfchecked("store", "50 writes of 512 bytes with fdatasync in the store's folder",
                              "each is acknowledged, in less than 500 ms", [&] { return durable_write(folder); }));
  lines.push_back(
      selfchecked("store", fmt::format("a run of {} frames written and read back", kCheckedFrames),
                  fmt::format("{0} of {0} frames equal, content hash holds, structure sound", kCheckedFrames),
                  [&] { return read_back(path); }));
  lines.push_back(selfchecked("store", "a process killed by SIGKILL while it wrote frames",
                              "every acknowledged frame is there, content hash holds",
                              [&] { return survive_kill(folder + "/killed.db"); }));
  lines.push_back(selfchecked("store", "one bit of a frame's counts flipped in the file, 6 frames",
                              "the frame is named, 6 of 6", [&] { return name_flipped(path, 1); }));
  return lines;
}

}  // namespace tactbench::bench
