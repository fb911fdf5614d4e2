#include "bench/cli/judgement_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/cli/session.h"

namespace tactbench::bench {

using analysis::Judgement;

namespace {

std::string numbers_text(std::vector<std::int64_t> runs) {
  std::ranges::sort(runs);
  return fmt::format("{} {}", runs.size() == 1 ? "run" : "runs", fmt::join(runs, ", "));
}

std::string numbers_text(const std::vector<analysis::JudgedRun>& runs) {
  std::vector<std::int64_t> numbers;
  for (const analysis::JudgedRun& run : runs) numbers.push_back(run.run);
  return numbers_text(std::move(numbers));
}

}  // namespace

std::string conditions_text(const Judgement& judgement) {
  if (!states_conformity(judgement.overall)) return {};
  std::string text;
  for (const analysis::JudgedRun& judged : judgement.runs)
    text += fmt::format("errors of run {} hold for {}\n", judged.run, in_words(judged.trajectory));
  if (const std::string missing = not_assessed_in_words(judgement); !missing.empty())
    text += fmt::format("not assessed: {}\n", missing);
  return text;
}

std::string judgement_text(const Judgement& judgement, const std::string& origin, analysis::PressureUnit unit) {
  std::string text;
  if (judgement.not_judged) {
    text = fmt::format("all requirements together: {}, not judged: {}\n",
                       shown_verdict(analysis::Verdict::kInconclusive, origin), in_words(*judgement.not_judged, unit));
  } else if (analysis::states_conformity(judgement.overall)) {
    text = fmt::format(
        "all requirements together: {}{}{}; judged on {}\n", shown_verdict(*judgement.overall, origin),
        condition_in_words(judgement, unit),
        judgement.decided_by.size() < judgement.runs.size() ? ", decided by " + numbers_text(judgement.decided_by) : "",
        numbers_text(judgement.runs));
  }
  text += conditions_text(judgement);
  if (!judgement.stored_worse.empty()) {
    Judgement stored;
    stored.figures = judgement.stored_worse;
    conclude(stored);
    text +=
        fmt::format("stored verdict on these models, worse: {} on {}, by other limits or of runs not included here\n",
                    shown_verdict(*stored.overall, origin), numbers_text(stored.runs));
  }
  for (const analysis::Remark& remark : judgement.remarks) text += fmt::format("note: {}\n", in_words(remark, unit));
  return text;
}

nlohmann::ordered_json judgement_json(const Judgement& judgement, const std::string& origin) {
  nlohmann::ordered_json json = {{"shown", judgement.overall ? shown_verdict(*judgement.overall, origin) : ""}};
  json.update(analysis::judgement_json(judgement));
  return json;
}

}  // namespace tactbench::bench
