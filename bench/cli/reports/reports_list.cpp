// report list, report verify: the reports that somebody signed.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/reports/reports_verify.h"
#include "bench/cli/session.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"

namespace tactbench::bench {

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
            analysis::doc::Paragraph{{fmt::format("{}: {}: {}", report.number, what, one_line(text, kLongestText))}});
      };
      for (const std::string& why : void_runs) remark("its evidence fell", why);
      if (!report.reason.empty()) remark("reason", report.reason);
    }
  }
  if (session.json) return print_json("report.list", {{"reports", json}});
  if (json.empty()) return tty::print("no report is signed: tactbench report sign RUN --by NAME signs one\n");
  print_table(std::move(table));
  print_document(out, session.unit());
}

}  // namespace

void add_reports_list(CLI::App& report, Session& session) {
  auto run = std::make_shared<std::int64_t>(0);
  CLI::App* verb = report.add_subcommand("list", "the signed reports: number, date, who signed, which it replaces");
  verb->add_option("run", *run, "of this run alone")->check(CLI::PositiveNumber);
  verb->callback([run, &session] { list(*run, session); });
  auto named = std::make_shared<std::string>();
  CLI::App* verify =
      report.add_subcommand("verify", "is a report signed, its file unchanged, and its evidence still good?");
  verify->add_option("report", *named, "number of the report, or a file")->required();
  auto root = std::make_shared<std::string>();
  verify->add_option("--root", *root, "certificates (PEM) that the signature FILE.p7s has to lead to");
  verify->footer(
      "Exit codes: 0 signed and unchanged; 1 changed, not signed in this store, or its evidence fell (a run that it "
      "rests on is void or was changed); 6 it cannot be told. Of a signature FILE.p7s: 0 good; 1 tampered, appended, "
      "wrong "
      "file, damaged, other root, invalid when signed; 6 missing, expired since, or no --root.");
  verify->callback([named, root, &session] { verify_report(*named, *root, session); });
}

}  // namespace tactbench::bench
