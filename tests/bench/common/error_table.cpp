// The table of errors: it has what the sources name, and an error takes its exit code and remedy from it.
#include "bench/common/error_table.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <utility>

#include "analysis/error.h"
#include "bench/common/error.h"
#include "db/run_store.h"
#include "devices/fault.h"
#include "sequences/toml/strict_toml.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
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

}  // namespace

TEST_CASE("error table: a row for each id that the sources name, and no others") {
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

TEST_CASE("error table: each row has a known exit code, a cause and a remedy, as clauses") {
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

TEST_CASE("error table: the exit code follows from the id, in whatever room it was thrown") {
  CHECK(code_when(devices::Fault("TB-MODBUS-TIMEOUT", "d", "m", "r")) == ExitCode::kDevice);
  CHECK(code_when(devices::Fault("TB-CHAMBER-TRIP", "d", "m", "r")) == ExitCode::kStopped);
  CHECK(code_when(sequences::FileError("TB-FILE-KEY", "m", "w", "r")) == ExitCode::kUsage);
  CHECK(code_when(db::StoreError("TB-STORE-OPEN", "m", "r")) == ExitCode::kStore);
  CHECK(code_when(db::StoreError("TB-STORE-NOT-FOUND", "m", "r")) == ExitCode::kUsage);
  CHECK(code_when(analysis::AnalysisError("TB-ANALYSIS-NO-LOOP", "m", "r")) == ExitCode::kInconclusive);
  CHECK(code_when(analysis::AnalysisError("TB-TABLE-ROW", "m", "r")) == ExitCode::kUsage);
  CHECK(code_when(bench::Error("TB-SEATING", "m", "w")) == ExitCode::kCriterionFailed);
  CHECK(code_when(bench::Error("TB-SAFE-UNVERIFIED", "m", "w")) == ExitCode::kUnsafe);
  CHECK(code_when(devices::Fault("TB-NOT-IN-THE-TABLE", "d", "m", "r")) == ExitCode::kInternal);
  CHECK(bench::Error("TB-RUN-STOPPED", "m", "w").by_signal(15).code() == ExitCode::kTerminated);
  CHECK(bench::Error("TB-RUN-STOPPED", "m", "w").by_signal(0).code() == ExitCode::kStopped);
}

TEST_CASE("error table: the remedy is the table's where the place that throws has none") {
  CHECK(bench::Error("TB-STORE-LOCK", "m", "w").remedy() == bench::error_row("TB-STORE-LOCK")->remedy);
  CHECK(bench::Error("TB-STORE-LOCK", "m", "w", "own").remedy() == "own");
}
