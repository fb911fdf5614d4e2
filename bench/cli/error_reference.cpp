// `reference-errors`: docs/reference-errors.md, the table of errors as a page.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <string>

#include "bench/cli/session.h"
#include "bench/common/error_table.h"

namespace tactbench::bench {

namespace {

std::string sentence(std::string_view clause) {
  std::string text(clause);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

}  // namespace

void add_error_reference(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("reference-errors", "docs/reference-errors.md, for the documents")->group("");
  verb->callback([] {
    tty::print("{}",
               "# Errors\n\nPrinted by `tactbench reference-errors`. An error says what happened in this case, where, "
               "what to try (the remedy below,\nor a more exact one) and in what state it left the rig; `--json` adds "
               "identifier, exit code and cause. Instead of its own code\na program ends with 7 where the safe state "
               "was not verified, and with 128 and the signal's number where a signal ended it\n([all exit "
               "codes](rules.md#exit-codes)). 0: a warning, with which nothing ends.\n\n"
               "| id | exit code | cause | remedy |\n|---|---|---|---|\n");
    for (const ErrorRow& row : kErrorTable) {
      tty::print("| `{}` | {} | {} | {} |\n", row.id, static_cast<int>(row.exit_code), sentence(row.cause),
                 sentence(row.remedy));
    }
  });
}

}  // namespace tactbench::bench
