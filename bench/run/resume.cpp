#include "bench/run/resume.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/common/utc.h"

namespace tactbench::bench {

using sequences::BranchKey;
using sequences::BranchSpan;
using sequences::SpanKind;
using sequences::Step;

namespace {

[[noreturn]] void changed(std::int64_t run, const std::string& what) {
  throw Error("TB-RUN-CHANGED", fmt::format("run {} {}", run, what), fmt::format("run {}", run));
}

void check_same_recipes(const db::RunRecord& record, const std::vector<sequences::Recipe>& recipes) {
  const auto same = [](const db::SequenceRecord& sequence, const sequences::Recipe& recipe) {
    return sequence.recipe_sha256 == db::sha256_hex(recipe.text) && sequence.repeats == recipe.repeats;
  };
  if (std::equal(record.sequences.begin(), record.sequences.end(), recipes.begin(), recipes.end(), same)) return;
  changed(record.run, "was begun with other recipes");
}

}  // namespace

ResumePoint reopen(db::RunWriter& store, std::int64_t run, const std::vector<sequences::Recipe>& recipes,
                   const std::vector<Step>& steps) {
  const db::RunRecord record = store.run(run);
  ResumePoint point;
  const std::string& last_seen = std::max(record.seen_utc, record.started_utc);
  const bool died = record.outcome == db::Outcome::kInterrupted || record.ended_utc.empty();
  point.rest_s = seconds_between(died ? last_seen : record.ended_utc, utc_now());
  point.offset = devices::Nanoseconds(store.last_time_ns(run)) + seconds(point.rest_s);
  point.had_ended = fmt::format("{}: {}", to_string(record.outcome), record.reason);

  if (record.outcome == db::Outcome::kCompleted) {
    throw Error("TB-RUN-COMPLETED", fmt::format("run {} is completed: nothing is left to do", run),
                fmt::format("run {}", run));
  }
  check_same_recipes(record, recipes);

  std::map<BranchKey, std::map<int, double>> expected;  // set-points by the frames' ordinals
  const std::vector<BranchSpan> spans = sequences::branches(steps);
  for (const BranchSpan& span : spans) {
    if (span.kind != SpanKind::kBranch) continue;
    for (std::size_t i = span.first; i < span.first + span.count; ++i) {
      if (sequences::has_frame(steps[i])) expected[span.key][steps[i].ordinal] = steps[i].setpoint.value();
    }
  }
  std::map<BranchKey, std::int64_t> whole;
  std::vector<std::int64_t> half;
  std::map<std::int64_t, std::map<int, double>> frames;  // by branch row
  for (const db::FrameRecord& frame : store.frames(run)) frames[frame.branch][frame.ordinal] = frame.setpoint_psi;
  for (const db::BranchRecord& branch : store.branches(run)) {
    if (branch.is_void) continue;
    const BranchKey key{branch.sequence, branch.repeat, branch.ordinal};
    const std::map<int, double>& made = expected[key];
    const std::map<int, double>& there = frames[branch.branch];
    if (made.empty() || !std::includes(made.begin(), made.end(), there.begin(), there.end())) {
      changed(run, fmt::format("holds a branch {} of repeat {} that its recipes do not make", branch.ordinal,
                               branch.repeat));
    }
    if (there == made) {
      whole[key] = branch.branch;
    } else {
      half.push_back(branch.branch);
    }
  }
  store.reopen_run(
      run, {point.offset.count(), "state", "",
            fmt::format("ended -> prepared: resumed after {:.0f} s; it had ended {}", point.rest_s, point.had_ended)});
  for (const std::int64_t branch : half) store.void_branch(branch, "incomplete when the run ended");
  point.voided = static_cast<int>(half.size());
  // The run continues in the repeat of the first branch that is not done.
  const auto next = std::find_if(spans.begin(), spans.end(), [&](const BranchSpan& span) {
    return span.kind == SpanKind::kBranch && !whole.contains(span.key);
  });
  if (next != spans.end()) {
    const double longest = recipes[static_cast<std::size_t>(next->key.sequence)].rest_restart_s;
    for (auto entry = whole.begin(); entry != whole.end() && point.rest_s > longest;) {
      if (entry->first.sequence == next->key.sequence && entry->first.repeat == next->key.repeat) {
        store.void_branch(
            entry->second,
            fmt::format("the sensor rested for {:.0f} s: the repeat is repeated from its start", point.rest_s));
        ++point.voided;
        entry = whole.erase(entry);
      } else {
        ++entry;
      }
    }
  }
  for (const auto& [key, branch] : whole) point.done.insert(key);
  return point;
}

}  // namespace tactbench::bench
