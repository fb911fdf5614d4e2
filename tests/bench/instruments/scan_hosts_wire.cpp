// `devices scan` of Modbus hosts: one that answers, one that refuses a register, none, and addresses that are none.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "bench/common/error.h"
#include "bench/instruments/scan.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
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
  CHECK_THAT(told_of_host(host), Catch::StartsWith(host + ": answers; input register 0 holds "));
  rig.plant()->inject(bench::FaultKind::kModuleException, std::nullopt, 0);
  CHECK(told_of_host(host) == host + ": answers (and refuses to read input register 0)");
  CHECK_THAT(told_of_host("127.0.0.1:1"), Catch::Contains("127.0.0.1:1") && Catch::EndsWith("Connection refused"));
  CHECK_THAT(told_of_host("127.0.0.1:65535"), Catch::EndsWith("Connection refused"));
}

TEST_CASE("scan of hosts: an address that is none is refused before anything is asked") {
  for (const char* address : {"host:0", "host:-1", "host:65536", ":502", "", "host:abc"}) {
    INFO(address);
    try {
      (void)bench::scan_devices({address});
      FAIL("it was taken");
    } catch (const bench::Error& error) {
      CHECK(error.code() == bench::ExitCode::kUsage);
      CHECK(error.id() == "TB-USAGE");
      CHECK(std::string(error.what()) == fmt::format("'{}' is not HOST or HOST:PORT", address));
      CHECK(error.where() == std::string("--modbus ") + address);
      CHECK(error.remedy() == "e.g. --modbus 192.168.0.10:502");
    }
  }
}
