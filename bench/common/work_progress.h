// Progress line of verbs that compute for long: shown after two seconds and only on a terminal, as one line that is
// overwritten and erased at the end. Nothing in pipes, with --json, -q, CI or TERM=dumb. The progress within a stage
// comes from analysis/workers.h or, where nothing is counted, from the stage's expected share of the time.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace tactbench::bench {

struct WorkStage {
  std::string name;
  double share = 1.0;   // of the whole time, relative to the other stages; need not be exact
  bool counted = true;  // most of its time is spent in one piece of counted work
};

// "fit: gpi (2 of 4)   37 %   0:12 left". `in_stage`: how much of stage `at` is done, 0 to 1.
std::string work_line(const std::string& label, const std::vector<WorkStage>& stages, std::size_t at, double in_stage,
                      double elapsed_s);
// Estimate of in_stage for a stage without counted work: from its share and the pace so far; below 1.
double estimated_fraction(const std::vector<WorkStage>& stages, std::size_t at, double before_s, double in_stage_s);

// Acts on the current WorkProgress, if there is one: for code that does not know the verb it works for. Main thread
// only.
void begin_stage(const std::string& name);
void pause_progress();  // permanently, before a question is asked

class WorkProgress {
 public:
  // `silent`: the verb has -q or --json.
  WorkProgress(std::string label, bool silent, std::vector<WorkStage> stages);
  ~WorkProgress();
  WorkProgress(const WorkProgress&) = delete;
  WorkProgress& operator=(const WorkProgress&) = delete;
  // The first stage of this name from the present one on has begun; a name that is not among them changes nothing.
  void begin(const std::string& name);
  void end();  // erases the line before the object is destroyed
  [[nodiscard]] bool shows() const { return watcher_.joinable(); }

 private:
  using Clock = std::chrono::steady_clock;
  void watch();
  void show();

  std::string label_;
  std::vector<WorkStage> stages_;
  WorkProgress* before_;                                     // the object that this one replaces while it exists
  Clock::time_point start_ = Clock::now(), begun_ = start_;  // begun_: start of the stage
  std::size_t at_ = 0;
  double part_ = 0.0;  // displayed progress of the stage
  bool ended_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::jthread watcher_;
};

}  // namespace tactbench::bench
