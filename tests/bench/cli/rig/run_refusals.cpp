// run and devices calibrate-reference: what is refused, or warned of, before a device is opened.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A bench whose simulated rig is another program's.
constexpr const char* kFarRig =
    "schema = 1\n[bench]\nid = \"far-rig\"\norigin = \"simulated\"\nsimulator = \"external\"\n[module]\nprofile = "
    "\"beckhoff-ek9000\"\nhost = \"127.0.0.1\"\nport = 1\n[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\n"
    "serial = \"s\"\n[scanner]\nsocket = \"/nonexistent/scanner\"\n";

struct RunToRefuse {
  RunToRefuse() { write_file(folder.path("far.toml"), kFarRig); }
  [[nodiscard]] Finished run(const std::string& bench, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "run",  "equilibration",       "--bench", bench, "--sensor", "S-9", "--operator", "me", "-q",
        "--db", folder.path("runs.db")};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_run, words);
  }
  [[nodiscard]] Finished calibrate(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"devices", "calibrate-reference", "--bench", "simulated.toml", "--gauge",
                                      "g",       "--uncertainty",       "0.05"};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_devices, words);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("run: a film's state and a pace are of a bench that is simulated in this process") {
  const RunToRefuse of;
  const Finished state = of.run(of.folder.path("far.toml"), {"--specimen-state", "film.bin"});
  CHECK(state.code == 2);
  CHECK(
      state.err ==
      "error: --specimen-state is for a simulated bench [TB-USAGE]\n  at: --specimen-state\n  try: leave it out: real "
      "film keeps its own state\n");
  const Finished pace = of.run(of.folder.path("far.toml"), {"--rate", "10"});
  CHECK(pace.code == 2);
  CHECK(pace.err ==
        "error: --rate is for a bench simulated in this process [TB-USAGE]\n  at: --rate\n  try: leave it out: "
        "instruments have the pace that they have\n");
  CHECK_FALSE(std::filesystem::exists(of.folder.path("runs.db")));
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--rate", "10"}, {"--specimen-state", "film.bin"}})
    CHECK_THAT(of.run("simulated.toml", more).err, Catch::StartsWith("error: sensor 'S-9' is not registered in "));
}

TEST_CASE("run: an instrument that is overdue is warned of before all else, one that is in date is not") {
  const RunToRefuse of;
  CHECK_THAT(of.run("simulated.toml", {"--set", "reference.due=\"2020-01-31\""}).err,
             Catch::StartsWith("warning: pressure reference (simulated transducer, 100 psi, serial SIM-REF-1) is "
                               "OVERDUE for calibration since 2020-01-31\nerror: sensor 'S-9' is not registered in "));
  CHECK_THAT(of.run("simulated.toml", {"--set", "reference.due=\"2999-01-31\""}).err,
             Catch::StartsWith("error: sensor 'S-9' is not registered in "));
  CHECK_THAT(of.run("simulated.toml", {"--set", "reference.serial=\"FILL-IN\""}).err,
             Catch::Contains("reference.serial") || Catch::Contains("S-9"));
}

TEST_CASE("calibrate-reference: what is refused before a device is opened") {
  const RunToRefuse of;
  const auto refused = [&](const std::vector<std::string>& more, const std::string& said) {
    const Finished done = of.calibrate(more);
    CAPTURE(more);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK(done.err == "error: " + said + "\n");
  };
  write_file(of.folder.path("none.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = \"beckhoff-ek9000\"\n"
             "[regulator]\nserial = \"R\"\n[reference]\nindependent = false\n");
  const Finished none =
      verb_here(bench::add_devices, {"devices", "calibrate-reference", "--bench", of.folder.path("none.toml"),
                                     "--gauge", "g", "--uncertainty", "0.05"});
  CHECK(none.code == 2);
  CHECK(none.err ==
        "error: this bench has no reference of its own to calibrate [TB-USAGE]\n  at: " + of.folder.path("none.toml") +
            "\n  try: set [reference] independent = true and describe the transducer or gauge\n");
  const std::string levels = " [TB-USAGE]\n  at: --levels\n  try: give rising levels within the command limit";
  refused({"--levels", "30"}, "a calibration needs readings at two levels or more" + levels);
  for (const auto& [given, named] : std::vector<std::pair<std::string, std::string>>{
           {"0,20,20", "20"}, {"0,20,10", "10"}, {"0,60.5", "60.5"}, {"-0.5,5", "-0.5"}})
    refused({"--levels=" + given}, "level " + named + " psi does not rise, or is beyond 0 to 60 psi" + levels);
  refused({"--levels=0,40", "--set", "limits.command_psi=39"},
          "level 40 psi does not rise, or is beyond 0 to 39 psi" + levels);
  const std::string mine = of.folder.path("mine");
  write_file(mine, "mine\n");
  const Finished kept = of.calibrate({"--levels", "0,60", "-o", mine});
  CHECK(kept.code == 2);
  CHECK_THAT(kept.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("\n  at: " + mine + "\n"));
  CHECK(read_file(mine) == "mine\n");
  for (const char* wrong : {"-0.1", "10.1", "x"}) {
    std::vector<std::string> words = {"devices",
                                      "calibrate-reference",
                                      "--bench",
                                      "simulated.toml",
                                      "--gauge",
                                      "g",
                                      std::string("--uncertainty=") + wrong};
    CHECK(verb_here(bench::add_devices, words).code == 2);
  }
}

TEST_CASE("dead-man: it serves a socket that is named") {
  const Finished unnamed = verb_here(bench::add_dead_man, {"dead-man"});
  CHECK(unnamed.code == 2);
  CHECK(unnamed.err == "parse: --socket is required\n");
}
