#include "bench/cli/reports/reports_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/whole_file.h"
#include "bench/common/utc.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/signature.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kLargestReport = 1'000'000'000;  // bytes

struct KnownReport {
  db::RunRecord run;
  db::ReportRecord report;
  db::ReportRecord next;  // the one that replaced it; without number: none
};

std::optional<KnownReport> known_report(const db::RunStore& store, const std::string& number) {
  for (const db::RunRecord& run : store.runs()) {
    const std::vector<db::ReportRecord> reports = store.reports(run.run);
    const auto found = std::ranges::find(reports, number, &db::ReportRecord::number);
    if (found == reports.end()) continue;
    const auto next = std::ranges::find(reports, number, &db::ReportRecord::replaces);
    return KnownReport{run, *found, next == reports.end() ? db::ReportRecord() : *next};
  }
  return std::nullopt;
}

bool is_number(const std::string& word) {
  const std::size_t dash = word.find('-');
  const auto all = [](std::string_view text, const char* letters) {
    return !text.empty() && text.find_first_not_of(letters) == std::string_view::npos;
  };
  return dash != std::string::npos && all(std::string_view(word).substr(0, dash), "0123456789") &&
         word.size() - dash == 9 && all(std::string_view(word).substr(dash + 1), "0123456789abcdef");
}

// What was found on one file.
struct Finding {
  std::string file, sha256, state, words;  // state: unchanged, changed, not kept, not signed, unknown, no file
  ExitCode code = ExitCode::kPass;
  std::optional<SignatureFinding> signature = {};
};

Finding look_at(const KnownReport& known, const std::string& path) {
  Finding out;
  out.file = path;
  out.sha256 = db::sha256_hex(
      analysis::whole_file(path, {.most_bytes = kLargestReport}, "TB-TABLE-OPEN", "check its name and rights"));
  const std::string& notes = known.run.notes;
  if (const std::size_t at = notes.find(report_file_note(known.report.number, out.sha256)); at != std::string::npos) {
    const std::size_t begin = at == 0 ? 0 : notes.rfind('\n', at) + 1;  // npos + 1 is 0
    out.state = "unchanged";
    out.words = fmt::format("unchanged since it was written ({})", one_line(notes.substr(begin, at - begin - 1)));
  } else if (notes.find(report_file_note(known.report.number, "")) == std::string::npos) {
    out.state = "not kept";
    out.words = "cannot be told: the program that signed it kept no hash of its file";
    out.code = ExitCode::kInconclusive;
  } else {
    out.state = "changed";
    out.words = "CHANGED: it is none of the files that were written of this report";
    out.code = ExitCode::kCriterionFailed;
  }
  return out;
}

void tell_file(const Finding& one) {
  tty::print("file      {}{}{}\n", one_line(one.file), one.file.empty() ? "" : ": ", one.words);
  if (!one.signature) return;
  const SignatureFinding& signature = *one.signature;
  tty::print("signature {}{}{}\n", one_line(signature.words, kLongestText),
             signature.signer.empty() ? "" : "; by " + one_line(signature.signer),
             signature.signed_utc.empty() ? "" : ", " + signature.signed_utc + " by the signer's clock");
}

void tell(const std::string& number, const std::optional<KnownReport>& known, const std::vector<Finding>& findings,
          const ReportEvidence& evidence, Session& session) {
  const auto worsen = [&](ExitCode code) {
    if (code == ExitCode::kCriterionFailed || session.code == ExitCode::kPass) session.code = code;
  };
  for (const Finding& finding : findings) {
    worsen(finding.code);
    if (finding.signature) worsen(finding.signature->code);
  }
  const char* const state = !evidence.fallen.empty() ? "fallen" : !evidence.missing.empty() ? "unknown" : "holds";
  if (known && !evidence.missing.empty()) worsen(ExitCode::kInconclusive);
  if (!evidence.fallen.empty()) worsen(ExitCode::kCriterionFailed);
  if (session.json) {
    auto files = nlohmann::ordered_json::array();
    for (const Finding& one : findings) {
      files.push_back({JSON_FIELDS(one, file, sha256, state)});
      if (one.signature)
        files.back()["signature"] = {{"state", one.signature->state},
                                     {"signer", one.signature->signer},
                                     {"signed_utc", one.signature->signed_utc}};
    }
    nlohmann::ordered_json json = {{"number", number}, {"signed", known.has_value()}, {"files", files}};
    if (known) {
      json["evidence"] = {{"state", state}, JSON_FIELDS(evidence, fallen, missing)};
      json["run"] = known->run.run;
      json["sensor"] = known->run.sensor_serial;
      json["origin"] = known->run.origin;
      json["by"] = known->report.approved_by;
      json["signed_utc"] = known->report.approved_utc;
      json["replaces"] = known->report.replaces;
      json["reason"] = known->report.reason;
      json["replaced_by"] = known->next.number;
      json["replaced_because"] = known->next.reason;
    }
    return print_json("report.verify", json);
  }
  if (known)
    tty::print("report {}: of run {}, sensor {}{}; signed by {}, {}\n", number, known->run.run,
               one_line(known->run.sensor_serial), known->run.origin == "simulated" ? " (simulated)" : "",
               one_line(known->report.approved_by), known->report.approved_utc);
  for (const Finding& one : findings) tell_file(one);
  if (known && evidence.fallen.empty() && evidence.missing.empty())
    tty::print("evidence  holds: none of the {} that it rests on is void or changed\n",
               analysis::counted(known->report.evidence.size(), "run"));
  for (const std::string& line : evidence.fallen) tty::print("evidence  FALLEN: {}\n", one_line(line, kLongestText));
  for (const std::string& line : evidence.missing)
    tty::print("evidence  cannot be told: {}\n", one_line(line, kLongestText));
  if (known && !known->next.number.empty())
    tty::print("replaced by report {}{}{}\n", known->next.number, known->next.reason.empty() ? "" : ": ",
               one_line(known->next.reason, kLongestText));
}

}  // namespace

std::string report_file_note(const std::string& number, const std::string& sha256) {
  return fmt::format("file of the signed report {}: sha256 {}", number, sha256);
}

void keep_file_of_signed(const std::string& path, const std::string& number, std::int64_t run, const Session& session) {
  if (!std::filesystem::is_regular_file(path)) return;
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::vector<db::ReportRecord> signed_ones = store.reports(run);
  if (std::ranges::find(signed_ones, number, &db::ReportRecord::number) == signed_ones.end()) return;
  const std::string bytes =
      analysis::whole_file(path, {.most_bytes = kLargestReport}, "TB-TABLE-OPEN", "check its name and rights");
  const std::string line = report_file_note(number, db::sha256_hex(bytes));
  if (store.run(run).notes.find(line) != std::string::npos) return;
  try {
    db::RunStore::open(session.db).add_note(run, fmt::format("{} {}", utc_now(), line));
  } catch (const db::StoreError& error) {  // an archive that only can be read
    tty::print(stderr, "warning: {} is not known to `report verify`: {}\n", path, error.what());
  }
}

void verify_report(const std::string& named, const std::string& root, Session& session) {
  const bool is_file = std::filesystem::is_regular_file(named);
  if (is_file && !root.empty() && !std::filesystem::exists(session.db)) {  // a customer has none
    const Finding alone{
        named,           "",
        "unknown",       fmt::format("there is no store {}: its signature alone is looked at", session.db),
        ExitCode::kPass, check_signature_of(named, root)};
    return tell("", std::nullopt, {alone}, {}, session);
  }
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  if (!is_file && !is_number(named))
    throw Error("TB-USAGE", fmt::format("'{}' is neither a file nor the number of a report", named), "report verify",
                "a number is as in 1-2ccd46bc: tactbench report list shows those that were signed");
  const std::string number = is_file ? signed_report_in(named, store) : named;
  const std::optional<KnownReport> known = number.empty() ? std::optional<KnownReport>() : known_report(store, number);
  std::vector<Finding> findings;
  if (!known && is_file && number.empty()) {
    findings.push_back({named, "", "not signed",
                        "no signed report: of others the store keeps nothing; `tactbench report RUN` makes them anew",
                        ExitCode::kInconclusive});
  } else if (!known) {
    findings.push_back({is_file ? named : "", "", "unknown",
                        fmt::format("report {} is none that was signed in {}", number, session.db),
                        ExitCode::kCriterionFailed});
  } else if (is_file) {
    findings.push_back(look_at(*known, named));
  } else {
    for (const char* ending : kReportEndings)
      if (const std::string path = report_path(store, fmt::format("run-{}.{}", number, ending));
          std::filesystem::is_regular_file(path))
        findings.push_back(look_at(*known, path));
    if (findings.empty())
      findings.push_back(
          {"", "", "no file", "its file does not lie beside the store: name it", ExitCode::kInconclusive});
  }
  for (Finding& one : findings)
    if (!one.file.empty() && (!root.empty() || std::filesystem::exists(one.file + ".p7s")))
      one.signature = check_signature_of(one.file, root);
  tell(number, known, findings, known ? check_evidence(store, known->report) : ReportEvidence(), session);
}

}  // namespace tactbench::bench
