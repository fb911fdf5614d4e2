// A store's file with changed bytes: opened, read, verified, resumed and written through the room's own functions. An
// input is a list of changes, six bytes each: where (4, little-endian, modulo the file), what kind, and a byte.
// Nothing but a StoreError may come of it.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "db/run_store.h"

using namespace tactbench;

namespace {

constexpr std::size_t kChange = 6;
constexpr std::size_t kPage = 4096;

const std::string& folder() {
  static const std::string& made = *[] {  // outlives what is called at exit
    std::string name =
        std::filesystem::is_directory("/dev/shm") ? "/dev/shm/tactbench-fuzz-XXXXXX" : "/tmp/tactbench-fuzz-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    std::atexit([] { std::filesystem::remove_all(folder()); });
    return new std::string(name);
  }();
  return made;
}

std::string path() { return folder() + "/runs.db"; }

void clear() {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) ::unlink((path() + ending).c_str());
}

// A stopped run with all kinds of rows, and a second one that has a fit.
std::string small_store() {
  clear();
  {
    db::RunStore store = db::RunStore::open(path(), db::Durability::kNormal);
    store.add_sensor({"S-1", "array", "rows = 2\n", db::sha256_hex("rows = 2\n"), "SC-1", "", "2026"});
    for (int number = 1; number <= 2; ++number) {
      db::RunRecord record;
      record.origin = "simulated";
      record.state = "prepared";
      record.sensor_serial = "S-1";
      record.seed = number;
      record.bench_toml = std::string(6000, '#');
      record.sequences = {{0, "up", "recipe", "r", 1, 4}};
      record.devices = {{"tactile scanner", "T", "SC-1", "1", "simulated", R"({"volts_per_count":0.1})"}};
      const std::int64_t run = store.begin_run(record);
      db::BranchRecord begun;
      begun.to_psi = 60.0;
      const std::int64_t branch = store.begin_branch(run, begun);
      for (int i = 0; i < 4; ++i) {
        db::FrameRecord frame;
        frame.branch = branch;
        frame.ordinal = i;
        frame.rows = frame.columns = frame.scans = 2;
        frame.counts.assign(8, static_cast<std::uint16_t>(1000 * i));
        frame.trace = {{1.0F, 2.0F, 3.0F, 4.0F}};
        frame.wrench.emplace();
        store.append_frame(run, frame);
      }
      store.append_check(run, {run, 1, "seating", "pass", "{}", {1.0, 2.0}});
      store.append_series(run, {{0, 1, {1.0, 2.0}, {3.0, 4.0}}});
      store.end_run(run, db::Outcome::kStopped, "stopped", db::SafeState::kVerified, "2026");
    }
    store.add_fit({0, 2, "elam", true, 1, R"({"taxels":[{"taxel":0,"noise":0.1}]})", "", "1", "2026"});
    db::VerdictRecord verdict;
    verdict.verdict = "pass";
    store.replace_verdicts(2, 1, {verdict});
    store.add_report({2, "2-a", "a", "K. Lee", "2026", "", ""});
    store.replace_figures(2, "rig", {{"x", 1.0}});
    store.add_baseline({0, "rig", "made", "K. Lee", "2026", {2}});
  }
  std::ifstream stream(path(), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string changed(const std::string& whole, const std::uint8_t* data, std::size_t size) {
  std::string bytes = whole;
  for (; size >= kChange; data += kChange, size -= kChange) {
    const std::size_t place = (data[0] | data[1] << 8 | data[2] << 16 | static_cast<std::uint32_t>(data[3]) << 24);
    const std::size_t at = place % bytes.size();
    switch (data[4] % 4) {
      case 0:
        bytes[at] = static_cast<char>(data[5]);
        break;
      case 1:  // within the header of the file or of a page, where one byte says most
        bytes[at / kPage * kPage + at % (at < kPage ? 100 : 12)] = static_cast<char>(data[5]);
        break;
      case 2: {  // a page in another's place
        const std::string page = bytes.substr(at / kPage * kPage, kPage);
        const std::size_t to = data[5] * kPage % bytes.size();
        bytes.replace(to, std::min(page.size(), bytes.size() - to), page);
        break;
      }
      default:
        if (at > kPage) bytes.resize(at);
    }
  }
  return bytes;
}

void read_all(const db::RunStore& store) {
  (void)store.check_structure();
  for (const db::RunRecord& run : store.runs()) {
    (void)store.run(run.run);
    (void)store.check_content(run.run);
    (void)store.check_seals(run.run);
    (void)store.frames(run.run);
    (void)store.events(run.run);
    (void)store.checks(run.run);
    (void)store.series(run.run);
    (void)store.verdicts(run.run);
    (void)store.reports(run.run);
    for (const db::FitRecord& fit : store.fits(run.run)) (void)store.fit(fit.fit);
  }
  (void)store.sensors();
  (void)store.figures("");
  (void)store.baselines();
  (void)store.timed_sequences("", 10);
}

void resume(db::RunStore& store) {
  (void)store.mark_interrupted("2026");
  store.reopen_run(1, {9, "state", "", "resumed"});
  const std::int64_t branch = store.begin_branch(1, {.ordinal = 1});
  db::FrameRecord frame;
  frame.branch = branch;
  frame.rows = frame.columns = frame.scans = 1;
  frame.counts = {7};
  store.append_frame(1, frame);
  store.end_run(1, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026");
}

template <class Use>
void only_store_errors(Use use) {
  try {
    use();
  } catch (const db::StoreError& error) {
    if (error.id().empty() || error.remedy().empty()) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string whole = small_store();
  clear();
  const std::string bytes = changed(whole, data, size);
  std::ofstream(path(), std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  only_store_errors([] { read_all(db::RunStore::open_read_only(path())); });
  only_store_errors([] {
    db::RunStore store = db::RunStore::open(path(), db::Durability::kNormal);
    only_store_errors([&] { store.add_note(2, "a note"); });
    resume(store);
    read_all(store);
  });
  return 0;
}
