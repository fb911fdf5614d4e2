// `devices scan` of Modbus hosts: one that answers, one that refuses a register, none, and addresses that are none.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "bench/common/error.h"
#include "bench/instruments/scan.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::string told_of_host(const std::string& host) {
  for (const bench::ScanEntry& entry : bench::scan_devices({host}))
    if (entry.kind == "Modbus TCP") return entry.where + ": " + entry.what;
  return "(none)";
}

}  // namespace

TEST_CASE("scan of hosts: a module that answers, refuses, or is not there is told so") {
  bench::Rig rig(small_request().bench);
  const std::string host = fmt::format("127.0.0.1:{}", rig.config().module.endpoint.port);
  const std::string answers = told_of_host(host);
  CHECK_THAT(answers, Catch::StartsWith(host + ": ") && Catch::Contains("register 0"));
  rig.plant()->inject(bench::FaultKind::kModuleException, std::nullopt, 0);
  CHECK_THAT(told_of_host(host), Catch::StartsWith(host + ": "));
  CHECK(told_of_host(host) != answers);
  for (const char* none : {"127.0.0.1:1", "127.0.0.1:65535"})
    CHECK_THAT(told_of_host(none), Catch::Contains("refused"));
}

TEST_CASE("scan of hosts: an address that is none is refused before anything is asked") {
  for (const char* address : {"host:0", "host:-1", "host:65536", ":502", "", "host:abc"}) {
    INFO(address);
    const auto refused = refusal_by([&] { (void)bench::scan_devices({address}); });
    REQUIRE(refused);
    CHECK((refused->id() == "TB-USAGE" && refused->code() == bench::ExitCode::kUsage));
    CHECK_THAT(refused->where(), Catch::EndsWith(std::string(" ") + address));
  }
}
