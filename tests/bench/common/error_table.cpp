// The table of errors: it has what the sources name, and an error takes its exit code and remedy from it. An error that
// was asked for, one as JSON, and what becomes of the errors of each room.
#include "bench/common/error_table.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/error.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "sequences/toml/strict_toml.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using bench::Error;
using bench::ExitCode;
namespace fs = std::filesystem;

namespace {

std::set<std::string> ids_in(const std::string& text, const char* pattern) {
  const std::regex id(pattern);
  std::set<std::string> ids;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), id); it != std::sregex_iterator(); ++it)
    ids.insert((*it)[1]);
  return ids;
}

template <class Thrown>
ExitCode code_when(const Thrown& thrown) {
  try {
    throw thrown;
  } catch (...) {
    return bench::as_error(std::current_exception()).code();
  }
}

using ErrorParts = std::tuple<std::string, std::string, std::string, std::string>;

template <class Thrown>
ErrorParts parts_when(const Thrown& thrown, const std::string& where) {
  try {
    throw thrown;
  } catch (...) {
    const Error error = bench::as_error(std::current_exception(), where);
    CHECK(error.rig_state().empty());
    CHECK_FALSE(error.asked_for());
    return {error.id(), error.what(), error.where(), error.remedy()};
  }
}

}  // namespace

TEST_CASE("error table: has a row for each id in the sources, and no others") {
  std::set<std::string> in_sources, in_table;
  for (const char* room : {"devices", "db", "sequences", "analysis", "bench"}) {
    for (const auto& entry : fs::recursive_directory_iterator(tests::source_path(room))) {
      const fs::path& path = entry.path();
      if ((path.extension() == ".h" || path.extension() == ".cpp") && path.filename() != "error_table.h")
        in_sources.merge(ids_in(tests::read_file(path.string()), "\"(TB-[A-Z0-9-]*[A-Z0-9])\""));
    }
  }
  for (const bench::ErrorRow& row : bench::kErrorTable) in_table.insert(std::string(row.id));
  for (const std::string& id : in_sources) {
    INFO("without a row: " << id);
    CHECK(in_table.contains(id));
  }
  for (const std::string& id : in_table) {
    INFO("named nowhere: " << id);
    CHECK(in_sources.contains(id));
  }
}

TEST_CASE("error table: documents name no other ids") {
  std::set<std::string> named;
  for (const auto& entry : fs::recursive_directory_iterator(tests::source_path("docs"))) {
    if (entry.path().extension() == ".md")
      named.merge(ids_in(tests::read_file(entry.path().string()), "(TB-[A-Z0-9-]*[A-Z0-9])(?![A-Z0-9]*-)"));
  }
  CHECK(named.size() > 40);
  for (const std::string& id : named) {
    CAPTURE(id);
    CHECK(bench::error_row(id) != nullptr);
  }
}

TEST_CASE("error table: each row has a known exit code, and a cause and a remedy without final full stop") {
  for (const bench::ErrorRow& row : bench::kErrorTable) {
    CAPTURE(row.id);
    const int code = static_cast<int>(row.exit_code);
    CHECK(((code >= 0 && code <= 7) || code == 70 || code == 130));
    for (const std::string_view text : {row.cause, row.remedy}) {
      REQUIRE(text.size() > 10);
      CHECK(text.back() != '.');
    }
  }
}

TEST_CASE("error table: the exit code follows from the id, whatever module throws the error") {
  CHECK(code_when(devices::Fault("TB-MODBUS-TIMEOUT", "d", "m", "r")) == ExitCode::kDevice);
  CHECK(code_when(devices::Fault("TB-CHAMBER-TRIP", "d", "m", "r")) == ExitCode::kStopped);
  CHECK(code_when(sequences::FileError("TB-FILE-KEY", "m", "w", "r")) == ExitCode::kUsage);
  CHECK(code_when(db::StoreError("TB-STORE-OPEN", "m", "r")) == ExitCode::kStore);
  CHECK(code_when(db::StoreError("TB-STORE-NOT-FOUND", "m", "r")) == ExitCode::kUsage);
  CHECK(code_when(analysis::AnalysisError("TB-ANALYSIS-NO-LOOP", "m", "r")) == ExitCode::kInconclusive);
  CHECK(code_when(analysis::AnalysisError("TB-TABLE-ROW", "m", "r")) == ExitCode::kUsage);
  CHECK(code_when(bench::Error("TB-SEATING", "m", "w")) == ExitCode::kCriterionFailed);
  CHECK(code_when(bench::Error("TB-SAFE-UNVERIFIED", "m", "w")) == ExitCode::kUnsafe);
  CHECK(code_when(std::bad_alloc()) == ExitCode::kStopped);
  CHECK(code_when(devices::Fault("TB-NOT-IN-THE-TABLE", "d", "m", "r")) == ExitCode::kInternal);
  CHECK(bench::Error("TB-RUN-STOPPED", "m", "w").by_signal(15).code() == ExitCode::kTerminated);
  CHECK(bench::Error("TB-RUN-STOPPED", "m", "w").by_signal(0).code() == ExitCode::kStopped);
}

TEST_CASE("error table: its remedy is used if the error has none") {
  CHECK(bench::Error("TB-STORE-LOCK", "m", "w").remedy() == bench::error_row("TB-STORE-LOCK")->remedy);
  CHECK(bench::Error("TB-STORE-LOCK", "m", "w", "own").remedy() == "own");
}

TEST_CASE("error: a requested stop does not count as an error, unless the rig is not safe") {
  const Error stopped("TB-RUN-STOPPED", "stopped by bob", "", "resume");
  CHECK_FALSE(stopped.asked_for());
  const Error asked = stopped.by_command();
  CHECK(asked.asked_for());
  CHECK_FALSE(stopped.asked_for());
  const Error safe = asked.with_rig_state("vented", true), unsafe = asked.with_rig_state("loaded", false);
  CHECK(safe.code() == ExitCode::kStopped);
  CHECK(safe.asked_for());
  CHECK(unsafe.code() == ExitCode::kUnsafe);
}

TEST_CASE("error: the JSON document has id, exit code, cause, remedy and rig state") {
  const auto json = nlohmann::json::parse(error_json(Error("TB-STORE-FULL", "full", "s.db", "make room", "vented")));
  CHECK(json == nlohmann::json{{"schema", "tactbench.error"},
                               {"version", 1},
                               {"id", "TB-STORE-FULL"},
                               {"exit_code", 5},
                               {"cause", bench::error_row("TB-STORE-FULL")->cause},
                               {"message", "full"},
                               {"where", "s.db"},
                               {"remedy", "make room"},
                               {"rig_state", "vented"}});
}

TEST_CASE("error: errors of every module keep their text, and get a place if they have none") {
  const devices::Fault fault("TB-CHAMBER-TRIP", "valve", "stuck", "tap it");
  CHECK(parts_when(fault, "") == ErrorParts{"TB-CHAMBER-TRIP", "stuck", "valve", "tap it"});
  CHECK(parts_when(fault, "run 3") == ErrorParts{"TB-CHAMBER-TRIP", "stuck", "run 3, valve", "tap it"});
  CHECK(parts_when(sequences::FileError("TB-FILE-KEY", "odd", "f:1:2", "fix"), "run 3") ==
        ErrorParts{"TB-FILE-KEY", "odd", "f:1:2", "fix"});
  CHECK(parts_when(db::StoreError("TB-STORE-FULL", "full", "room"), "run 3") ==
        ErrorParts{"TB-STORE-FULL", "full", "run 3", "room"});
  CHECK(parts_when(analysis::AnalysisError("TB-ANALYSIS-NO-LOOP", "flat", "again"), "run 3") ==
        ErrorParts{"TB-ANALYSIS-NO-LOOP", "flat", "run 3", "again"});
  const std::string report(bench::error_row("TB-INTERNAL")->remedy);
  CHECK(parts_when(std::runtime_error("odd"), "run 3") == ErrorParts{"TB-INTERNAL", "odd", "run 3", report});
  const std::string limit(bench::error_row("TB-SYSTEM-LIMIT")->remedy);
  CHECK(limit.find("report") == std::string::npos);
  CHECK(parts_when(std::bad_alloc(), "run 3") == ErrorParts{"TB-SYSTEM-LIMIT", "too little memory", "run 3", limit});
  for (const int number : {EAGAIN, ENOMEM, EMFILE, ENFILE, EPERM}) {
    const ErrorParts parts = parts_when(std::system_error(number, std::generic_category()), "run 3");
    CHECK(std::get<0>(parts) == (number == EPERM ? "TB-INTERNAL" : "TB-SYSTEM-LIMIT"));
  }
  CHECK(parts_when(7, "run 3") == ErrorParts{"TB-INTERNAL", "unknown failure", "run 3", report});
  CHECK(parts_when(Error("TB-USAGE", "m", "w", "r"), "run 3") == ErrorParts{"TB-USAGE", "m", "w", "r"});
}

TEST_CASE("overrides: recipe keys are separated from bench keys, and pressures are converted from other units") {
  const bench::SplitOverrides split = bench::split_overrides(
      {"recipe.step=2", "recipe.=x", "bench.id=a=b", "x_psi=2 bar", "x_psi.y=2bar", "k=", "recipex=1"});
  const auto told = [](const std::vector<sequences::Override>& list) {
    std::vector<std::string> all;
    for (const sequences::Override& one : list) all.push_back(one.key + "|" + one.value + "|" + one.typed);
    return all;
  };
  using Words = std::vector<std::string>;
  CHECK(told(split.all) ==
        Words{"recipe.step|2|", "recipe.|x|", "bench.id|a=b|", "x_psi|2 bar|", "x_psi.y|2bar|", "k||", "recipex|1|"});
  CHECK(told(split.recipe) == Words{"step|2|", "|x|"});
  REQUIRE(split.bench.size() == 5);
  CHECK(told(split.bench)[0] == "bench.id|a=b|a=b");
  CHECK(std::stod(split.bench[1].value) == Approx(29.00755).epsilon(1e-6));
  CHECK(split.bench[1].typed == "2 bar");
  CHECK(told(split.bench)[2] == "x_psi.y|2bar|2bar");
  CHECK(told(split.bench)[3] == "k||");
  CHECK(told(split.bench)[4] == "recipex|1|1");
  for (const char* odd : {"", "key", "=", "=value"}) {
    try {
      (void)bench::split_overrides({"a=1", odd});
      FAIL("it was taken");
    } catch (const Error& error) {
      CHECK(error.id() == "TB-USAGE");
      CHECK(error.code() == ExitCode::kUsage);
      CHECK(error.where() == "--set " + std::string(odd));
    }
  }
}

TEST_CASE("time: utc_now and utc_days_ago are in UTC, seconds_between is 0 for invalid times") {
  const auto seconds_of = [](const std::string& text) {
    REQUIRE(text.size() == 20);
    return bench::seconds_between("1970-01-01T00:00:00Z", text);
  };
  const double before = static_cast<double>(std::time(nullptr));
  const double now = seconds_of(bench::utc_now()), then = seconds_of(bench::utc_days_ago(3));
  const double after = static_cast<double>(std::time(nullptr));
  CHECK((before <= now && now <= after));
  CHECK((before <= then + 3 * 86400.0 && then + 3 * 86400.0 <= after));
  CHECK(bench::seconds_between("1970-01-01T00:00:00Z", "1970-01-01T00:00:05Z") == 5.0);
  CHECK(bench::seconds_between("yesterday", "1970-01-01T00:00:05Z") == 0.0);
  CHECK(bench::seconds_between("1969-12-31T23:59:50Z", "1970-01-01T00:00:05Z") == 0.0);
}
