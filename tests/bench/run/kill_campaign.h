// `tactbench run` killed with SIGKILL at random moments, `tactbench resume` after it killed again, until the run
// completes, and so on: against a rig in its own process. What was committed has to stay, and what is measured has to
// be what an unbroken run measures. With power cuts only synced bytes survive a kill; with races some resumes come
// twice.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <random>

#include "bench/guard/trip.h"
#include "tests/bench/run/kill_record.h"
#include "tests/support/served_rig.h"
#include "tests/support/synced_store.h"

namespace tactbench::tests {

struct CampaignKind {
  int kills = 20;
  std::uint32_t seed = 1;
  double rate = 20.0;
  bool power_cuts = false;
  bool races = false;
};

struct CampaignFigures {
  int kills = 0, runs = 0, hasty = 0;  // hasty: resumed at once, while the dead-man was still at work
  std::int64_t frames = 0;             // committed, of all runs
  std::int64_t checked = 0;            // comparisons of a committed frame with what was there before
  std::int64_t lost = 0, changed = 0, doubled = 0, voids = 0;
  std::int64_t sectors_lost = 0;  // written, not synced, gone with the power
  int trips = 0, races = 0;
  double worst_safe_s = 0.0;  // real time
  double deviation_v = 0.0;   // largest, of a broken run from the mean of the unbroken ones
  double noise_v = 0.0;       // standard deviation of one unbroken run about that mean
  double bound_v = 0.0, loop_v = 0.0;
  double no_way_v = 0.0;  // what a branch that begins without its way back would be off by
  std::vector<std::string> faults;
};

class KillCampaign {
 public:
  explicit KillCampaign(const CampaignKind& kind) : kind_(kind), random_(kind.seed), rig_(kind.rate) {
    if (kind.power_cuts) rig_.environment = disk_.emplace(db()).environment();
    // Four branches a repeat with a minor loop inside, so that a path that was not repeated shows.
    write_file(rig_.folder.path("small.toml"),
               "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 12, 4, 12, 0]\nstep = 4\n"
               "repeats = 2\ndwell_s = 1\n[dwell]\ntolerance_s = 5\n[conditioning]\ncycles = 1\npeak = 20\n");
  }

  CampaignFigures carry_out() {
    for (int i = 0; i < kUsed + kUnbroken; ++i) unbroken(i >= kUsed);
    while (figures_.kills < kind_.kills && figures_.faults.size() < 5) broken();
    for (int i = 0; i < kUnbroken; ++i) unbroken(true);
    compare();
    return figures_;
  }

 private:
  static constexpr int kUsed = 2, kUnbroken = 3;  // the film's first loops differ from all later ones
  static constexpr int kFrames = 11, kRepeats = 2, kMostKillsARun = 12;

  [[nodiscard]] std::string db() const { return rig_.folder.path("runs.db"); }
  [[nodiscard]] std::int64_t newest_run() const {
    if (!std::filesystem::exists(db())) return 0;
    const auto runs = db::RunStore::open_read_only(db()).runs();
    return runs.empty() ? 0 : runs.back().run;
  }
  double random(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  void fault(const std::string& what) { figures_.faults.push_back(what + "\n" + rig_.log()); }

  void unbroken(bool counts) {
    const auto start = std::chrono::steady_clock::now();
    const int code = rig_.start_run("small.toml")->wait();
    whole_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (code != 0) return fault(fmt::format("an unbroken run ends with {}", code));
    const std::int64_t run = newest_run();
    FinalSet set = judge_final_set(db::RunStore::open_read_only(db()), run, kFrames, kRepeats);
    figures_.faults.insert(figures_.faults.end(), set.faults.begin(), set.faults.end());
    if (counts) unbroken_.push_back(std::move(set.volts));
  }

  void broken() {
    const std::int64_t before = newest_run();
    known_.clear();
    run_ = 0;
    std::unique_ptr<ChildProcess> program = rig_.start_run("small.toml");
    for (int kills = 0;; ++kills) {
      const bool go_on = kills < kMostKillsARun && figures_.kills < kind_.kills;
      const double at_once = run_ == 0 || random(0, 1) > 0.15 ? 1.0 : 0.1;
      const double after_s = random(0.0, at_once * (run_ == 0 ? 1.0 : 0.7) * whole_s_);
      const auto longest = std::chrono::duration<double>(go_on ? after_s : 60.0);
      const auto code = program->ended_within(std::chrono::duration_cast<std::chrono::milliseconds>(longest));
      if (code || !go_on) {
        if (!code || *code != 0) return fault(fmt::format("run {} ends with {}", run_, code.value_or(-1000)));
        break;
      }
      if (run_ == 0 && newest_run() > before) run_ = newest_run();
      compare_with_known();
      const auto killed = std::chrono::steady_clock::now();
      program->signal(SIGKILL);
      if (const int ended = program->wait(); ended == 0) {
        break;  // it was faster
      } else if (ended != -SIGKILL) {
        return fault(fmt::format("run {} ends with {}", run_, ended));
      }
      ++figures_.kills;
      if (disk_) cut_power(before);
      if (newest_run() > before) run_ = newest_run();  // the row may have come with the kill
      if (run_ != 0 && db::RunStore::open_read_only(db()).run(run_).outcome == db::Outcome::kCompleted) break;
      if (random(0, 1) < 0.5) {
        ++figures_.hasty;
      } else {
        make_sure_safe(killed);
        compare_with_known();
      }
      program = run_ == 0 ? rig_.start_run("small.toml") : resumed();
    }
    run_ = newest_run();
    compare_with_known();
    ++figures_.runs;
    figures_.frames += static_cast<std::int64_t>(known_.size());
    const FinalSet set = judge_final_set(db::RunStore::open_read_only(db()), run_, kFrames, kRepeats);
    figures_.faults.insert(figures_.faults.end(), set.faults.begin(), set.faults.end());
    figures_.doubled += set.doubled;
    figures_.voids += set.voids;
    broken_.push_back(set.volts);
  }

  void cut_power(std::int64_t before) {
    figures_.sectors_lost += disk_->cut(random(0, 1) < 0.5 ? 0.0 : 0.5, random_);
    if (run_ != 0 && newest_run() <= before) fault(fmt::format("run {} is gone with the power", run_));
    compare_with_known();
  }

  // Some come twice at the same time: one goes on, the other is refused.
  std::unique_ptr<ChildProcess> resumed() {
    auto one = rig_.start_resume(run_);
    if (!kind_.races || random(0, 1) > 0.3) return one;
    auto other = rig_.start_resume(run_);
    ++figures_.races;
    for (int looks = 0; looks < 20000; ++looks) {
      for (const bool is_first : {true, false}) {
        const std::optional<int> code = (is_first ? one : other)->ended_within(std::chrono::milliseconds(0));
        if (!code) continue;
        auto& left = is_first ? other : one;
        if (*code > 0 && *code != 70) return std::move(left);
        if (*code == 0 && left->wait() != 0) return std::move(is_first ? one : other);  // the run was almost complete
        fault(fmt::format("of two resumes at once one ends with {}", *code));
        return std::move(left);
      }
      usleep(1000);
    }
    fault("two resumes at once both go on");
    return one;
  }

  // What was seen committed before is still there, in the same order and unchanged.
  void compare_with_known() {
    if (run_ == 0) return;
    std::vector<std::string> now = committed_frames(db(), run_);
    for (std::size_t i = 0; i < known_.size(); ++i) {
      ++figures_.checked;
      if (i >= now.size()) {
        ++figures_.lost;
      } else if (now[i] != known_[i]) {
        ++figures_.changed;
      }
    }
    known_ = std::move(now);
  }

  void make_sure_safe(std::chrono::steady_clock::time_point killed) {
    constexpr double kLongest = 20.0;
    if (rig_.seconds_until_safe(kLongest) >= kLongest) fault("the chamber is not vented after a kill");
    const double safe_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - killed).count();
    figures_.worst_safe_s = std::max(figures_.worst_safe_s, safe_s);
    if (!bench::TripFile(rig_.bench_id).read()) return;
    ++figures_.trips;
    (void)rig_.run({"devices", "reset", "--bench", "bench.toml", "--operator", "campaign"});
  }

  // Each value of an unbroken run scatters about the mean m of the U unbroken runs with a standard deviation s, pooled
  // over all places; so one of a broken run lies within z s sqrt(1 + 1/U) of m.
  void compare() {
    if (unbroken_.size() < 2 || broken_.empty()) return;
    const auto runs = static_cast<double>(unbroken_.size());
    const std::size_t places = unbroken_.front().size();
    double squares = 0.0;
    std::vector<double> mean(places, 0.0);
    for (std::size_t k = 0; k < places; ++k) {
      for (const auto& run : unbroken_) mean[k] += run[k] / runs;
      for (const auto& run : unbroken_) squares += (run[k] - mean[k]) * (run[k] - mean[k]);
    }
    figures_.noise_v = std::sqrt(squares / (static_cast<double>(places) * (runs - 1.0)));
    // 6 sigma: with normal noise one value in 5e8 is beyond, and the longest campaign compares some thousand.
    figures_.bound_v = 6.0 * figures_.noise_v * std::sqrt(1.0 + 1.0 / runs);
    for (const auto& run : broken_) {
      for (std::size_t k = 0; k < places; ++k) {
        figures_.deviation_v = std::max(figures_.deviation_v, std::abs(run[k] - mean[k]));
      }
    }
    figures_.loop_v = std::abs(mean[8] - mean[2]);    // 8 psi falling for good against 8 psi rising at first
    figures_.no_way_v = std::abs(mean[6] - mean[2]);  // 8 psi rising from 4 against rising from 0
  }

  const CampaignKind kind_;
  std::mt19937 random_;
  ServedRig rig_;
  std::optional<SyncedStore> disk_;
  CampaignFigures figures_;
  double whole_s_ = 0.0;  // an unbroken run
  std::int64_t run_ = 0;  // under way; 0: not yet known
  std::vector<std::string> known_;
  std::vector<std::vector<double>> unbroken_, broken_;
};

inline void check_nothing_lost(const CampaignFigures& figures) {
  CHECK(figures.faults.empty());
  CHECK(figures.lost == 0);
  CHECK(figures.changed == 0);
  CHECK(figures.doubled == 0);
  CHECK(figures.trips == 0);
  CHECK(figures.deviation_v < figures.bound_v);
  CHECK(figures.bound_v < 0.75 * figures.no_way_v);  // a path that was not repeated would show
}

inline std::string to_text(const CampaignFigures& f) {
  std::string text = fmt::format(
      "FIGURE kills {}\nFIGURE kills_resumed_at_once {}\nFIGURE runs {}\nFIGURE frames_committed {}\nFIGURE "
      "frames_checked {}\nFIGURE frames_lost {}\nFIGURE frames_changed {}\nFIGURE frames_doubled {}\nFIGURE "
      "branches_void {}\nFIGURE races {}\nFIGURE sectors_lost {}\nFIGURE trips {}\nFIGURE worst_time_to_safe {:.3f} "
      "s\nFIGURE largest_deviation {:.3f} "
      "mV\nFIGURE "
      "bound {:.3f} mV\nFIGURE noise {:.3f} mV\nFIGURE loop_width {:.1f} mV\nFIGURE without_way_back {:.1f} mV\n",
      f.kills, f.hasty, f.runs, f.frames, f.checked, f.lost, f.changed, f.doubled, f.voids, f.races, f.sectors_lost,
      f.trips, f.worst_safe_s, 1e3 * f.deviation_v, 1e3 * f.bound_v, 1e3 * f.noise_v, 1e3 * f.loop_v, 1e3 * f.no_way_v);
  for (const std::string& fault : f.faults) text += "FAULT " + fault + "\n";
  return text;
}

}  // namespace tactbench::tests
