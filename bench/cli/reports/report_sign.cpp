#include "bench/cli/reports/report_sign.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/read_whole_file.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"

namespace tactbench::bench {

void check_signature(const analysis::Judgement& judgement, std::int64_t run, const std::string& origin,
                     bool without_verdict, const Session& session) {
  if (!judgement.overall) {
    if (without_verdict) return;
    if (!session.json && ::isatty(STDIN_FILENO) == 1) {
      tty::print(stderr, "the report of run {} has no verdict. Sign it anyway? y/n: ", run);
      std::string answer;
      if (std::getline(std::cin, answer) && (answer == "y" || answer == "yes")) return;
    }
    throw Error(
        "TB-REPORT-NO-VERDICT", "the report has no verdict, and signing it was not confirmed",
        fmt::format("report sign {}", run),
        fmt::format("judge first: tactbench judge {} RUN --limits limits.toml; or sign anyway with --without-verdict",
                    run));
  }
  if (exit_code_of(judgement.overall) == ExitCode::kPass) return;
  std::string word = analysis::verdict_text(judgement.overall);
  if (judgement.not_judged) word += ", not judged: " + display_text(*judgement.not_judged, session.unit());
  tty::print(stderr, "warning: signed with the verdict {}\n", shown_verdict(word, origin));
}

void check_reason(const std::vector<db::ReportRecord>& before, const std::string& number, const std::string& reason,
                  bool signing) {
  const bool own = std::ranges::find(before, number, &db::ReportRecord::number) != before.end();
  if (own && signing) return;  // the store refuses it
  if (!reason.empty() && (own || before.empty()))
    throw Error("TB-REPORT-REASON",
                own ? fmt::format("report {} is already signed; its reason cannot be changed", number)
                    : fmt::format("report {} replaces none: no report of this run is signed", number),
                "report --reason", "leave --reason out");
  if (signing && !before.empty() && reason.empty())
    throw Error("TB-REPORT-REASON",
                fmt::format("report {} would replace the signed report {}, but no reason is stated", number,
                            before.back().number),
                "report sign", "state what changed and why: --reason TEXT");
}

void sign_files(const std::vector<std::string>& files, const SignerFiles& signer, const Session& session) {
  const std::shared_ptr<const SigningKey> key = read_signing_key(signer);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  std::vector<std::string> numbers;
  for (const std::string& file : files)
    if (numbers.emplace_back(signed_report_in(file, store)).empty())
      throw Error("TB-REPORT-KEY", fmt::format("it is not a report that was signed in {}", session.db), file,
                  "sign the report first: tactbench report sign RUN --by NAME");
  auto json = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string signature = sign_file(*key, files[i], numbers[i]);
    json.push_back({{"file", files[i]}, {"number", numbers[i]}, {"signature", signature}});
    if (!session.json) tty::print("report {}: signature {}\n", numbers[i], one_line(signature));
  }
  if (session.json) print_json("report.signatures", {{"files", json}});
}

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
  std::string file, sha256, state, text;  // state: unchanged, changed, not kept, not signed, unknown, no file
  ExitCode code = ExitCode::kPass;
  std::optional<SignatureFinding> signature = {};
};

Finding inspect_report(const KnownReport& known, const std::string& path) {
  Finding out;
  out.file = path;
  out.sha256 = db::sha256_hex(analysis::read_whole_file(path, {.max_bytes = kLargestReport}, "TB-TABLE-OPEN",
                                                        "check its name and permissions"));
  const std::string& notes = known.run.notes;
  if (const std::size_t at = notes.find(report_file_note(known.report.number, out.sha256)); at != std::string::npos) {
    const std::size_t begin = at == 0 ? 0 : notes.rfind('\n', at) + 1;  // npos + 1 is 0
    out.state = "unchanged";
    out.text = fmt::format("unchanged since it was written ({})", one_line(notes.substr(begin, at - begin - 1)));
  } else if (notes.find(report_file_note(known.report.number, "")) == std::string::npos) {
    out.state = "not kept";
    out.text = "not known: the program that signed it kept no hash of its file";
    out.code = ExitCode::kInconclusive;
  } else {
    out.state = "changed";
    out.text = "CHANGED: it is not one of the files written for this report";
    out.code = ExitCode::kCriterionFailed;
  }
  return out;
}

void report_file(const Finding& one) {
  tty::print("file      {}{}{}\n", one_line(one.file), one.file.empty() ? "" : ": ", one.text);
  if (!one.signature) return;
  const SignatureFinding& signature = *one.signature;
  tty::print("signature {}{}{}\n", one_line(signature.text, kMaxTextLength),
             signature.signer.empty() ? "" : "; by " + one_line(signature.signer),
             signature.signed_utc.empty() ? "" : ", " + signature.signed_utc + " by the signer's clock");
}

void report_findings(const std::string& number, const std::optional<KnownReport>& known,
                     const std::vector<Finding>& findings, const ReportEvidence& evidence, Session& session) {
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
    tty::print("report {}: run {}, sensor {}{}; signed by {}, {}\n", number, known->run.run,
               one_line(known->run.sensor_serial), known->run.origin == "simulated" ? " (simulated)" : "",
               one_line(known->report.approved_by), known->report.approved_utc);
  for (const Finding& one : findings) report_file(one);
  if (known && evidence.fallen.empty() && evidence.missing.empty())
    tty::print("evidence  valid: none of the {} on which it is based is void or changed\n",
               analysis::counted(known->report.evidence.size(), "run"));
  for (const std::string& line : evidence.fallen) tty::print("evidence  FALLEN: {}\n", one_line(line, kMaxTextLength));
  for (const std::string& line : evidence.missing)
    tty::print("evidence  not known: {}\n", one_line(line, kMaxTextLength));
  if (known && !known->next.number.empty())
    tty::print("replaced by report {}{}{}\n", known->next.number, known->next.reason.empty() ? "" : ": ",
               one_line(known->next.reason, kMaxTextLength));
}

}  // namespace

std::string report_file_note(const std::string& number, const std::string& sha256) {
  return fmt::format("file of the signed report {}: sha256 {}", number, sha256);
}

void record_signed_file(const std::string& path, const std::string& number, std::int64_t run, const Session& session) {
  if (!std::filesystem::is_regular_file(path)) return;
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::vector<db::ReportRecord> signed_ones = store.reports(run);
  if (std::ranges::find(signed_ones, number, &db::ReportRecord::number) == signed_ones.end()) return;
  const std::string bytes =
      analysis::read_whole_file(path, {.max_bytes = kLargestReport}, "TB-TABLE-OPEN", "check its name and permissions");
  const std::string line = report_file_note(number, db::sha256_hex(bytes));
  if (store.run(run).notes.find(line) != std::string::npos) return;
  try {
    db::RunStore::open(session.db).add_note(run, fmt::format("{} {}", utc_now(), line));
  } catch (const db::StoreError& error) {  // an archive that only can be read
    tty::print(stderr, "warning: {} is not known to `report verify`: {}\n", path, error.what());
  }
}

// report list, report verify: the signed reports.

namespace {

// Where `report` writes a signed one by default; empty where no such file exists.
std::string file_of(const db::RunStore& store, const db::ReportRecord& report) {
  for (const char* ending : kReportEndings) {
    std::string path = report_path(store, fmt::format("run-{}.{}", report.number, ending));
    if (std::filesystem::exists(path)) return path;
  }
  return {};
}

void list(std::int64_t only, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  if (only != 0) (void)store.run(only);  // an unknown one is an error
  auto json = nlohmann::ordered_json::array();
  analysis::doc::Document out;
  analysis::doc::Table table{.columns = {{"report"}, {"sensor"}, {"signed"}, {"by"}, {"replaces"}, {"file"}}};
  for (const db::RunRecord& run : store.runs()) {
    if (only != 0 && run.run != only) continue;
    for (const db::ReportRecord& report : store.reports(run.run)) {
      const std::string file = file_of(store, report);
      const std::vector<std::string> void_runs = void_evidence(store, report);
      json.push_back({JSON_FIELDS(report, number, run),
                      {"sensor", run.sensor_serial},
                      {"origin", run.origin},
                      {"signed", report.approved_utc},
                      {"by", report.approved_by},
                      JSON_FIELDS(report, replaces, reason),
                      {"sha256", report.content_sha256},
                      {"void_evidence", void_runs},
                      {"file", file}});
      table.rows.push_back(
          {{report.number + (run.origin == "simulated" ? " (simulated)" : ""), one_line(run.sensor_serial),
            report.approved_utc.substr(0, 10), one_line(report.approved_by), report.replaces,
            file.empty() ? "elsewhere" : one_line(file)}});
      const auto remark = [&](const char* what, const std::string& text) {
        out.add(
            analysis::doc::Paragraph{{fmt::format("{}: {}: {}", report.number, what, one_line(text, kMaxTextLength))}});
      };
      for (const std::string& why : void_runs) remark("its evidence is no longer valid", why);
      if (!report.reason.empty()) remark("reason", report.reason);
    }
  }
  if (session.json) return print_json("report.list", {{"reports", json}});
  if (json.empty()) return tty::print("no report is signed: tactbench report sign RUN --by NAME signs one\n");
  print_table(std::move(table));
  print_document(out, session.unit());
}

// `named`: a file, or the number of a signed report, whose files next to the store are checked. Sets session.code: pass
// if a file is unchanged and its run is not void, criterion failed if something was changed or the run is void,
// inconclusive if that cannot be determined. Throws Error TB-USAGE if it is neither, StoreError. With `root`
// (certificates in PEM), or if a file has a signature (FILE.p7s), also checks the signature (signed_reports.h); a file
// can then be checked without a store.
void verify_report(const std::string& named, const std::string& root, Session& session) {
  const bool is_file = std::filesystem::is_regular_file(named);
  if (is_file && !root.empty() && !std::filesystem::exists(session.db)) {  // a customer has none
    const Finding alone{named,           "",
                        "unknown",       fmt::format("there is no store {}: only its signature is checked", session.db),
                        ExitCode::kPass, check_signature_of(named, root)};
    return report_findings("", std::nullopt, {alone}, {}, session);
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
                        "not a signed report: the store keeps no others; `tactbench report RUN` makes them again",
                        ExitCode::kInconclusive});
  } else if (!known) {
    findings.push_back({is_file ? named : "", "", "unknown",
                        fmt::format("report {} was not signed in {}", number, session.db), ExitCode::kCriterionFailed});
  } else if (is_file) {
    findings.push_back(inspect_report(*known, named));
  } else {
    for (const char* ending : kReportEndings)
      if (const std::string path = report_path(store, fmt::format("run-{}.{}", number, ending));
          std::filesystem::is_regular_file(path))
        findings.push_back(inspect_report(*known, path));
    if (findings.empty())
      findings.push_back({"", "", "no file", "its file is not next to the store: name it", ExitCode::kInconclusive});
  }
  for (Finding& one : findings)
    if (!one.file.empty() && (!root.empty() || std::filesystem::exists(one.file + ".p7s")))
      one.signature = check_signature_of(one.file, root);
  report_findings(number, known, findings, known ? check_evidence(store, known->report) : ReportEvidence(), session);
}

}  // namespace

void add_reports_list(CLI::App& report, Session& session) {
  auto run = std::make_shared<std::int64_t>(0);
  CLI::App* verb = report.add_subcommand("list", "list the signed reports: number, date, signer, replaced report");
  verb->add_option("run", *run, "only of this run")->check(CLI::PositiveNumber);
  verb->callback([run, &session] { list(*run, session); });
  auto named = std::make_shared<std::string>();
  CLI::App* verify = report.add_subcommand(
      "verify", "check whether a report is signed, its file unchanged and its evidence still valid");
  verify->add_option("report", *named, "number of the report, or a file")->required();
  auto root = std::make_shared<std::string>();
  verify->add_option("--root", *root, "root certificates (PEM) to which the signature FILE.p7s must lead");
  verify->footer(
      "Exit codes: 0 signed and unchanged; 1 changed, not signed in this store, or its evidence is no longer valid (a "
      "run on which it is based is void or was changed); 6 not known. For a signature FILE.p7s: 0 good; 1 tampered, "
      "appended, "
      "wrong "
      "file, damaged, other root, invalid when signed; 6 missing, expired since, or no --root.");
  verify->callback([named, root, &session] { verify_report(*named, *root, session); });
}

}  // namespace tactbench::bench
