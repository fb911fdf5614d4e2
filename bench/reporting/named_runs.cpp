#include "bench/reporting/named_runs.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/judgement/judgement.h"
#include "bench/common/error.h"
#include "bench/common/for_people.h"

namespace tactbench::bench {

std::vector<db::RunRecord> named_runs(analysis::Runs& runs, const std::vector<std::int64_t>& numbers,
                                      const RunsNamed& named, bool void_too) {
  std::vector<db::RunRecord> records;
  for (const std::int64_t run : numbers) {
    if (std::ranges::find(records, run, &db::RunRecord::run) != records.end())
      throw Error("TB-RUN-TWICE", fmt::format("run {} is named twice", run), named.at,
                  "name each run once: counted twice, it would look like a repetition");
    if (run == named.models_of)
      throw Error("TB-RUN-OWN",
                  fmt::format("the models were made from run {}: it is not independent data for them", run), named.at);
    records.push_back(runs.record(run));
    const db::RunRecord& record = records.back();
    if (!record.is_void()) continue;
    const std::string why = in_words(analysis::void_of(record));
    if (!void_too || !named.void_can_be_taken)
      throw Error("TB-RUN-VOID", why, named.at,
                  named.void_can_be_taken ? "name another run, or add --void-too: the results are then marked"
                                          : "name another run: a void run cannot be accepted");
    tty::print(stderr, "warning: {}; used because of --void-too\n", why);
  }
  return records;
}

}  // namespace tactbench::bench
