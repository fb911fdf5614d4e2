#include "bench/run/time_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "analysis/statistics/numbers/moments.h"
#include "bench/run/run_record.h"
#include "bench/run/watch/watches.h"

namespace tactbench::bench {

using sequences::Override;
using sequences::Recipe;
using sequences::Step;

namespace {

constexpr int kRunsLookedAt = 200, kRunsLearnedFrom = 10, kSamples = 32;

double at(const std::vector<std::pair<double, double>>& line, double x) {
  const auto above = std::lower_bound(line.begin(), line.end(), x, [](const auto& p, double v) { return p.first < v; });
  if (above == line.end()) return line.back().second;
  if (above == line.begin()) return above->second;
  const auto below = above - 1;
  return below->second + (above->second - below->second) * (x - below->first) / (above->first - below->first);
}

// Few values: a prediction interval by Student's t, with a floor, since runs of one day vary less than runs in general.
// Ten or more: their quantiles.
TimeBand band_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double middle = analysis::quantile_between(values, 0.5);
  double down = middle - analysis::quantile_between(values, 0.1), up = analysis::quantile_between(values, 0.9) - middle;
  if (n < 10) {
    constexpr double kOneRunSpread = 0.05;
    const double count = static_cast<double>(n);
    const double half =
        n == 1 ? analysis::student_quantile(0.9, analysis::kInfiniteDof) * std::sqrt(2.0) * kOneRunSpread * middle
               : analysis::student_quantile(0.9, count - 1.0) *
                     std::sqrt(analysis::sample_variance(values) * (1.0 + 1.0 / count));
    down = up = half;
  }
  constexpr double kLeastSpread = 0.005;
  down = std::min(std::max(down, kLeastSpread * middle), middle);
  return {middle - down, middle, middle + std::max(up, kLeastSpread * middle), static_cast<int>(n)};
}

std::vector<std::pair<std::string, std::string>> recipe_overrides(const std::vector<Override>& overrides) {
  std::vector<std::pair<std::string, std::string>> found;
  for (const Override& item : overrides) {
    if (item.key.starts_with("recipe.")) found.emplace_back(item.key, item.value);
  }
  return found;
}

// The last frame whose sequence is at most `sequence`; frames are stored sequence after sequence.
std::int64_t end_of(const db::RunReader& store, std::int64_t run, int sequence, std::int64_t last) {
  std::int64_t low = 0, high = last;
  while (low < high) {
    const std::int64_t middle = low + (high - low + 1) / 2;
    const std::optional<db::FrameTime> frame = store.frame_time(run, middle);
    if (frame && frame->sequence <= sequence) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

}  // namespace

sequences::TimeModel time_model(const BenchConfig& bench) {
  sequences::TimeModel model;
  // A small step is in band at the second reading: one feeding and one poll after the command.
  model.rise_psi_per_s = model.fall_psi_per_s = bench.limits.rate_psi_per_s;
  model.settle_s = devices::in_seconds(bench.regulator.feed_interval) + bench.settling.poll_s;
  model.prompt_s = 0.0;
  if (!bench.stage) return model;
  constexpr double kUsualSpeed = 4.0;  // mm/s, for which the model's ways of the stage are
  for (std::size_t i = 0; i < devices::kAxes; ++i) {
    const double slower = std::max(1.0, kUsualSpeed / bench.stage->axis(i).maximum_speed.value());
    model.home_s = std::max(model.home_s, slower * sequences::TimeModel().home_s);
    model.move_s = std::max(model.move_s, slower * sequences::TimeModel().move_s);
  }
  return model;
}

std::size_t steps_done(const std::vector<Step>& steps, std::int64_t frames) {
  for (const sequences::BranchSpan& span : sequences::branches(steps)) {
    if (span.kind != sequences::SpanKind::kBranch) continue;
    for (std::size_t i = span.first; i < span.first + span.count; ++i) frames -= has_frame(steps[i]) ? 1 : 0;
    if (frames < 0) return span.first;
  }
  return steps.size();
}

TimeEstimate::TimeEstimate(const std::vector<Recipe>& recipes, const std::vector<Step>& steps,
                           const sequences::TimeModel& model)
    : frames_done_(steps.size() + 1), left_(sequences::step_times(recipes, steps, model)) {
  for (const Recipe& recipe : recipes) {
    Part& part = parts_.emplace_back();
    part.sha256 = db::sha256_hex(recipe.text);
    part.repeats = recipe.repeats;
  }
  std::size_t since_frame = 0;
  int frames = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Part& part = parts_[static_cast<std::size_t>(steps[i].sequence)];
    if (part.steps++ == 0) {
      part.first_step = since_frame = i;
      frames = 0;
    }
    part.prompts += steps[i].kind == sequences::StepKind::kPrompt ? 1 : 0;
    frames_done_[i] = frames;
    if (!has_frame(steps[i])) continue;
    // Steps before a frame count as fractions of it.
    for (std::size_t j = since_frame; j <= i; ++j) {
      frames_done_[j] = frames + static_cast<double>(j - since_frame) / static_cast<double>(i + 1 - since_frame);
    }
    since_frame = i + 1;
    ++frames;
    part.frames_per_repeat += steps[i].repeat == 0 ? 1 : 0;
  }
  for (std::size_t i = steps.size(); i-- > 1;) {
    if (steps[i - 1].sequence != steps[i].sequence) continue;
    left_[i - 1].low_s += left_[i].low_s;
    left_[i - 1].likely_s += left_[i].likely_s;
    left_[i - 1].high_s += left_[i].high_s;
  }
}

void TimeEstimate::learn(const db::RunReader& store, const std::string& bench_id,
                         const std::vector<Override>& overrides, bool remaining_too) {
  const auto ours = recipe_overrides(overrides);
  for (const db::TimedSequence& stored : store.timed_sequences(bench_id, kRunsLookedAt)) {
    const auto same = [&](const Part& part) {
      return part.sha256 == stored.recipe_sha256 && part.repeats == stored.repeats &&
             part.frames_per_repeat == stored.frames_per_repeat && part.past.size() < kRunsLearnedFrom;
    };
    if (std::none_of(parts_.begin(), parts_.end(), same)) continue;
    const auto theirs = stored_overrides(stored.overrides_json);
    if (!theirs || recipe_overrides(*theirs) != ours) continue;
    const std::int64_t last = store.last_position(stored.run);
    const std::int64_t before = stored.sequence == 0 ? 0 : end_of(store, stored.run, stored.sequence - 1, last);
    const std::optional<db::FrameTime> tail = store.frame_time(stored.run, last);
    const std::int64_t end =
        tail && tail->sequence == stored.sequence ? last : end_of(store, stored.run, stored.sequence, last);
    const std::optional<db::FrameTime> first = before == 0 ? std::nullopt : store.frame_time(stored.run, before);
    const std::int64_t began = first ? first->time_ns : 0;
    const std::vector<LostTime> lost = lost_times(store, stored.run, last);
    const auto lost_until = [&](std::int64_t position) {
      std::int64_t sum = 0;
      for (const LostTime& one : lost) sum += one.position > before && one.position <= position ? one.ns : 0;
      return sum;
    };
    Past past;
    past.elapsed.emplace_back(0.0, 0.0);
    const int samples = remaining_too ? kSamples : 1;
    for (int i = 1; i <= samples; ++i) {
      const std::int64_t position = before + (end - before) * i / samples;
      const std::optional<db::FrameTime> frame = store.frame_time(stored.run, position);
      if (!frame || frame->is_void || frame->sequence != stored.sequence) continue;
      const double done = static_cast<double>(frame->repeat) * stored.frames_per_repeat + frame->ordinal + 1;
      if (done <= past.elapsed.back().first) continue;
      past.elapsed.emplace_back(
          done, devices::in_seconds(devices::Nanoseconds(frame->time_ns - began - lost_until(position))));
    }
    if (past.elapsed.size() < 2) continue;
    for (Part& part : parts_) {
      if (same(part)) part.past.push_back(past);
    }
  }
}

TimeBand TimeEstimate::of_part(const Part& part, std::size_t steps_done) const {
  if (steps_done >= part.steps) return {0.0, 0.0, 0.0, static_cast<int>(part.past.size())};
  const sequences::StepTime& model = left_[part.first_step + steps_done];
  if (part.past.empty()) return {model.low_s, model.likely_s, model.high_s, 0};
  const double whole = left_[part.first_step].likely_s;
  std::vector<double> left;
  for (const Past& past : part.past) {
    const double total = past.elapsed.back().second;
    const bool shaped = past.elapsed.size() > 2 || steps_done == 0;
    left.push_back(shaped ? total - at(past.elapsed, frames_done_[part.first_step + steps_done])
                          : total * model.likely_s / std::max(whole, 1e-9));
  }
  return band_of(std::move(left));
}

// Recipes vary independently: their spreads add in squares.
TimeBand TimeEstimate::sum(std::size_t first_part, std::size_t last_part, std::size_t steps_done) const {
  TimeBand all;
  double down = 0.0, up = 0.0;
  for (std::size_t i = first_part; i < last_part; ++i) {
    const TimeBand band = of_part(parts_[i], i == first_part ? steps_done : 0);
    all.p50_s += band.p50_s;
    down += (band.p50_s - band.p10_s) * (band.p50_s - band.p10_s);
    up += (band.p90_s - band.p50_s) * (band.p90_s - band.p50_s);
    all.runs = i == first_part ? band.runs : std::min(all.runs, band.runs);
    all.prompts += i == first_part && steps_done > 0 ? 0 : parts_[i].prompts;
  }
  all.p10_s = all.p50_s - std::sqrt(down);
  all.p90_s = all.p50_s + std::sqrt(up);
  return all;
}

TimeBand TimeEstimate::remaining(std::size_t steps_done) const {
  std::size_t part = 0;
  while (part + 1 < parts_.size() && steps_done >= parts_[part].first_step + parts_[part].steps) ++part;
  return sum(part, parts_.size(), parts_.empty() ? 0 : steps_done - parts_[part].first_step);
}

TimeBand TimeEstimate::total_of(std::size_t recipe) const { return sum(recipe, recipe + 1, 0); }

const char* to_string(Spent spent) {
  constexpr std::array<const char*, kSpentKinds> kWords = {
      "setting up", "conditioning", "moving", "settling", "dwelling", "reading", "redoing", "waiting", "tearing down"};
  return kWords.at(static_cast<std::size_t>(spent));
}

Spent TimeSpent::start(Spent spent) {
  const devices::Nanoseconds now = clock_.now();
  seconds_[static_cast<std::size_t>(current_)] += devices::in_seconds(now - since_);
  since_ = now;
  return stretch_ ? current_ : std::exchange(current_, spent);
}

TimeSpent::Stretch::Stretch(TimeSpent& times, Spent spent) : times_(times) {
  (void)times_.start(spent);
  times_.stretch_ = true;
}

TimeSpent::Stretch::~Stretch() {
  times_.stretch_ = false;
  (void)times_.start(times_.current_);
}

double TimeSpent::seconds(Spent spent) const { return seconds_[static_cast<std::size_t>(spent)]; }

double TimeSpent::total() const { return std::accumulate(seconds_.begin(), seconds_.end(), 0.0); }

std::string TimeSpent::text() const {
  std::vector<std::pair<double, Spent>> parts;
  for (std::size_t i = 0; i < kSpentKinds; ++i) parts.emplace_back(seconds_[i], static_cast<Spent>(i));
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [spent_s, spent] : parts) {
    if (spent_s < 0.001 * total()) continue;
    text += fmt::format("{}{} {:.1f} %", text.empty() ? "" : ", ", to_string(spent), 100.0 * spent_s / total());
  }
  return text;
}

}  // namespace tactbench::bench
