// Stopping a night ends its scenarios and leaves no folder behind.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/support/endless_run.h"

using namespace tactbench::tests;

namespace {

// Processes whose environment says that they belong to `folder`.
int living_below(const std::string& folder) {
  int count = 0;
  std::error_code gone;
  for (const auto& process : std::filesystem::directory_iterator("/proc", gone)) {
    std::ifstream environment(process.path() / "environ", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(environment), {}};
    count += text.find("TMPDIR=" + folder) != std::string::npos ? 1 : 0;
  }
  return count;
}

struct EndlessNight {
  EndlessNight() {
    write_file(folder.path("long.toml"),
               "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
    write_file(
        folder.path("night.toml"),
        "schema = 1\nname = \"night\"\n[[scenario]]\nname = \"one\"\nabout = \"long\"\nrecipes = [\"./long.toml\"]\n"
        "fits = false\n[[scenario]]\nname = \"two\"\nabout = \"long\"\nrecipes = [\"./long.toml\"]\nfits = false\n");
    std::filesystem::create_directory(folder.path("tmp"));
    night = std::make_unique<ChildProcess>(
        std::vector<std::string>{"/bin/sh", "-c",
                                 fmt::format("cd '{0}' && TMPDIR='{0}/tmp' exec '{1}' nightly ./night.toml >log 2>&1",
                                             folder.path(), program_path())});
  }
  [[nodiscard]] std::string temporary() const { return folder.path("tmp"); }
  // The night, two scenarios, and both rigs are made.
  [[nodiscard]] bool under_way() const {
    return comes_true([&] {
      int rigs = 0;
      for (const auto& entry : std::filesystem::directory_iterator(temporary()))
        rigs += entry.path().filename().string().starts_with("tactbench-night") ? 0 : 1;
      return living_below(temporary()) == 3 && rigs == 2;
    });
  }
  const TemporaryFolder folder;
  std::unique_ptr<ChildProcess> night;
};

}  // namespace

TEST_CASE("night: Ctrl-C or SIGTERM ends it, its scenarios and its temporary folders") {
  const auto [signal, code] = GENERATE(table<int, int>({{SIGINT, 130}, {SIGTERM, 143}}));
  const EndlessNight night;
  REQUIRE(night.under_way());
  night.night->signal(signal);
  CHECK(night.night->wait() == code);
  CHECK(living_below(night.temporary()) == 0);
  CHECK(std::filesystem::is_empty(night.temporary()));
  CHECK_THAT(read_file(night.folder.path("log")), Catch::Contains("TB-NIGHTLY-STOPPED"));
}

TEST_CASE("night: when its process is killed, its scenarios end") {
  const EndlessNight night;
  REQUIRE(night.under_way());
  night.night->signal(SIGKILL);
  (void)night.night->wait();
  CHECK(comes_true([&] { return living_below(night.temporary()) == 0; }));
  // The next night removes its remains.
  const auto left = [&] {
    const std::filesystem::directory_iterator all(night.temporary());
    return std::count_if(begin(all), end(all), [](const auto& entry) {
      return entry.path().filename().string().starts_with("tactbench-night");
    });
  };
  CHECK(left() == 2);
  write_file(night.folder.path("none.toml"),
             "schema = 1\nname = \"none\"\n[[scenario]]\nname = \"one\"\nabout = \"no such recipe\"\nrecipes = "
             "[\"no-such\"]\n");
  const Finished next = run_program(
      "/usr/bin/env", {"TMPDIR=" + night.temporary(), program_path(), "nightly", "./none.toml"}, night.folder.path());
  CHECK(next.code == 1);
  CHECK(left() == 0);
}
