// Writing a run: what is refused before it reaches the file, and what several programs or a death leave of it.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::Durability;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("run store: rows that contradict the run are refused and leave nothing") {
  NewStore store;
  const std::int64_t ended = store_example(store);
  const Begun begun = begin_example(store);
  const std::string before = store.content_hash(begun.run);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.counts.pop_back();
  CHECK(store_error([&] { store.append_frame(begun.run, frame); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.append_frame(begun.run, example_frame(1, 0)); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.void_branch(1, "late"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.set_state(begun.run, "ended", {}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.end_run(begun.run, db::Outcome::kIncomplete, "", {}, ""); }) == "TB-STORE-CONFLICT");
  // That it has ended is reported first, whatever else is wrong.
  RunStore reader = RunStore::open_read_only(store.path());
  CHECK(store_error([&] { reader.end_run(ended, db::Outcome::kFailed, "", {}, ""); }) == "TB-STORE-CONFLICT");
  CHECK(store.content_hash(begun.run) == before);
  store.set_devices(begun.run, {});
  CHECK(store.run(begun.run).devices.empty());
  frame = example_frame(begun.branch, 0);
  frame.setpoint_psi =
      std::numeric_limits<double>::quiet_NaN();  // the database itself refuses: the chain must not have advanced
  CHECK(store_error([&] { store.append_frame(begun.run, frame); }) == "TB-STORE-CONFLICT");
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.set_devices(begun.run, {}); }) == "TB-STORE-CONFLICT");
  store.end_run(begun.run, db::Outcome::kFailed, "r", db::SafeState::kFailed, "");
  CHECK(store.run(begun.run).content_sha256 == store.content_hash(begun.run));
}

TEST_CASE("run store: interleaved frames of two branches and two runs each keep their own branch") {
  NewStore store;
  const Begun one = begin_example(store), other = begin_example(store);
  db::BranchRecord next = example_branch();
  next.ordinal = 1;
  const std::int64_t second = store.begin_branch(one.run, next);
  for (int i = 0; i < 3; ++i) {
    store.append_frame(one.run, example_frame(one.branch, i));
    store.append_frame(one.run, example_frame(second, i));
    store.append_frame(other.run, example_frame(other.branch, i));
  }
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  store.append_frame(other.run, example_frame(other.branch, 3));
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  for (const std::int64_t run : {one.run, other.run}) {
    store.end_run(run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    CHECK(store.check_content(run).holds());
    CHECK(store.content_hash(run) == store.run(run).content_sha256);
  }
  CHECK((store.frame_count(one.run) == 6 && store.frame_count(other.run) == 4));
}

TEST_CASE("run store: a void branch accepts no frame, from its own run or another") {
  NewStore store;
  const Begun begun = begin_example(store);
  REQUIRE(begun.run == 1);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.void_branch(begun.branch, "scanner lost");
  CHECK(store_error([&] { store.append_frame(begun.run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
  CHECK(store.frame_count(begun.run) == 1);
  const std::int64_t other_run = store.begin_run(example_run());
  CHECK(store_error([&] { store.append_frame(other_run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("run store: names of a run and of a sensor have a maximum length") {
  NewStore store;
  const std::string longest(db::kMaxNameLength, 'n'), longer = longest + 'n';
  for (std::string db::SensorRecord::*member :
       {&db::SensorRecord::serial, &db::SensorRecord::type, &db::SensorRecord::scanner_serial}) {
    db::SensorRecord sensor = example_sensor();
    sensor.serial = "S-" + std::to_string(store.sensors().size());
    sensor.*member = longer;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-TOO-LONG");
    sensor.*member = longest;
    CHECK(store_error([&] { store.add_sensor(sensor); }).empty());
  }
  CHECK(store.sensors().size() == 3);
  store.add_sensor(example_sensor());
  for (std::string db::RunRecord::*member :
       {&db::RunRecord::operator_name, &db::RunRecord::scanner_serial, &db::RunRecord::bench_id}) {
    db::RunRecord run = example_run();
    run.*member = longer;
    CHECK(store_error([&] { store.begin_run(run); }) == "TB-STORE-TOO-LONG");
    run.*member = longest;
    CHECK(store_error([&] { store.begin_run(run); }).empty());
  }
  CHECK(store.runs().size() == 3);
}

TEST_CASE("run store: a sensor is registered once, and not again with another type or scanner") {
  NewStore store;
  store.add_sensor(example_sensor());
  store.add_sensor(example_sensor());
  db::SensorRecord second = example_sensor();
  second.serial = "A-2";
  second.scanner_serial = "SC-9";
  second.note = "other";
  store.add_sensor(second);
  const auto sensors = store.sensors();
  REQUIRE(sensors.size() == 2);
  CHECK((sensors[0].serial == "A-2" && sensors[0].scanner_serial == "SC-9" && sensors[0].note == "other"));
  CHECK((sensors[1].type == "array-3x2" && sensors[1].type_toml == "rows = 3\n" && sensors[1].added_utc != ""));
  CHECK(sensors[1].type_sha256 == example_sensor().type_sha256);
  CHECK_FALSE(store.sensor("none"));
  db::SensorRecord other_type = example_sensor();
  other_type.type_sha256 = "other";
  CHECK(store_error([&] { store.add_sensor(other_type); }) == "TB-STORE-CONFLICT");
  db::SensorRecord other_scanner = example_sensor();
  other_scanner.scanner_serial = "SC-8";
  CHECK(store_error([&] { store.add_sensor(other_scanner); }) == "TB-STORE-CONFLICT");
  CHECK((store.sensor("S-1")->scanner_serial == "SC-7" && store.sensor("S-1")->note == "first"));
  db::RunRecord unknown = example_run();
  unknown.sensor_serial = "S-9";
  CHECK(store_error([&] { store.begin_run(unknown); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("run store: devices are replaced as a whole, until the first frame") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.set_devices(begun.run, {{"stage", "Z-1", "7", "6.0", "simulated", "{}"}});
  store.set_devices(begun.run, {{"b", "", "", "", "", ""}, {"a", "", "", "", "", ""}});
  const auto devices = store.run(begun.run).devices;
  REQUIRE(devices.size() == 2);
  CHECK((devices[0].role == "b" && devices[1].role == "a"));
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.set_devices(begun.run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(store.run(begun.run).devices.size() == 2);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(store.check_content(begun.run).holds());
}

TEST_CASE("run store: devices of a run that another program ended are not replaced") {
  NewStore own;
  RunStore other = RunStore::open(own.path());
  own.add_sensor(example_sensor());
  const std::int64_t run = own.begin_run(example_run());
  own.set_seen(run, kUtc);  // it is known here as open
  REQUIRE(other.mark_interrupted(kUtc) == 1);
  CHECK(store_error([&] { own.set_devices(run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(other.run(run).devices.size() == 2);
  CHECK(other.check_content(run).holds());
}

TEST_CASE("run store: a run that two programs wrote in turn is closed with all rows of the file") {
  NewStore one;
  RunStore two = RunStore::open(one.path());
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));  // it knows of one frame
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(one.mark_interrupted(kUtc) == 1);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.check_content(begun.run).frames == 2);
  // The other goes on with it, and then the first again.
  two.reopen_run(begun.run, {9, "state", "", "resumed"});
  two.append_frame(begun.run, example_frame(begun.branch, 2));
  one.append_frame(begun.run, example_frame(begun.branch, 3));
  one.end_run(begun.run, db::Outcome::kStopped, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 4);
}

TEST_CASE("run store: a resumed run continues after its last frame, whichever process wrote it") {
  NewStore one;
  RunStore two = RunStore::open(one.path());
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(two.mark_interrupted(kUtc) == 1);
  one.reopen_run(begun.run, {9, "state", "", "resumed"});
  one.append_frame(begun.run, example_frame(begun.branch, 2));
  one.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 3);
}

TEST_CASE("run store: a missing run cannot be read, extended or annotated") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::FitRecord fit;
  fit.run = 99;
  fit.model = "elam";
  const std::int64_t own_fit = store.add_fit({0, run, "elam", true, 1, "", "", "", ""});
  const std::vector<std::pair<std::string, std::function<void()>>> questions = {
      {"run", [&] { (void)store.run(99); }},
      {"branches", [&] { (void)store.branches(99); }},
      {"frames", [&] { (void)store.frames(99); }},
      {"for_each_frame", [&] { store.for_each_frame(99, [](const db::FrameRecord&) {}); }},
      {"frame_count", [&] { (void)store.frame_count(99); }},
      {"events", [&] { (void)store.events(99); }},
      {"checks", [&] { (void)store.checks(99); }},
      {"series", [&] { (void)store.series(99); }},
      {"check_content", [&] { (void)store.check_content(99); }},
      {"check_seals", [&] { (void)store.check_seals(99); }},
      {"content_hash", [&] { (void)store.content_hash(99); }},
      {"fits", [&] { (void)store.fits(99); }},
      {"fit", [&] { (void)store.fit(99); }},
      {"default_fit", [&] { (void)store.default_fit(99); }},
      {"verdicts", [&] { (void)store.verdicts(99); }},
      {"verdicts_of_models", [&] { (void)store.verdicts_of_models(99); }},
      {"reports", [&] { (void)store.reports(99); }},
      {"add_fit", [&] { store.add_fit(fit); }},
      {"replace_verdicts", [&] { store.replace_verdicts(99, 0, {}); }},
      {"replace_verdicts by a fit", [&] { store.replace_verdicts(99, own_fit, {}); }},
      {"replace_figures", [&] { store.replace_figures(99, "rig", {}); }},
      {"add_report",
       [&] {
         store.add_report({99, "99-a", "a", "me", "2026", "", ""});
       }},
      {"set_tags", [&] { store.set_tags(99, {}, {}); }},
      {"add_note", [&] { store.add_note(99, "x"); }},
      {"void_run", [&] { store.void_run(99, "why", "me", "2026"); }},
      {"set_devices", [&] { store.set_devices(99, {}); }},
      {"set_state", [&] { store.set_state(99, "running", {}); }},
      {"begin_branch", [&] { store.begin_branch(99, example_branch()); }},
      {"void_branch", [&] { store.void_branch(99, "why"); }},
      {"append_frame", [&] { store.append_frame(99, example_frame(1, 0)); }},
      {"append_event", [&] { store.append_event(99, {}); }},
      {"append_check", [&] { store.append_check(99, {}); }},
      {"append_series", [&] { store.append_series(99, {}); }},
      {"set_rest", [&] { store.set_rest(99, 1.0); }},
      {"set_seen", [&] { store.set_seen(99, "2026"); }},
      {"end_run", [&] { store.end_run(99, db::Outcome::kFailed, "", {}, ""); }},
      {"reopen_run", [&] { store.reopen_run(99, {}); }}};
  for (const auto& [name, question] : questions) {
    INFO(name);
    CHECK(store_error(question) == "TB-STORE-NOT-FOUND");
  }
  CHECK((store.fits(run).size() == 1 && store.check_seals(run).empty() && store.check_structure().empty()));
}

TEST_CASE("run store: an ended run accepts no more data") {
  NewStore store;
  const std::int64_t run = store_example(store);
  const std::vector<std::pair<std::string, std::function<void()>>> changes = {
      {"set_devices", [&] { store.set_devices(run, {}); }},
      {"set_state", [&] { store.set_state(run, "running", {}); }},
      {"begin_branch", [&] { store.begin_branch(run, example_branch()); }},
      {"void_branch", [&] { store.void_branch(2, "why"); }},
      {"append_frame", [&] { store.append_frame(run, example_frame(2, 2)); }},
      {"append_event", [&] { store.append_event(run, {}); }},
      {"append_check", [&] { store.append_check(run, {}); }},
      {"append_series", [&] { store.append_series(run, {}); }},
      {"set_rest", [&] { store.set_rest(run, 1.0); }},
      {"set_seen", [&] { store.set_seen(run, "2026"); }},
      {"end_run", [&] { store.end_run(run, db::Outcome::kFailed, "", {}, ""); }}};
  for (const auto& [name, change] : changes) {
    INFO(name);
    CHECK(store_error(change) == "TB-STORE-CONFLICT");
  }
  CHECK(store.check_content(run).holds());
  const db::RunRecord record = store.run(run);
  CHECK((!record.rest_s && record.seen_utc.empty()));
}

TEST_CASE("run store: rest time and forces at the ends of a branch are absent unless stored") {
  NewStore store;
  const Begun begun = begin_example(store);
  CHECK_FALSE(store.run(begun.run).rest_s);
  store.set_rest(begun.run, 0.0);
  CHECK(store.run(begun.run).rest_s == 0.0);
  for (int i = 1; i < 4; ++i) {
    db::BranchRecord branch = example_branch();
    branch.attempt = i;
    if (i != 1) branch.from_n.reset();
    if (i != 2) branch.to_n.reset();
    store.begin_branch(begun.run, branch);
  }
  const auto branches = store.branches(begun.run);
  REQUIRE(branches.size() == 4);
  CHECK((branches[1].from_n == 2.1 && !branches[1].to_n));
  CHECK((!branches[2].from_n && branches[2].to_n == 30.3));
  CHECK((!branches[3].from_n && !branches[3].to_n));
}

namespace {

constexpr int kGoesOn = 0, kRefused = 5, kOther = 9;

int resume_in_child(const std::string& path, int start) {
  char none = 0;
  if (read(start, &none, 1) != 0) return kOther;  // until the parent closes its end
  const std::string id = store_error([&] {
    RunStore store = RunStore::open(path);
    store.reopen_run(1, {9, "state", "", "ended -> prepared: resumed"});
  });
  return id.empty() ? kGoesOn : id == "TB-STORE-CONFLICT" ? kRefused : kOther;
}

// Starts `count` processes that resume run 1; `held`: all of them wait for the store when it becomes free.
std::map<int, int> resume_at_once(const std::string& path, int count, bool held) {
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  std::vector<pid_t> children;
  for (int i = 0; i < count; ++i) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      close(ends[1]);
      _exit(resume_in_child(path, ends[0]));
    }
    children.push_back(child);
  }
  close(ends[0]);
  {
    Connection holder(path, Access::kReadWrite);
    std::unique_ptr<db::sqlite::Transaction> transaction;
    if (held) transaction = std::make_unique<db::sqlite::Transaction>(holder);
    close(ends[1]);
    if (held) usleep(300'000);
  }
  std::map<int, int> fates;
  for (const pid_t child : children) {
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    ++fates[WIFEXITED(status) ? WEXITSTATUS(status) : -1];
  }
  return fates;
}

}  // namespace

TEST_CASE("run store: if several processes resume a run at the same time, only one succeeds, and the run verifies") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    const Begun begun = begin_example(store);
    store.append_frame(begun.run, example_frame(begun.branch, 0));
    REQUIRE(store.mark_interrupted(kUtc) == 1);
  }
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    const std::map<int, int> fates = resume_at_once(path, 3, round < 5);
    CHECK(fates == std::map<int, int>{{kGoesOn, 1}, {kRefused, 2}});
    RunStore store = RunStore::open(path);
    CHECK(store.events(1).size() == static_cast<std::size_t>(2 * round + 2));  // interrupted and resumed, each once
    CHECK(store.check_content(1).holds());
    REQUIRE(store.mark_interrupted(kUtc) == 1);
    CHECK(store.check_content(1).holds());
  }
}

TEST_CASE("run store: a run that another process ended accepts no more rows, and still verifies") {
  NewStore own;
  RunStore other = RunStore::open(own.path());
  const Begun begun = begin_example(own);
  own.append_frame(begun.run, example_frame(begun.branch, 0));
  REQUIRE(other.mark_interrupted(kUtc) == 1);
  CHECK(store_error([&] { own.append_frame(begun.run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
  const auto begun_anew = [&](auto action) {  // each as the first to notice
    other.reopen_run(begun.run, {9, "state", "", "resumed"});
    own.set_seen(begun.run, kUtc);
    REQUIRE(other.mark_interrupted(kUtc) == 1);
    return store_error(action);
  };
  db::BranchRecord branch = example_branch();
  branch.attempt = 1;
  CHECK(begun_anew([&] { own.begin_branch(begun.run, branch); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.void_branch(begun.branch, "late"); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.set_state(begun.run, "running", {1, "state", "", ""}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.append_event(begun.run, {1, "note", "", ""}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] {
          own.append_check(begun.run, {begun.run, 1, "tare", "pass", "{}", {}});
        }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.append_series(begun.run, {{0, 0, {1.0}, {2.0}}}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.end_run(begun.run, db::Outcome::kFailed, "late", {}, kUtc); }) == "TB-STORE-CONFLICT");
  CHECK(other.frame_count(begun.run) == 1);
  CHECK(other.run(begun.run).outcome == db::Outcome::kInterrupted);
  CHECK(other.check_content(begun.run).holds());
}

TEST_CASE("run store: a run that was changed after its end is not resumed") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.append_check(begun.run, {begun.run, 4, "seating", "fail", "{}", {}});
  store.end_run(begun.run, db::Outcome::kStopped, "stopped", db::SafeState::kVerified, kUtc);
  Connection(store.path(), Access::kReadWrite).execute("DELETE FROM checks");
  CHECK(store_error([&] { store.reopen_run(begun.run, {9, "state", "", "resumed"}); }) == "TB-STORE-CONFLICT");
  CHECK(store.run(begun.run).outcome == db::Outcome::kStopped);
  CHECK(store.events(begun.run).empty());
  CHECK_FALSE(store.check_content(begun.run).holds());
}

TEST_CASE("run store: a frame is visible to another connection as soon as it is acknowledged") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), Durability::kNormal);
  const Begun begun = begin_example(store);
  const RunStore reader = RunStore::open_read_only(folder.path("runs.db"));
  for (int i = 0; i < 5; ++i) {
    CHECK(reader.frame_count(begun.run) == i);
    store.append_frame(begun.run, example_frame(begun.branch, i));
    CHECK(reader.frames(begun.run).back().ordinal == i);
  }
  store.set_state(begun.run, "running", {});
  CHECK(reader.run(begun.run).state == "running");
}

TEST_CASE("run store: a run whose process dies keeps every acknowledged frame and becomes interrupted") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  REQUIRE(in_child([&] {
            auto* store = new RunStore(RunStore::open(path, Durability::kNormal));  // never closed
            const Begun begun = begin_example(*store);
            store->set_state(begun.run, "running", {1, "state", "", ""});
            for (int i = 0; i < 40; ++i) store->append_frame(begun.run, example_frame(begun.branch, i));
            return 9;
          }) == 9);
  RunStore store = RunStore::open(path);
  CHECK(store.run(1).outcome == db::Outcome::kIncomplete);
  store_example(store);  // a run that ended stays as it is
  const std::int64_t prepared = begin_example(store).run;
  store.append_event(prepared, {41, "note", "", ""});
  CHECK(store.frame_count(1) == 40);
  CHECK(store.mark_interrupted("2024-05-01T11:00:00Z") == 2);
  const db::RunRecord run = store.run(1);
  CHECK(run.outcome == db::Outcome::kInterrupted);
  CHECK(run.state == "ended");
  CHECK(run.safe_state == db::SafeState::kUnknown);
  CHECK(run.ended_utc == "2024-05-01T11:00:00Z");
  CHECK_THAT(run.reason, Catch::StartsWith("TB-RUN-INTERRUPTED"));
  CHECK(run.content_sha256 == store.content_hash(1));
  const db::EventRecord event = store.events(1).back();
  CHECK((event.kind == "state" && event.id == "TB-RUN-INTERRUPTED"));
  CHECK_THAT(event.detail, Catch::StartsWith("running -> ended"));
  CHECK_THAT(store.events(prepared).back().detail, Catch::StartsWith("prepared -> ended"));
  CHECK(store.events(prepared).back().time_ns == 41);
  CHECK(event.time_ns == example_frame(1, 39).time_ns);  // the last known time of the run
  CHECK(store.run(2).outcome == db::Outcome::kCompleted);
  CHECK(store.mark_interrupted("2024-05-01T12:00:00Z") == 0);
  CHECK(store.run(1).ended_utc == "2024-05-01T11:00:00Z");
}

// Killed at no chosen point: within a commit as well as between two.
TEST_CASE("run store: SIGKILL at any moment loses no acknowledged frame and leaves an intact file") {
  for (int round = 0; round < 6; ++round) {
    const TemporaryFolder folder;
    const std::string path = folder.path("runs.db");
    int pipe_ends[2];
    REQUIRE(pipe(pipe_ends) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      RunStore store = RunStore::open(path, round == 0 ? Durability::kFull : Durability::kNormal);
      const Begun begun = begin_example(store);
      for (int i = 0;; ++i) {
        store.append_frame(begun.run, example_frame(begun.branch, i));
        if (write(pipe_ends[1], &i, sizeof i) != sizeof i) _exit(1);
      }
    }
    close(pipe_ends[1]);
    int last = -1, got = 0;
    while (last < 10 + 41 * round && read(pipe_ends[0], &got, sizeof got) == sizeof got) last = got;
    kill(child, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    while (read(pipe_ends[0], &got, sizeof got) == sizeof got) last = got;
    close(pipe_ends[0]);
    RunStore store = RunStore::open(path);
    const std::vector<db::FrameRecord> frames = store.frames(1);
    REQUIRE(static_cast<int>(frames.size()) >= last + 1);
    CHECK(static_cast<int>(frames.size()) <= last + 2);
    for (std::size_t i = 0; i < frames.size(); ++i) REQUIRE(frames[i].ordinal == static_cast<int>(i));
    CHECK(store.mark_interrupted("") == 1);
    CHECK(store.content_hash(1) == store.run(1).content_sha256);
    db::sqlite::Connection raw(path, db::sqlite::Access::kReadOnly);
    CHECK(raw.text("PRAGMA integrity_check") == "ok");
  }
}

TEST_CASE("run store: an ended run that was not completed can be reopened, and its hash chain continues") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");  // it is live
  REQUIRE(store.mark_interrupted("2026-01-01T00:00:00Z") == 1);
  store.reopen_run(begun.run, {9, "state", "", "ended -> prepared: resumed"});
  CHECK((store.run(begun.run).outcome == db::Outcome::kIncomplete && store.run(begun.run).content_sha256.empty()));
  store.append_frame(begun.run, example_frame(begun.branch, 1));
  CHECK(store.last_time_ns(begun.run) == example_frame(begun.branch, 1).time_ns);
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "");
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
  CHECK(store.frame_count(begun.run) == 2);
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");  // completed
}
