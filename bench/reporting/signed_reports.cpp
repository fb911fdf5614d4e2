#include "bench/reporting/signed_reports.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>

#include "analysis/report/report_facts.h"
#include "bench/common/error.h"
#include "bench/common/file_text.h"
#include "bench/common/signed_report_number.h"
#include "bench/reporting/evidence.h"

namespace tactbench::bench {

std::string signed_report_in(const std::string& path, const db::RunStore& store) {
  std::error_code unknown;
  // A pipe would be waited for, and so would some files of /proc, which say that they are empty.
  if (!std::filesystem::is_regular_file(path, unknown) || std::filesystem::file_size(path, unknown) == 0) return {};
  const std::string text = file_text(path);
  if (text.empty()) return {};
  const std::string beginning = text.substr(0, 64);
  if (beginning.starts_with('{') || beginning.starts_with("<!DOCTYPE html>")) return signed_report_number_in(text);
  for (const db::ReportRecord& report : store.reports())
    if (text.find(analysis::signed_title_mark(report.number)) != std::string::npos) return report.number;
  return {};
}

std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid) {
  const std::filesystem::path folder = std::filesystem::path(store.path()).parent_path() / "reports";
  const std::string path = (folder / name).string();
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return path;
  const bool other = file_text(path).find(uuid) == std::string::npos;
  return other || !signed_report_in(path, store).empty() ? (folder / numbered).string() : path;
}

bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store) {
  const std::string there = signed_report_in(path, store);
  if (there.empty()) return true;
  if (there == number) return false;
  throw Error("TB-REPORT-SIGNED", fmt::format("the file holds the signed report {}", there), path,
              "signed reports are never overwritten: name another file with -o");
}

namespace {

// The runs of this store on which a report is based, its own first; `missing`: content hashes of runs that the store
// does not have.
std::vector<db::RunRecord> evidence_runs(const db::RunStore& store, const db::ReportRecord& report,
                                         std::vector<std::string>* missing) {
  std::vector<db::RunRecord> runs = {store.run(report.run)};
  for (const auto& [number, content] : report.evidence) {
    if (content == runs.front().content_sha256) continue;
    if (const std::optional<std::int64_t> run = run_of_source(store, {number, content}))
      runs.push_back(store.run(*run));
    else if (missing != nullptr)
      missing->push_back(fmt::format("this store does not have run {}, content {}", number, content.substr(0, 12)));
  }
  return runs;
}

}  // namespace

std::vector<std::string> void_evidence(const db::RunStore& store, const db::ReportRecord& report) {
  std::vector<std::string> words;
  for (const db::RunRecord& run : evidence_runs(store, report, nullptr))
    if (run.is_void()) words.push_back(display_text(analysis::void_of(run)));
  return words;
}

ReportEvidence check_evidence(const db::RunStore& store, const db::ReportRecord& report) {
  ReportEvidence found;
  for (const db::RunRecord& run : evidence_runs(store, report, &found.missing)) {
    if (run.is_void()) found.fallen.push_back(display_text(analysis::void_of(run)));
    for (const std::string& wrong : store.check_seals(run.run))
      found.fallen.push_back(fmt::format("run {}: the store was changed: {}", run.run, wrong));
    const db::ContentCheck data = store.check_content(run.run);
    if (!data.holds())
      found.fallen.push_back(fmt::format("run {}: its data were changed: {}", run.run, data.difference));
  }
  return found;
}

std::vector<db::ReportRecord> reports_based_on(const db::RunStore& store, std::int64_t run) {
  std::vector<db::ReportRecord> resting = store.reports();
  std::set<std::string> replaced;
  for (const db::ReportRecord& report : resting) replaced.insert(report.replaces);
  std::erase_if(resting, [&](const db::ReportRecord& report) {
    const std::vector<db::RunRecord> runs = evidence_runs(store, report, nullptr);
    return replaced.contains(report.number) || std::ranges::find(runs, run, &db::RunRecord::run) == runs.end();
  });
  return resting;
}

}  // namespace tactbench::bench
