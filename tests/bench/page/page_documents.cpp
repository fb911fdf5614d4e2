// Pages that other programs write for the page's frame: their words, at most two at a time, what failed, and how many
// are kept. By scripts in the place of the program.

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "bench/page/documents.h"
#include "bench/page/frames.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A program that writes what it was asked into its last word. It waits for the file `go` where the first one is `wait`,
// and notes each of its starts in `begun`.
struct ScriptedDocuments {
  explicit ScriptedDocuments(const std::string& more = {}) {
    write_file(program, "#!/bin/sh\ncd '" + folder.path() +
                            "'\nfor last in \"$@\"; do :; done\necho x >>begun\n"
                            "if [ \"$1\" = wait ]; then while [ ! -e go ]; do sleep 0.02; done; fi\n" +
                            more + "printf '%s\\n' \"$NO_COLOR\" \"$@\" >\"$last\"\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  }
  // Until that many are ready, at the latest after 20 s.
  void wait_for(std::size_t count) {
    for (int i = 0; i < 2000 && ready.size() < count; ++i) {
      documents.look();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    REQUIRE(ready.size() == count);
  }
  void make(const std::vector<std::string>& words, const std::string& output = "-o") {
    documents.make(words, output, [this](const Document& made) { ready.push_back(made); });
  }
  [[nodiscard]] std::size_t begun() const {
    return std::filesystem::exists(folder.path("begun")) ? read_file(folder.path("begun")).size() / 2 : 0;
  }
  TemporaryFolder folder;
  std::string program = folder.path("program");
  std::vector<Document> ready;
  Documents documents{folder.path("runs.db"), program};
};

}  // namespace

TEST_CASE("page documents: are made by the requested command with store and file, each with its own secret name") {
  ScriptedDocuments made;
  CHECK_FALSE(made.documents.busy());
  made.make({"report", "5"});
  made.make({"trend", "--subject=nightly/"}, "--html");
  made.wait_for(2);
  CHECK_FALSE(made.documents.busy());
  for (const Document& one : made.ready) {
    CHECK(one.error.empty());
    CHECK(one.id.size() == 32);
  }
  CHECK(made.ready[0].id != made.ready[1].id);
  std::vector<std::string> texts = {*made.documents.text(made.ready[0].id), *made.documents.text(made.ready[1].id)};
  if (texts[0].find("trend") != std::string::npos) std::swap(texts[0], texts[1]);
  const std::string db = made.folder.path("runs.db");
  CHECK_THAT(texts[0], Catch::StartsWith("1\nreport\n5\n--db\n" + db + "\n-o\n/") && Catch::EndsWith(".html\n"));
  CHECK_THAT(texts[1], Catch::StartsWith("1\ntrend\n--subject=nightly/\n--db\n" + db + "\n--html\n/"));
  const std::string id = made.ready[0].id;
  for (const std::string& none :
       std::vector<std::string>{"", "0", std::string(32, '0'), "../" + id, id + ".html", id + "\n"})
    CHECK_FALSE(made.documents.text(none));
}

TEST_CASE("page documents: two are made at a time, six wait, and a ninth is refused") {
  ScriptedDocuments made;
  for (int i = 0; i < 8; ++i) made.make({"wait"});
  CHECK(made.ready.empty());
  for (int i = 0; i < 2000 && made.begun() < 2; ++i) {
    made.documents.look();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  made.documents.look();
  CHECK(made.begun() == 2);
  CHECK(made.documents.busy());
  made.make({"more"});
  REQUIRE(made.ready.size() == 1);
  CHECK(made.ready[0].id.empty());
  write_file(made.folder.path("go"), "");
  made.wait_for(9);
  CHECK(made.begun() == 8);
  for (std::size_t i = 1; i < 9; ++i) CHECK(made.ready[i].error.empty());
}

TEST_CASE("page documents: if none is written, the output of the program is reported, escaped and truncated") {
  ScriptedDocuments silent("exit 0\n"), speaks("printf 'error: \\033[2J no run 5\\n' >&2; exit 2\n"),
      long_talk("printf '%05000d' 7; exit 1\n");
  silent.make({"x"});
  speaks.make({"x"});
  long_talk.make({"x"});
  silent.wait_for(1);
  speaks.wait_for(1);
  long_talk.wait_for(1);
  CHECK_FALSE(silent.ready[0].error.empty());
  CHECK_THAT(speaks.ready[0].error, Catch::Contains("no run 5") && !Catch::Contains("\x1b"));
  CHECK(long_talk.ready[0].error.size() == 2000);
  for (const ScriptedDocuments* one : {&silent, &speaks, &long_talk}) CHECK(one->ready[0].id.empty());
  ScriptedDocuments missing;
  std::filesystem::remove(missing.program);
  missing.make({"x"});
  missing.wait_for(1);
  CHECK_FALSE(missing.ready[0].error.empty());
}

TEST_CASE("page documents: the newest twelve files are kept unchanged, a too large file is refused") {
  ScriptedDocuments made;
  const std::string file = made.folder.path("night.html");
  std::vector<std::string> ids;
  for (int i = 0; i < 13; ++i) {
    write_file(file, fmt::format("page {}", i));
    const Document kept = made.documents.keep(file);
    CHECK(kept.error.empty());
    ids.push_back(kept.id);
  }
  write_file(file, "later");
  CHECK_FALSE(made.documents.text(ids[0]));
  for (int i = 1; i < 13; ++i)
    CHECK(made.documents.text(ids[static_cast<std::size_t>(i)]) == fmt::format("page {}", i));
  made.make({"a"});  // one more
  made.wait_for(1);
  CHECK_FALSE(made.documents.text(ids[1]));
  CHECK(made.documents.text(ids[2]));
  const Document none = made.documents.keep(made.folder.path("none"));
  CHECK(none.id.empty());
  std::filesystem::resize_file(file, 32U << 20U);
  CHECK(made.documents.text(made.documents.keep(file).id).value_or("").size() == 32U << 20U);
  std::filesystem::resize_file(file, (32U << 20U) + 1);
  CHECK_FALSE(made.documents.text(made.documents.keep(file).id));
}

// The page's picture and loops of frames that are stored by hand: every member, and where each begins and ends.

namespace {

// Of a scanner with 1 mV a count.
class FramesByHand {
 public:
  explicit FramesByHand(int count = 10) {
    store.add_sensor({"S-1", "synthetic", "", db::sha256_hex(""), "SC-1", "", ""});
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.sequences = {{0, "a", "", "", 1, count}};
    run.devices = {{"tactile scanner", "synthetic", "SC-1", "", "simulated", R"({"volts_per_count":0.001})"}};
    number = store.begin_run(run);
    branch = store.begin_branch(number, {});
  }
  void add(double psi, std::vector<std::uint16_t> counts, int rows, int columns) {
    db::FrameRecord frame = frame_of(psi, std::move(counts), rows, columns);
    store.append_frame(number, frame);
  }
  db::FrameRecord frame_of(double psi, std::vector<std::uint16_t> counts, int rows, int columns) {
    db::FrameRecord frame;
    frame.branch = branch;
    frame.ordinal = next_++;
    frame.setpoint_psi = psi + 0.25;
    frame.feedback_psi = psi + 0.5;
    frame.reference_psi = psi;
    frame.time_ns = 1'500'000'000LL * (frame.ordinal + 1);
    frame.rows = rows;
    frame.columns = columns;
    frame.scans = static_cast<int>(counts.size()) / (rows * columns);
    frame.counts = std::move(counts);
    return frame;
  }
  // 2 taxels: 10 and 20 mV unloaded, as loaded as given at that pressure.
  void add_seating(double psi, const std::vector<double>& loaded) {
    db::CheckRecord check;
    check.kind = "seating";
    check.verdict = "pass";
    check.detail_json = R"({"rows":1,"columns":2,"volts_per_count":0.001,"pressure_psi":)" + std::to_string(psi) + "}";
    check.data = {10.0, 20.0};
    check.data.insert(check.data.end(), loaded.begin(), loaded.end());
    store.append_check(number, check);
  }
  [[nodiscard]] nlohmann::json loop(int taxel, std::int64_t after) const {
    return bench::loop_points(store, number, taxel, after);
  }

 private:
  tests::TemporaryFolder folder_;
  int next_ = 0;

 public:
  db::RunStore store = db::RunStore::open(folder_.path("frames.db"), db::Durability::kNormal);
  std::int64_t number = 0, branch = 0;
};

}  // namespace

TEST_CASE("page frames: shows nothing before the first frame, then the seating check, then each newest frame") {
  FramesByHand made;
  bench::RunFrames shown(made.store, made.store.run(made.number));
  CHECK_FALSE(shown.advance());
  CHECK(shown.picture().is_null());
  CHECK(shown.position() == 0);
  made.add_seating(8.0, {500.0, 40.0});  // the second taxel rises by 20 mV: it is dead
  CHECK(shown.advance());
  CHECK_FALSE(shown.advance());
  const nlohmann::json seated = shown.picture();
  CHECK((seated["run"] == made.number && seated["position"] == 0 && seated["rows"] == 1 && seated["columns"] == 2));
  CHECK((seated["full_scale_v"] == 65.535 && seated["volts"] == std::vector<double>{0.5, 0.04}));
  CHECK((seated["dead"] == nlohmann::json::array({1}) && seated["dead_known"] == true && seated["saturated"].empty()));
  made.add(12.5, {1000, 65535, 1002, 65535}, 1, 2);  // two scans: means of 1001 and 65535
  CHECK(shown.advance());
  CHECK(shown.position() == 1);
  const nlohmann::json frame = shown.picture();
  CHECK((frame["position"] == 1 && frame["volts"] == std::vector<double>{1.001, 65.535} &&
         frame["saturated"] == nlohmann::json::array({1})));
  CHECK((frame["dead"].empty() && frame["void"] == false));
  CHECK_FALSE(shown.advance());
  made.store.void_branch(made.branch, "again");
  bench::RunFrames voided(made.store, made.store.run(made.number));
  CHECK(voided.advance());
  CHECK(voided.picture()["void"] == true);
}

TEST_CASE("page frames: a frame under an object has its force and position, and text for its flags") {
  FramesByHand made;
  db::FrameRecord frame = made.frame_of(0.0, {100, 200}, 1, 2);
  frame.flags = "tilted late";
  frame.wrench.emplace();
  frame.wrench->target_n = 6.0;
  frame.wrench->wrench = {0.5, -0.25, -6.25, 0.01, 0.02, 0.03};
  frame.wrench->place_mm = {1.0, 2.0, -3.0};
  made.store.append_frame(made.number, frame);
  bench::RunFrames shown(made.store, made.store.run(made.number));
  CHECK(shown.advance());
  const nlohmann::json picture = shown.picture();
  CHECK_THAT(picture["title"].get<std::string>(), Catch::Contains("6.25 N"));
  CHECK(picture["press"]["target_n"] == 6.0);
  CHECK(picture["press"]["wrench"] == nlohmann::json({0.5, -0.25, -6.25, 0.01, 0.02, 0.03}));
  CHECK(picture["press"]["place_mm"] == nlohmann::json({1.0, 2.0, -3.0}));
  CHECK(made.loop(0, 0) == nlohmann::json({{"run", made.number},
                                           {"taxel", 0},
                                           {"last", 1},
                                           {"axis", "N"},
                                           {"x", {6.25}},
                                           {"y", {0.1}},
                                           {"set", {6.0}},
                                           {"t", {1.5}}}));
  // Of a run with pressures, too, the loop is of the newest frame's quantity alone.
  made.add(12.5, {300, 400}, 1, 2);
  CHECK(made.loop(0, 0)["axis"] == "psi");
  CHECK(made.loop(0, 0)["x"] == nlohmann::json({12.5}));
}

TEST_CASE("page frames: shows the valid frame with the highest load on request") {
  FramesByHand made;
  for (const double psi : {0.0, 40.0, 10.0}) made.add(psi, {static_cast<std::uint16_t>(10.0 * psi)}, 1, 1);
  bench::RunFrames shown(made.store, made.store.run(made.number));
  CHECK(shown.advance());
  const nlohmann::json peak = shown.picture(true), newest = shown.picture();
  CHECK((peak["position"] == 2 && peak["last"] == 3 && peak["peak"] == true));
  CHECK((newest["position"] == 3 && newest["peak"] == false));
}

TEST_CASE("page frames: reads at most two hundred frames per call") {
  FramesByHand made(450);
  for (int i = 0; i < 450; ++i) made.add(0.1 * i, {static_cast<std::uint16_t>(i)}, 1, 1);
  bench::RunFrames shown(made.store, made.store.run(made.number));
  for (const int position : {200, 400, 450}) {
    CHECK(shown.advance());
    CHECK(shown.position() == position);
    CHECK(shown.picture()["position"] == position);
  }
  CHECK_FALSE(shown.advance());
  CHECK(shown.position() == 450);
}

TEST_CASE("page loops: mean or single taxel from a position on, rounded to 0.001 psi and 0.01 mV") {
  FramesByHand made;
  made.add(1.2346, {100, 201}, 1, 2);
  made.add(2.0004, {300, 401, 302, 403}, 1, 2);
  made.add(3.0, {500, 600}, 1, 2);
  using Values = std::vector<double>;
  const auto is = [&](int taxel, std::int64_t after, const Values& x, const Values& y) {
    const nlohmann::json loop = made.loop(taxel, after);
    CHECK((loop["last"] == 3 && loop["axis"] == "psi" && loop["x"] == x && loop["y"] == y));
    CHECK((loop["set"].size() == x.size() && loop["t"].size() == x.size()));
  };
  is(-1, 0, {1.235, 2.0, 3.0}, {0.1505, 0.3515, 0.55});
  is(0, 0, {1.235, 2.0, 3.0}, {0.1, 0.301, 0.5});
  is(1, 0, {1.235, 2.0, 3.0}, {0.201, 0.402, 0.6});
  is(1, 1, {2.0, 3.0}, {0.402, 0.6});
  is(1, 2, {3.0}, {0.6});
  is(1, 3, {}, {});
  is(2, 0, {}, {});  // no such taxel
  CHECK(made.loop(0, 0)["set"] == Values{1.485, 2.25, 3.25});
  CHECK(made.loop(0, 0)["t"] == Values{1.5, 3.0, 4.5});
  // Void branches leave no points, and the place goes on behind them.
  made.store.void_branch(made.branch, "again");
  is(-1, 0, {}, {});
}

TEST_CASE("page loops: are empty for a run without a scale") {
  FramesByHand made;
  db::RunRecord run = made.store.run(made.number);
  run.uuid = db::new_uuid();
  run.devices.clear();
  const std::int64_t number = made.store.begin_run(run);
  const nlohmann::json none = bench::loop_points(made.store, number, -1, 7);
  CHECK((none["last"] == 7 && none["x"].empty() && none["y"].empty()));
}

TEST_CASE("page loops: have at most the newest four thousand points") {
  FramesByHand made(4002);
  for (int i = 0; i < 4002; ++i) made.add(0.01 * i, {static_cast<std::uint16_t>(i)}, 1, 1);
  const nlohmann::json points = made.loop(0, 0);
  REQUIRE(points["x"].size() == 4000);
  CHECK(points["last"] == 4002);
  CHECK(points["y"][0] == 0.002);
  CHECK(points["y"][3999] == 4.001);
  CHECK(made.loop(0, 3)["x"].size() == 3999);
  CHECK(made.loop(0, 1)["x"].size() == 4000);
}
