// runs export of a long run: the file is written frame by frame, and memory does not grow with the run.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/run/stored_past.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::int64_t store_frames(db::RunStore& store, int frames) {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sequences = {{0, "long", "", "", 1, frames}};
  const std::int64_t number = store.begin_run(run);
  db::FrameRecord frame;
  frame.branch = store.begin_branch(number, {});
  frame.rows = frame.columns = 16;
  frame.scans = 2;
  frame.counts.assign(512, 0);
  for (int i = 0; i < frames; ++i) {
    frame.ordinal = i;
    frame.time_ns = 1'000'000'000LL * i;
    for (std::size_t c = 0; c < frame.counts.size(); ++c) frame.counts[c] = static_cast<std::uint16_t>(40'000 + c + i);
    store.append_frame(number, frame);
  }
  store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  return number;
}

// Of one call of the program, in MB.
double peak_memory(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), program_path());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder.path().c_str()) != 0 || freopen("/dev/null", "w", stdout) == nullptr) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  rusage used{};
  REQUIRE(wait4(child, &status, 0, &used) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return static_cast<double>(used.ru_maxrss) / 1024.0;
}

}  // namespace

TEST_CASE("an export takes no more memory for a run of ten times as many frames") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    REQUIRE(store_frames(store, 1'000) == 1);
    REQUIRE(store_frames(store, 10'000) == 2);
  }
  for (const char* format : {"json", "csv"}) {
    const std::string file = std::string("2.") + format;
    const double brief = peak_memory(folder, {"runs", "export", "1", "--format", format, "-o", "1." + file});
    const double lengthy = peak_memory(folder, {"runs", "export", "2", "--format", format, "-o", file});
    INFO(format << ": " << brief << " MB for 1000 frames, " << lengthy << " MB for 10000");
    CHECK(std::filesystem::file_size(folder.path(file)) > 25'000'000);
    CHECK(lengthy < brief + 10.0);  // as one text 30 MB more, as one tree 150 MB
  }
}

TEST_CASE("an export written frame by frame is one document, and reports its length") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    REQUIRE(store_frames(store, 3) == 1);
    REQUIRE(store_frames(store, 0) == 2);
  }
  for (const char* run : {"1", "2"}) {
    const Finished told = run_program(
        program_path(), {"runs", "export", run, "--format", "json", "-o", "run.json", "--json"}, folder.path());
    REQUIRE(told.code == 0);
    CHECK(nlohmann::json::parse(told.out)["bytes"] == std::filesystem::file_size(folder.path("run.json")));
    const auto document = nlohmann::json::parse(read_file(folder.path("run.json")));
    CHECK(document["schema"] == "tactbench.run");
    CHECK(document["frames"].size() == (std::string(run) == "1" ? 3U : 0U));
    for (const char* list : {"series", "events", "checks", "verdicts"}) CHECK(document[list].is_array());
    if (!document["frames"].empty()) CHECK(document["frames"][2]["counts"][511] == 40'000 + 511 + 2);
  }
  CHECK(run_program(program_path(), {"runs", "export", "2", "-o", "empty.csv"}, folder.path()).code == 0);
  CHECK_THAT(read_file(folder.path("empty.csv")),
             Catch::StartsWith("# tactbench: frames of run 2\n# origin: simulated\n") &&
                 Catch::Contains("\nframe,sequence,") && Catch::EndsWith(",scan\n"));
}

TEST_CASE("an export of two frames and of a series, by the letter") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sequences = {{0, "up, \"down\"", "text", "", 1, 2}};
    run.devices = {{"tactile scanner", "", "", "", "simulated", R"({"volts_per_count": 0.25})"}};
    const std::int64_t first = store.begin_run(run);
    db::BranchRecord branch;
    branch.ordinal = 1;
    branch.attempt = 2;
    db::FrameRecord frame;
    frame.branch = store.begin_branch(first, branch);
    frame.setpoint_psi = 1.5;
    frame.feedback_psi = 1.25;
    frame.reference_psi = 1.125;
    frame.time_ns = 1'500'000'000;
    frame.since_command_ns = 500'000'000;
    frame.in_band_ns = 250'000'000;
    frame.device_time_us = 7;
    frame.status = 3;
    frame.flags = "dwell left-band";
    frame.rows = 1;
    frame.columns = frame.scans = 2;
    frame.counts = {1, 2, 3, 4};
    store.append_frame(first, frame);
    branch.ordinal = branch.attempt = 0;
    branch.repeat = 1;
    frame.branch = store.begin_branch(first, branch);
    frame.ordinal = 1;
    frame.flags.clear();
    frame.wrench = db::WrenchRecord{2.5, 2.25, {1, 2, 3, 4, 5, 6.5}, {6, 5, 4, 3, 2, 1}, {10, 20, 30}};
    store.append_frame(first, frame);
    store.void_branch(frame.branch, "torn");
    store.end_run(first, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
    run.uuid = db::new_uuid();
    const std::int64_t second = store.begin_run(run);
    store.append_series(second, {{0, 3, {1.0, 2.5}, {0.5, 0.25}}});
    store.end_run(second, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  }
  REQUIRE(call(folder, {"runs", "export", "1", "-o", "run.csv"}).code == 0);
  const std::string table = read_file(folder.path("run.csv"));
  CHECK_THAT(table, Catch::StartsWith("# tactbench: frames of run 1\n") &&
                        Catch::Contains("\n# recipes: up, \"down\"\n") &&
                        Catch::Contains("\n# volts_per_count: 0.25\n# units: "));
  CHECK(
      table.substr(table.find("\nframe,") + 1) ==
      "frame,sequence,recipe,repeat,branch,attempt,void,step,setpoint_psi,feedback_psi,reference_psi,target_n,fx_n,"
      "fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,x_mm,y_mm,z_mm,time_s,since_command_s,in_band_s,device_time_us,status,flags,scan,"
      "counts_r0_c0,"
      "counts_r0_c1,volts_r0_c0,volts_r0_c1\n"
      "1,0,\"up, \"\"down\"\"\",0,1,2,0,0,1.5,1.25,1.125,,,,,,,,,,,1.5,0.5,0.25,7,3,dwell left-band,0,1,2,0.25,0.5\n"
      "1,0,\"up, \"\"down\"\"\",0,1,2,0,0,1.5,1.25,1.125,,,,,,,,,,,1.5,0.5,0.25,7,3,dwell left-band,1,3,4,0.75,1\n"
      "2,0,\"up, \"\"down\"\"\",1,0,0,1,1,1.5,1.25,1.125,2.5,1,2,3,4,5,6.5,10,20,30,1.5,0.5,0.25,7,3,,0,1,2,0.25,0.5\n"
      "2,0,\"up, \"\"down\"\"\",1,0,0,1,1,1.5,1.25,1.125,2.5,1,2,3,4,5,6.5,10,20,30,1.5,0.5,0.25,7,3,,1,3,4,0.75,1\n");
  REQUIRE(call(folder, {"runs", "export", "1", "--format", "json", "-o", "run.json"}).code == 0);
  const auto document = nlohmann::json::parse(read_file(folder.path("run.json")));
  REQUIRE(document["frames"].size() == 2);
  CHECK(document["frames"][0]["attempt"] == 2);
  CHECK(document["frames"][0]["void"] == false);
  CHECK(document["frames"][0]["in_band_ns"] == 250'000'000);
  CHECK(document["frames"][0]["counts"] == nlohmann::json({1, 2, 3, 4}));
  CHECK_FALSE(document["frames"][0].contains("target_n"));
  CHECK(document["frames"][1]["void"] == true);
  CHECK(document["frames"][1]["target_n"] == 2.5);
  CHECK(document["frames"][1]["wrench_n_nmm"][5] == 6.5);
  CHECK(document["frames"][1]["wrench_raw"][0] == 6.0);
  CHECK(document["frames"][1]["place_mm"][2] == 30.0);
  CHECK(document["recipes"][0]["toml"] == "text");
  REQUIRE(call(folder, {"runs", "export", "2", "-o", "series.csv"}).code == 0);
  CHECK(read_file(folder.path("series.csv")) ==
        "sequence,name,taxel,position,input,output\n0,\"up, \"\"down\"\"\",3,0,1,0.5\n0,\"up, "
        "\"\"down\"\"\",3,1,2.5,0.25\n");
  const Finished copied = call(folder, {"runs", "copy", "2", "1", "2", "--to", "other.db"});
  CHECK(copied.out == "run 1 is run 1 of other.db\nrun 2 is run 2 of other.db\n");
}
