// The exit code of each id that stands in the sources, and that each place that throws it throws it with that code.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "analysis/whole_file.h"
#include "bench/common/error.h"
#include "bench/guard/interlock.h"
#include "db/fleet/fleet_error.h"
#include "db/run_store.h"
#include "sequences/toml/strict_toml.h"
#include "tests/bench/common/id_sites.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using bench::ExitCode;
using tests::all_sites;
using tests::IdSite;

namespace {

// Each without its "TB-". One with two codes is thrown with either.
const std::vector<std::pair<ExitCode, std::string>> kIdsOfCode = {
    {ExitCode::kCriterionFailed, "RUN-HOPELESS SEATING"},
    {ExitCode::kUsage,
     "BASELINE-NO-FIGURES BASELINE-SHORT BENCH-COVERS BENCH-FILL-IN BENCH-LOCKED BENCH-NAME BENCH-NO-STAGE "
     "CALIBRATE-LEVELS "
     "FILE-EXISTS FILE-KEY FILE-MISSING FILE-STORE FILE-SYNTAX FILE-VALUE FILE-WRITE FIT-NONE FLEET-BUILD "
     "FLEET-CONFLICT FLEET-CONNINFO FLEET-FOLDER FLEET-NO-SLURM FLEET-NOT-FOUND FLEET-WHERE FOLDER-UNSAFE "
     "LIVE-SHAPE MERGE-NIGHT MERGE-SHARD PAGE-ADDRESS PAGE-CERTIFICATE PAGE-OPEN SHARD-STORE STORE-PRUNED "
     "MODEL-COMPENSATOR MODEL-DIFF MODEL-DOCUMENT MODEL-DYNAMIC MODEL-OPEN MODEL-SEQUENCE MODEL-TAXEL MODEL-UNITS "
     "MODULE-PROFILE NIGHTLY-BENCH NIGHTLY-SCENARIO RECIPE-DEVICES RECIPE-LIMIT REPORT-NO-VERDICT REPORT-REASON "
     "REPORT-PDF REPORT-SIGNED REPORT-STUDY RESUME-BENCH RUN-AMBIGUOUS RUN-CHANGED RUN-COMPLETED "
     "RUN-DENIED RUN-LIVE RUN-NOT-LIVE RUN-OWN RUN-SILENT RUN-TWICE RUN-VOID RUN-WORD SENSOR-GEOMETRY "
     "SENSOR-UNKNOWN SPECIMEN-STATE STATE-DENIED STORE-BLANK STORE-EXISTS STORE-NOT-FOUND STORE-NOT-TEXT STORE-TAG "
     "STORE-TOO-LONG TABLE-COLUMN TABLE-CONSTANT TABLE-EMPTY TABLE-MAP TABLE-OPEN TABLE-ROW TABLE-SHORT "
     "TABLE-SKIPPED TABLE-STEP TABLE-TURN TREND-NONE USAGE"},
    {ExitCode::kDevice,
     "BRANCH-BROKEN CHAMBER-NOT-ARMED CHAMBER-NOT-VENTED CHAMBER-TIMEOUT CHANNEL DAQMX-CHANNELS "
     "DAQMX-DEVICE DAQMX-ERROR DAQMX-LIBRARY DAQMX-SERIAL DAQMX-SHORT DEADMAN-START DEVICE-NAME "
     "FLEET-CONNECT FLEET-LOGIN FLEET-LOST FLEET-SILENT FLEET-TLS "
     "FORCE-CALIBRATION FORCE-GAUGES FORCE-OVERLOAD FORCE-PROTOCOL FORCE-RECORDS FORCE-SATURATED FORCE-SERIAL "
     "FORCE-STALL FORCE-STATUS FORCE-TIMEOUT HID-LOST HID-OPEN HID-WRITE HTTP-ANSWER HTTP-OPEN HTTP-TIMEOUT "
     "MODBUS-CONNECT MODBUS-EXCEPTION MODBUS-PROTOCOL MODBUS-TIMEOUT MODBUS-VALUE MODULE-CHANNEL "
     "MODULE-INPUT MODULE-READBACK MODULE-SPAN MODULE-WATCHDOG MOUNT-COLLINEAR MOUNT-EDGE MOUNT-NO-TOUCH "
     "MOUNT-RESIDUAL MOUNT-TOUCHES PRESS-FORCE-LIMIT PRESS-NO-APPROACH PRESS-NO-CONTACT PRESS-NO-FORCE "
     "PRESS-NOT-CLEAR PRESS-NOT-FREE PRESS-NOT-HOMED PRESS-SIGN PRESS-TIMEOUT RESUME-DEVICES RUN-SUSPENDED "
     "REFERENCE-FLAT SCANNER-CORRUPT SCANNER-GEOMETRY SCANNER-LOST SCANNER-REFUSED SCANNER-SERIAL SCANNER-STALE "
     "SCANNER-TIMEOUT SERIAL-BUSY SERIAL-LOST SERIAL-OPEN SERIAL-TIMEOUT SIM-LISTEN STAGE-ASTRAY "
     "STAGE-DATA STAGE-HALTED STAGE-MOVING STAGE-NOT-ARMED STAGE-NOT-HOMED STAGE-OVERDUE STAGE-REFUSED "
     "STAGE-TIMEOUT STAGE-WRONG-DEVICE STEP-TIMEOUT UDP-LOST UDP-OPEN"},
    {ExitCode::kStopped,
     "BENCH-TRIPPED CALIBRATION-STOPPED CHAMBER-DISAGREE CHAMBER-LIMIT CHAMBER-RATE CHAMBER-STALE "
     "CHAMBER-TRIP DEADMAN-BLIND DEADMAN-ENDED DEADMAN-FIRED DEADMAN-SILENT FORCE-STALE FORCE-TRIP "
     "GUARD-NOT-ARMED GUARD-TRIPPED PRESS-LIMIT RUN-ABORTED RUN-PANIC RUN-STOPPED STAGE-ENVELOPE "
     "STAGE-LIMIT"},
    {ExitCode::kStore,
     "FLEET-CHANGED FLEET-DENIED FLEET-DIFFERS FLEET-EMPTY FLEET-FULL FLEET-NEWER FLEET-OLDER FLEET-SQL FLEET-TEXT "
     "MODEL-STORED RESUME-SETTINGS STORE-CONFLICT STORE-FOREIGN STORE-FULL STORE-LOCK STORE-LOCKED "
     "STORE-NETWORK STORE-NEWER STORE-OPEN STORE-SQL STORE-TOO-LARGE"},
    {ExitCode::kInconclusive,
     "ANALYSIS-DYNAMICS ANALYSIS-EMPTY ANALYSIS-FALLING ANALYSIS-FRAME ANALYSIS-MODEL ANALYSIS-NO-CALIBRATION "
     "ANALYSIS-NO-FIT ANALYSIS-NO-LOOP ANALYSIS-NO-TAXEL ANALYSIS-ORIGIN ANALYSIS-OTHER-SENSOR "
     "ANALYSIS-REPEATS FLEET-SHARDS FLEET-SLURM MODEL-TAXEL VERIFY-NOT-ENDED"},
    {ExitCode::kUnsafe, "SAFE-UNVERIFIED"},
    {ExitCode::kInternal, "FLEET-TOOL INTERNAL NIGHTLY-SPAWN"},
    {ExitCode::kInterrupted, "DEMO-STOPPED FLEET-STOPPED NIGHTLY-STOPPED RUN-STOPPED"},
    {ExitCode::kTerminated, "DEMO-STOPPED FLEET-STOPPED NIGHTLY-STOPPED RUN-STOPPED"},
};

// Of events, warnings and trips: nothing is thrown with them.
const std::string kIdsWithoutCode = "CALIBRATION RUN-INTERRUPTED TRIP-UNREADABLE";

std::set<std::string> ids_in(const std::string& words) {
  std::set<std::string> ids;
  std::istringstream stream(words);
  for (std::string word; stream >> word;) ids.insert("TB-" + word);
  return ids;
}

std::map<std::string, std::set<ExitCode>> codes_of_ids() {
  std::map<std::string, std::set<ExitCode>> codes;
  for (const auto& [code, words] : kIdsOfCode)
    for (const std::string& id : ids_in(words)) codes[id].insert(code);
  return codes;
}

template <class Thrown>
ExitCode code_when(const Thrown& thrown) {
  try {
    throw thrown;
  } catch (...) {
    return bench::as_error(std::current_exception()).code();
  }
}

bool names(const std::string& text, const std::string& word) { return text.find(word) != std::string::npos; }

ExitCode code_of_fault(const std::string& before) {
  const bool limit = names(before, "Cause::kLimit");
  return code_when(devices::Fault(limit ? devices::Cause::kLimit : devices::Cause::kDevice, "TB-X", "d", "m", "r"));
}

ExitCode code_of_store_error(const std::string& before) {
  return code_when(
      db::StoreError(names(before, "Cause::kUsage") ? db::Cause::kUsage : db::Cause::kStore, "TB-X", "m", "r"));
}

ExitCode code_of_fleet_error(const std::string& before) {
  using db::fleet::FleetCause;
  const FleetCause cause = names(before, "FleetCause::kUsage")  ? FleetCause::kUsage
                           : names(before, "FleetCause::kLink") ? FleetCause::kLink
                                                                : FleetCause::kStore;
  return code_when(db::fleet::FleetError(cause, "TB-X", "m", "r"));
}

ExitCode code_of_analysis_error(const std::string& before) {
  using analysis::Cause;
  const Cause cause = names(before, "Cause::kUsage")    ? Cause::kUsage
                      : names(before, "Cause::kStored") ? Cause::kStored
                                                        : Cause::kNoResult;
  return code_when(analysis::AnalysisError(cause, "TB-X", "m", "r"));
}

ExitCode code_of_unreadable_file() {
  try {
    static_cast<void>(analysis::check_file("/no/such/file", false, "TB-X", "r"));
  } catch (...) {
    return bench::as_error(std::current_exception()).code();
  }
  return ExitCode::kPass;
}

// Written out at the place: Error(ExitCode::kUsage, "TB-..."). Several where the place chooses.
std::set<ExitCode> codes_named(const std::string& before) {
  static const std::map<std::string, ExitCode> kNames = {{"CriterionFailed", ExitCode::kCriterionFailed},
                                                         {"Usage", ExitCode::kUsage},
                                                         {"Device", ExitCode::kDevice},
                                                         {"Stopped", ExitCode::kStopped},
                                                         {"Store", ExitCode::kStore},
                                                         {"Inconclusive", ExitCode::kInconclusive},
                                                         {"Unsafe", ExitCode::kUnsafe},
                                                         {"Internal", ExitCode::kInternal},
                                                         {"Interrupted", ExitCode::kInterrupted},
                                                         {"Terminated", ExitCode::kTerminated}};
  std::set<ExitCode> codes;
  const std::regex name("ExitCode::k([A-Za-z]+)");
  for (auto it = std::sregex_iterator(before.begin(), before.end(), name); it != std::sregex_iterator(); ++it)
    codes.insert(kNames.at((*it)[1]));
  // Of any signal: these two stand for all.
  if (names(before, "code_of_signal(")) codes.insert({ExitCode::kInterrupted, ExitCode::kTerminated});
  return codes;
}

// With what exit code the program ends when that place throws; none: it only names the id.
std::set<ExitCode> codes_at(const IdSite& site) {
  const auto is = [&](std::initializer_list<const char*> calls) {
    return std::find(calls.begin(), calls.end(), site.call) != calls.end();
  };
  if (const std::set<ExitCode> named = codes_named(site.before); !named.empty()) return named;
  if (is({"Interlock", "refuse", "check_fresh"})) return {code_when(bench::Interlock("TB-X", "d", "m", "r"))};
  if (is({"Fault", "fail", "wait"})) return {code_of_fault(site.before)};  // of http_get.cpp, udp_link.cpp
  if (is({"FileError"})) return {code_when(sequences::FileError("TB-X", "m", "w", "r"))};
  if (is({"refuse_word"})) return {ExitCode::kUsage};  // of cli/control.cpp
  if (is({"StoreError"}) || (site.call == "return" && site.file.rfind("db/", 0) == 0)) {
    return {code_of_store_error(site.before)};
  }
  if (is({"FleetError"})) return {code_of_fleet_error(site.before)};
  if (is({"AnalysisError"}) || (site.call == "return" && site.file.rfind("analysis/", 0) == 0)) {
    return {code_of_analysis_error(site.before)};
  }
  if (is({"whole_file", "check_file"})) return {code_of_unreadable_file()};
  return {};
}

}  // namespace

TEST_CASE("exit codes: each id in the sources has one exit code, the same wherever it is thrown") {
  const std::map<std::string, std::set<ExitCode>> codes = codes_of_ids();
  const std::set<std::string> without = ids_in(kIdsWithoutCode);
  REQUIRE(all_sites().size() > 300);
  std::set<std::string> in_sources, thrown;
  for (const IdSite& site : all_sites()) {
    CAPTURE(site.id, site.file, site.call);
    if (site.id.back() == '-') continue;  // the beginning of several
    in_sources.insert(site.id);
    const auto known = codes.find(site.id);
    if (known == codes.end()) {
      CHECK(without.count(site.id) == 1);  // else: a new id, to be entered above with its exit code
      continue;
    }
    for (const ExitCode code : codes_at(site)) {
      CHECK(known->second.count(code) == 1);
      thrown.insert(site.id);
    }
  }
  for (const auto& [id, code] : codes) {
    CAPTURE(id);
    CHECK(in_sources.count(id) == 1);  // else: the id is gone, and its line above should go
    // Named once as a constant, and thrown by that name: dead_man.h.
    if (id.rfind("TB-DEADMAN-", 0) != 0 || id == "TB-DEADMAN-START") CHECK(thrown.count(id) == 1);
  }
}

TEST_CASE("exit codes: each id named in the documents exists in the sources") {
  std::set<std::string> in_sources;
  for (const IdSite& site : all_sites()) in_sources.insert(site.id);
  const std::regex word("TB-[A-Z0-9-]*[A-Z0-9]");
  std::size_t found = 0;
  std::vector<std::string> documents = {"README.md", "CHANGELOG.md", "analysis/README.md", "tests/mutants/README.md"};
  const std::string folder = tests::source_path("docs");
  if (std::filesystem::exists(folder)) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".md")
        documents.push_back(entry.path().string().substr(tests::source_path("").size()));
  }
  for (const std::string& document : documents) {
    const std::string text = tests::read_file(tests::source_path(document));
    for (auto it = std::sregex_iterator(text.begin(), text.end(), word); it != std::sregex_iterator(); ++it) {
      CAPTURE(document, it->str());
      CHECK((in_sources.count(it->str()) == 1 || it->suffix().str().substr(0, 1) == "-"));
      ++found;
    }
  }
  CHECK(found > 40);
}

TEST_CASE("exit codes: whatever the guard throws is an interlock, whose cause is a limit whatever its id") {
  CHECK(bench::Interlock("TB-NEW-INTERLOCK", "d", "m", "r").cause() == devices::Cause::kLimit);
  CHECK(code_when(bench::Interlock("TB-NEW-INTERLOCK", "d", "m", "r")) == ExitCode::kStopped);
  std::size_t throws = 0;
  const std::string folder = tests::source_path("bench/guard");
  const std::regex thrower("throw ([A-Za-z:]+)");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().rfind("guard", 0) != 0) continue;
    const std::string text = tests::read_file(entry.path().string());
    for (auto it = std::sregex_iterator(text.begin(), text.end(), thrower); it != std::sregex_iterator(); ++it) {
      CAPTURE(entry.path().string());
      CHECK((*it)[1] == "Interlock");
      ++throws;
    }
  }
  CHECK(throws == 4);  // refuse(), and three trips: pressure, force, the force sensor's own limits
}

TEST_CASE("exit codes: the cause decides, not the id") {
  using devices::Cause;
  CHECK(code_when(devices::Fault("TB-CHAMBER-TRIP", "d", "m", "r")) == ExitCode::kDevice);
  CHECK(code_when(devices::Fault(Cause::kLimit, "TB-MODBUS-TIMEOUT", "d", "m", "r")) == ExitCode::kStopped);
  CHECK(code_when(db::StoreError("TB-STORE-NOT-FOUND", "m", "r")) == ExitCode::kStore);
  CHECK(code_when(db::StoreError(db::Cause::kUsage, "TB-STORE-SQL", "m", "r")) == ExitCode::kUsage);
  CHECK(code_when(analysis::AnalysisError("TB-TABLE-ROW", "m", "r")) == ExitCode::kInconclusive);
  CHECK(code_when(analysis::AnalysisError(analysis::Cause::kStored, "TB-X", "m", "r")) == ExitCode::kStore);
  CHECK(code_when(analysis::AnalysisError(analysis::Cause::kUsage, "TB-X", "m", "r")) == ExitCode::kUsage);
}
