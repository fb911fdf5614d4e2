// run, resume and devices calibrate-reference: what is refused, or warned of, before a device is opened.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "tests/bench/cli/store_here.h"

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
    return verb_here(bench::add_run, joined_arguments({"run", "equilibration", "--bench", bench, "--sensor", "S-9",
                                                       "--operator", "me", "-q", "--db", folder.path("runs.db")},
                                                      more));
  }
  [[nodiscard]] Finished calibrate(const std::vector<std::string>& more) const {
    return verb_here(bench::add_devices, joined_arguments({"devices", "calibrate-reference", "--bench",
                                                           "simulated.toml", "--gauge", "g", "--uncertainty", "0.05"},
                                                          more));
  }
  TemporaryFolder folder;
};

// A store whose one run has these settings and is of the simulated bench.
struct StoreToResume : OpenStoreHere {
  explicit StoreToResume(const std::string& overrides) {
    db::RunRecord run = example_run();
    run.overrides_json = overrides;
    run.bench_id = "another-rig";
    run.bench_toml = read_file(bench::find_config("simulated.toml"));
    (void)begin_example(store, run);
  }
  Finished resume(const std::vector<std::string>& more = {}) const {
    return say(bench::add_control, joined_arguments({"resume", "1"}, more));
  }
};

}  // namespace

TEST_CASE("run: --specimen-state and --rate are accepted only for a bench simulated in this process") {
  const RunToRefuse of;
  check_refusal(of.run(of.folder.path("far.toml"), {"--specimen-state", "film.bin"}), 2, "TB-USAGE",
                "--specimen-state");
  check_refusal(of.run(of.folder.path("far.toml"), {"--rate", "10"}), 2, "TB-USAGE", "--rate");
  CHECK_FALSE(std::filesystem::exists(of.folder.path("runs.db")));
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--rate", "10"}, {"--specimen-state", "film.bin"}})
    CHECK_THAT(of.run("simulated.toml", more).err, Catch::Contains("[TB-SENSOR-UNKNOWN]"));
}

TEST_CASE("run: warns about an overdue instrument before any other error, and not about a valid one") {
  const RunToRefuse of;
  const auto said = [&](const std::string& due) {
    return of.run("simulated.toml", {"--set", "reference.due=\"" + due + "\""}).err;
  };
  CHECK_THAT(said("2020-01-31"), Catch::Contains("2020-01-31") && Catch::Contains("[TB-SENSOR-UNKNOWN]"));
  CHECK_THAT(said("2999-01-31"), !Catch::Contains("2999") && Catch::Contains("[TB-SENSOR-UNKNOWN]"));
}

TEST_CASE("calibrate-reference: invalid options are rejected before a device is opened") {
  const RunToRefuse of;
  const auto refused = [&](const std::vector<std::string>& more) {
    const Finished done = of.calibrate(more);
    CAPTURE(more);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::Contains("[TB-USAGE]\n  at: --levels\n"));
  };
  write_file(of.folder.path("none.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = \"beckhoff-ek9000\"\n"
             "[regulator]\nserial = \"R\"\n[reference]\nindependent = false\n");
  check_refusal(verb_here(bench::add_devices, {"devices", "calibrate-reference", "--bench", of.folder.path("none.toml"),
                                               "--gauge", "g", "--uncertainty", "0.05"}),
                2, "TB-USAGE");
  for (const char* levels : {"30", "0,20,20", "0,20,10", "0,60.5", "-0.5,5"})
    refused({std::string("--levels=") + levels});
  refused({"--levels=0,40", "--set", "limits.command_psi=39"});
  const std::string mine = of.folder.path("mine");
  write_file(mine, "mine\n");
  const Finished kept = of.calibrate({"--levels", "0,60", "-o", mine});
  CHECK(kept.code == 2);
  CHECK_THAT(kept.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("\n  at: " + mine + "\n"));
  CHECK(read_file(mine) == "mine\n");
  for (const char* wrong : {"-0.1", "10.1", "x"})
    CHECK(verb_here(bench::add_devices, {"devices", "calibrate-reference", "--bench", "simulated.toml", "--gauge", "g",
                                         std::string("--uncertainty=") + wrong})
              .code == 2);
}

TEST_CASE("dead-man: rejects a call without a socket name") {
  CHECK(verb_here(bench::add_dead_man, {"dead-man"}).code == 2);
}

TEST_CASE("resume: rejects invalid stored settings, and another bench") {
  for (const char* broken : {"{", "7", R"([{"key":"a"}])", R"([{"key":1,"value":"1"}])"}) {
    INFO(broken);
    const StoreToResume store(broken);
    check_refusal(store.resume(), 5, "TB-RESUME-SETTINGS");
  }
  const StoreToResume store("[]");
  CHECK_THAT(store.resume().err, Catch::Contains("[TB-RESUME-BENCH]"));
  check_refusal(store.resume({"--bench", "simulated.toml"}), 2, "TB-RESUME-BENCH", "simulated.toml");
  const StoreToResume settings(R"([{"key":"limits.comand_psi","value":"1"}])");
  CHECK_THAT(settings.resume().err, Catch::Contains("[TB-FILE-KEY]") && Catch::Contains("limits.comand_psi"));
  check_refusal(store.say(bench::add_control, {"resume", "9"}), 2, "TB-STORE-NOT-FOUND");
}
