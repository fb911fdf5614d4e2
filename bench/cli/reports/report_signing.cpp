#include "bench/cli/reports/report_signing.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

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
  std::string word = analysis::verdict_word(judgement.overall);
  if (judgement.not_judged) word += ", not judged: " + in_words(*judgement.not_judged, session.unit());
  tty::print(stderr, "warning: signed with the verdict {}\n", shown_verdict(word, origin));
}

void check_reason(const std::vector<db::ReportRecord>& before, const std::string& number, const std::string& reason,
                  bool signing) {
  const bool own = std::ranges::find(before, number, &db::ReportRecord::number) != before.end();
  if (own && signing) return;  // the store refuses it
  if (!reason.empty() && (own || before.empty()))
    throw Error("TB-REPORT-REASON",
                own ? fmt::format("report {} is signed already and keeps the reason that it was signed with", number)
                    : fmt::format("report {} replaces none: no report of this run is signed", number),
                "report --reason", "leave --reason out");
  if (signing && !before.empty() && reason.empty())
    throw Error("TB-REPORT-REASON",
                fmt::format("report {} would replace the signed report {}, and no reason is stated", number,
                            before.back().number),
                "report sign", "state what changed and why: --reason TEXT");
}

void sign_files(const std::vector<std::string>& files, const SignerFiles& signer, const Session& session) {
  const std::shared_ptr<const SigningKey> key = read_signing_key(signer);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  std::vector<std::string> numbers;
  for (const std::string& file : files)
    if (numbers.emplace_back(signed_report_in(file, store)).empty())
      throw Error("TB-REPORT-KEY", fmt::format("it is no report that was signed in {}", session.db), file,
                  "sign the report first: tactbench report sign RUN --by NAME");
  auto json = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string signature = sign_file(*key, files[i], numbers[i]);
    json.push_back({{"file", files[i]}, {"number", numbers[i]}, {"signature", signature}});
    if (!session.json) tty::print("report {}: signature {}\n", numbers[i], one_line(signature));
  }
  if (session.json) print_json("report.signatures", {{"files", json}});
}

}  // namespace tactbench::bench
