#include "bench/reporting/signed_reports.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "analysis/report/parts.h"
#include "bench/common/error.h"
#include "bench/common/file_text.h"
#include "bench/common/signed_number.h"

namespace tactbench::bench {

std::string signed_report_in(const std::string& path, const db::RunStore& store) {
  std::error_code unknown;
  // A pipe would be waited for, and so would some files of /proc, which say that they are empty.
  if (!std::filesystem::is_regular_file(path, unknown) || std::filesystem::file_size(path, unknown) == 0) return {};
  const std::string text = file_text(path);
  if (text.empty()) return {};
  const std::string beginning = text.substr(0, 64);
  if (beginning.starts_with('{') || beginning.starts_with("<!DOCTYPE html>")) return signed_number_in(text);
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
              "a signed report is not written over: name another file with -o");
}

}  // namespace tactbench::bench
