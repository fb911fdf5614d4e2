// The report verb as a person uses it: formats, signatures, comparison, batch; figures recomputed from the store.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/report/gather.h"
#include "tests/bench/cli/small_bench.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// One folder for all: two sensors, the first measured twice, models of each run.
const TemporaryFolder& reported() {
  static const TemporaryFolder folder;
  static const bool made = [&] {
    begin_bench(folder, small_loop_text(10, 2));
    well(call(folder, {"sensors", "add", "S-2", "--type", "sensor.toml"}));
    for (const auto& [sensor, seed] : {std::pair("S-1", "1"), {"S-1", "1"}, {"S-2", "2"}})
      well(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", sensor, "--operator",
                         "</script><img onerror=x>", "-q", "--sensor-seed", seed, "--seed", seed}));
    for (const char* run : {"1", "2", "3"}) well(call(folder, {"fit", run}));
    return true;
  }();
  (void)made;
  return folder;
}

json data_of_run(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  well(call(folder, joined_words({"report", "--format", "json", "-o", "report.json", "--replace"}, words)));
  return json::parse(read_file(folder.path("report.json")));
}

}  // namespace

TEST_CASE("figures of health and raw behaviour are those recomputed from the stored counts") {
  const TemporaryFolder& folder = reported();
  const json data = data_of_run(folder, {"1"});
  CHECK(data["schema"] == "tactbench.report");
  const json &health = data["sections"]["health"], &raw = data["sections"]["raw"];
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  double volts_per_count = 0.0;
  for (const db::DeviceRecord& device : store.run(1).devices)
    if (device.role == "tactile scanner")
      volts_per_count = json::parse(device.calibration_json)["volts_per_count"].get<double>();
  REQUIRE(volts_per_count > 0.0);
  // Mean of the scans of each frame, by repeat and step.
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : store.branches(1)) branches.emplace(branch.branch, branch);
  std::map<int, std::map<int, std::vector<double>>> volts;
  std::vector<double> low(256, 1e9), high(256, -1e9), squares(256, 0.0);
  int degrees = 0, scans_a_frame = 0;
  for (const db::FrameRecord& frame : store.frames(1)) {
    REQUIRE(frame.columns * frame.rows == 256);
    std::vector<double> mean(256, 0.0);
    for (std::size_t i = 0; i < frame.counts.size(); ++i)
      mean[i % 256] += volts_per_count * frame.counts[i] / frame.scans;
    for (std::size_t i = 0; i < frame.counts.size(); ++i)
      squares[i % 256] += std::pow(volts_per_count * frame.counts[i] - mean[i % 256], 2);
    degrees += frame.scans - 1;
    scans_a_frame = frame.scans;
    for (std::size_t t = 0; t < 256; ++t) {
      low[t] = std::min(low[t], mean[t]);
      high[t] = std::max(high[t], mean[t]);
    }
    volts[branches.at(frame.branch).repeat][frame.ordinal] = mean;
  }
  REQUIRE(volts.size() == 2);
  double zero = 0.0;
  for (const auto& [repeat, steps] : volts)
    for (std::size_t t = 0; t < 256; ++t) zero += (steps.rbegin()->second[t] - steps.at(0)[t]) / 512.0;
  CHECK(raw["zero_return"][0]["mean_v"].get<double>() == Approx(zero).margin(1e-12));
  for (const std::size_t t : {std::size_t{0}, std::size_t{100}, std::size_t{255}}) {
    CHECK(health["low_v"][t].get<double>() == Approx(low[t]));
    CHECK(health["high_v"][t].get<double>() == Approx(high[t]));
    CHECK(health["noise_v"][t].get<double>() == Approx(std::sqrt(squares[t] / degrees / scans_a_frame)));
  }
  // The trace of the mean taxel, step by step.
  const json& trace = raw["traces"][0]["output_v"];
  REQUIRE(trace.size() == volts[0].size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    double mean = 0.0;
    for (const auto& [repeat, steps] : volts)
      for (const double v : steps.at(static_cast<int>(i))) mean += v / 512.0;
    CHECK(trace[i].get<double>() == Approx(mean));
  }
  // What is moved to set-points follows from the dataset (figure_answers.cpp checks how).
  std::vector<int> all(256);
  for (int t = 0; t < 256; ++t) all[static_cast<std::size_t>(t)] = t;
  const analysis::Behaviour own = analysis::behaviour_of(analysis::load_dataset(store, 1), all);
  CHECK(raw["loops"][0]["hysteresis_max_fs"] == own.loops[0].hysteresis_max);
  CHECK(raw["loops"][3]["taxel"] == own.loops[3].taxel);
  CHECK(raw["gain"][17].get<double>() == Approx(own.gain[17]).epsilon(1e-6));
  CHECK(raw["repeatability"][3]["taxel_down_v"] == own.repeatability[3].taxel_down_v);
  const json& evaluation = data["results"]["evaluation"];
  CHECK(raw["loops"][0]["hysteresis_max_fs"].get<double>() ==
        Approx(evaluation["hysteresis_max_fs"].get<double>()).epsilon(1e-9));
  REQUIRE(call(folder, {"report", "1", "-o", "one.html"}).code == 0);
  const std::string page = read_file(folder.path("one.html"));
  CHECK_THAT(page, Catch::Contains("&lt;/script&gt;&lt;img onerror=x&gt;") && !Catch::Contains("<img"));
}

// What else becomes of signed reports: report_words_slow.cpp.
TEST_CASE("the same run gives the same bytes, and a signature keeps the number") {
  const TemporaryFolder& folder = reported();
  for (const char* name : {"a.html", "b.html"}) REQUIRE(call(folder, {"report", "2", "-o", name}).code == 0);
  CHECK(read_file(folder.path("a.html")) == read_file(folder.path("b.html")));
  const json first = json::parse(call(folder, {"report", "2", "--json"}).out);
  const std::vector<std::string> sign = {"report", "sign", "2", "--json", "--without-verdict", "--by", "C. Chief"};
  CHECK(json::parse(call(folder, sign).out)["number"] == first["number"]);
}

TEST_CASE("a report goes into a pipe, and to a full device it is an error") {
  const TemporaryFolder& folder = reported();
  const auto piped = [&](const std::string& words) {
    return run_program("/bin/sh", {"-c", "timeout 60 '" + program_path() + "' " + words}, folder.path());
  };
  const Finished whole = piped("report 1 -q --format json -o /dev/stdout | cat");
  CHECK(whole.code == 0);
  CHECK(whole.out.find("\"schema\":\"tactbench.report\"") != std::string::npos);
  REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
  const Finished fifo = run_program(
      "/bin/sh",
      {"-c", "timeout 60 '" + program_path() + "' report 1 -q --format json -o pipe & timeout 60 cat pipe; wait $!"},
      folder.path());
  CHECK(fifo.code == whole.code);
  CHECK(fifo.out.find("\"schema\":\"tactbench.report\"") != std::string::npos);
  CHECK(piped("report 1 -q -o /dev/full").code == 2);
}

TEST_CASE("a batch has the figures of each sensor's newest run") {
  const TemporaryFolder& folder = reported();
  const json batch = data_of_run(folder, {"--batch", "1", "2", "3"});
  CHECK(batch["runs"] == json::array({2, 3}));  // one a sensor, the newest
  CHECK(batch["content"][0]["figures"]["mean_error_psi"] ==
        data_of_run(folder, {"2"})["results"]["evaluation"]["mean_error_psi"]);
}

TEST_CASE("a PDF is made by what is installed, with the run's date, else it is an error") {
  const TemporaryFolder& folder = reported();
  const auto with_path = [&](const std::string& path, const std::string& name) {
    return run_program("/usr/bin/env", {"PATH=" + path, program_path(), "report", "1", "--format", "pdf", "-o", name},
                       folder.path());
  };
  check_refusal(with_path("/nowhere", "none.pdf"), 2, "TB-REPORT-PDF");
  write_file(
      folder.path("printed"),
      "%PDF-1.4\n1 0 obj <</Type/Catalog/Pages 2 0 R>> endobj\n2 0 obj <</Type/Pages/Kids[]/Count 0>> endobj\n"
      "3 0 obj <</CreationDate (D:20990909090909+00)>> endobj\ntrailer <</Size 4/Root 1 0 R/Info 3 0 R>>\n%%EOF\n");
  write_file(folder.path("chromium"),
             "#!/bin/sh\nfor word; do case $word in --print-to-pdf=*) out=${word#--print-to-pdf=};; esac; done\n"
             "cp '" +
                 folder.path("printed") + "' \"$out\"\n");
  REQUIRE(::chmod(folder.path("chromium").c_str(), 0700) == 0);
  well(with_path(folder.path() + ":/usr/bin:/bin", "made.pdf"));
  CHECK_THAT(read_file(folder.path("made.pdf")), Catch::StartsWith("%PDF") && !Catch::Contains("D:2099") &&
                                                     Catch::Contains("(D:20") && Catch::Contains("(report.json)"));
}
