#include "bench/common/work_progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "analysis/workers.h"
#include "bench/common/terminal.h"

namespace tactbench::bench {
namespace {

constexpr std::chrono::seconds kSilence{2};
WorkProgress* present = nullptr;  // of the main thread alone
constexpr std::chrono::milliseconds kEvery{200};

double sum_of_shares(const std::vector<WorkStage>& stages, std::size_t from, std::size_t to) {
  double sum = 0.0;
  for (std::size_t i = from; i < to; ++i) sum += stages[i].share;
  return sum;
}

bool on_terminal() {
  const char* term = std::getenv("TERM");
  const bool dumb = term == nullptr || std::string(term) == "dumb";
  return isatty(STDERR_FILENO) != 0 && isatty(STDOUT_FILENO) != 0 && std::getenv("CI") == nullptr && !dumb;
}

}  // namespace

std::string work_line(const std::string& label, const std::vector<WorkStage>& stages, std::size_t at, double in_stage,
                      double elapsed_s) {
  constexpr double kLeast = 0.02;  // before this the time left would only be a guess
  const double whole = sum_of_shares(stages, 0, stages.size());
  const double part =
      whole > 0.0 ? (sum_of_shares(stages, 0, at) + std::clamp(in_stage, 0.0, 1.0) * stages[at].share) / whole : 0.0;
  std::string line = fmt::format("{}: {}", label, stages[at].name);
  if (stages.size() > 1) line += fmt::format(" ({} of {})", at + 1, stages.size());
  line += fmt::format("  {:3.0f} %", std::floor(100.0 * part));
  if (part < kLeast) return line;
  const double left = std::ceil(elapsed_s * (1.0 - part) / part), minutes = std::floor(left / 60.0);
  return line + fmt::format("  {:.0f}:{:02.0f} left", minutes, left - 60.0 * minutes);
}

double estimated_fraction(const std::vector<WorkStage>& stages, std::size_t at, double before_s, double in_stage_s) {
  constexpr double kMost = 0.95;
  const double before = sum_of_shares(stages, 0, at);
  if (!(before > 0.0 && before_s > 0.0 && stages[at].share > 0.0)) return 0.0;
  return std::min(kMost, in_stage_s / (before_s * stages[at].share / before));
}

void begin_stage(const std::string& name) {
  if (present != nullptr) present->begin(name);
}

void pause_progress() {
  if (present != nullptr) present->end();
}

WorkProgress::WorkProgress(std::string label, bool silent, std::vector<WorkStage> stages)
    : label_(std::move(label)), stages_(std::move(stages)), before_(std::exchange(present, this)) {
  if (!silent && !stages_.empty() && on_terminal()) watcher_ = std::jthread([this] { watch(); });
}

WorkProgress::~WorkProgress() {
  try {
    end();
  } catch (...) {
    // On a lost terminal there is no line to erase.
  }
  present = before_;
}

void WorkProgress::end() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (!watcher_.joinable()) return;
  watcher_.join();
  tty::erase_status_line();
}

void WorkProgress::begin(const std::string& name) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = at_; i < stages_.size(); ++i) {
    if (stages_[i].name != name) continue;
    if (i != at_) {
      begun_ = Clock::now();
      part_ = 0.0;
    }
    at_ = i;
    return;
  }
}

void WorkProgress::watch() {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, start_ + kSilence, [this] { return ended_; });
  while (!ended_) {
    show();
    changed_.wait_for(lock, kEvery, [this] { return ended_; });
  }
}

void WorkProgress::show() {
  const auto now = Clock::now();
  const auto seconds = [](Clock::duration time) { return std::chrono::duration<double>(time).count(); };
  const analysis::WorkNow work = analysis::work_now();
  const double part = stages_[at_].counted
                          ? (work.count == 0 ? 0.0 : static_cast<double>(work.done) / static_cast<double>(work.count))
                          : estimated_fraction(stages_, at_, seconds(begun_ - start_), seconds(now - begun_));
  part_ = std::max(part_, part);  // between two pieces of counted work nothing counts
  tty::update_status_line(work_line(label_, stages_, at_, part_, seconds(now - start_)));
  std::fflush(stderr);
}

}  // namespace tactbench::bench
