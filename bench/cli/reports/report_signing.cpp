#include "bench/cli/reports/report_signing.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <string>

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

}  // namespace tactbench::bench
