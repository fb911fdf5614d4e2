#include "bench/page/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

constexpr int kFramesACall = 200;
constexpr int kLoopPoints = 4000;
constexpr int kLongestGap = 10;
constexpr double kLongestInterval = 86'400.0;  // s between two frames

// Rounded to so many steps per unit. A value that is not a number becomes 0.
double rounded(double value, double steps) { return std::isfinite(value) ? std::round(steps * value) / steps : 0.0; }

template <class Values>
nlohmann::json rounded_all(const Values& values, double steps) {
  nlohmann::json list = nlohmann::json::array();
  for (const double value : values) list.push_back(rounded(value, steps));
  return list;
}

double psi_or_n(const db::StoredFrame& frame) { return frame.wrench ? -frame.wrench->wrench[2] : frame.reference_psi; }

// The whole array's models of that run; none: it has no models that can compensate frames.
std::optional<analysis::SensorModel> models_of(const db::Models& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = store.default_fit(run);
  if (!record) return std::nullopt;
  analysis::SensorModel model = analysis::load_model(fmt::format("{}:{}", run, record->fit), &store);
  if (model.fitted().empty()) return std::nullopt;
  return model;
}

}  // namespace

CompensatedRun::CompensatedRun(analysis::SensorModel model, std::string text)
    : model_(std::make_unique<analysis::SensorModel>(std::move(model))), words_(std::move(text)) {
  stream_.emplace(analysis::frames_of(*model_, 1.0, kLongestGap));
  const std::size_t taxels = stream_->taxels();
  volts_.resize(taxels);
  pressure_.resize(taxels);
  uncertainty_.resize(taxels);
  status_.resize(taxels);
}

std::unique_ptr<CompensatedRun> CompensatedRun::of(const db::RunStore& store, const db::RunRecord& run) {
  const std::vector<db::RunRecord> runs = store.runs();
  for (auto other = runs.rbegin(); other != runs.rend(); ++other) {
    if (other->run >= run.run || other->sensor_serial != run.sensor_serial || other->is_void()) continue;
    if (other->origin != run.origin) continue;
    try {
      std::optional<analysis::SensorModel> model = models_of(store, other->run);
      if (!model) continue;
      const std::string text = fmt::format("{} of run {}", analysis::label_of(*model), other->run);
      return std::unique_ptr<CompensatedRun>(new CompensatedRun(*std::move(model), text));
    } catch (const analysis::AnalysisError&) {  // of one taxel, or of another kind: the next older one
    } catch (const std::invalid_argument&) {
    }
  }
  return nullptr;
}

void CompensatedRun::see(const db::StoredFrame& frame, const std::vector<double>& volts) {
  if (volts.size() != volts_.size()) return;
  const double gap = last_ns_ ? static_cast<double>(frame.time_ns - *last_ns_) * 1e-9 : 0.0;
  last_ns_ = frame.time_ns;
  std::ranges::transform(volts, volts_.begin(), [](double volt) { return static_cast<float>(volt); });
  stream_->frame(volts_, std::clamp(gap, 0.0, kLongestInterval), {pressure_, uncertainty_, status_});
}

RunFrames::RunFrames(const db::RunStore& store, const db::RunRecord& run)
    : store_(store), run_(run), look_(store, run.run) {}

bool RunFrames::advance() {
  if (!basis_) {
    run_ = store_.run(run_.run);  // its devices are stored once they are open
    basis_ = array_basis(store_, run_);
    if (!basis_) return false;
  }
  const bool first = position_ == 0;
  if (first && !models_sought_) {
    compensated_ = CompensatedRun::of(store_, run_);
    models_sought_ = true;
  }
  bool newer = false;
  look_.frames_after(position_, kFramesACall, [&](const db::StoredFrame& frame) {
    if (position_ == 0) basis_ = array_basis(store_, run_);  // the seating check comes before the first frame
    position_ = frame.position;
    newest_ = Seen{frame, view_of_frame(*basis_, frame), {}, {}};
    if (compensated_ && !frame.wrench) {
      compensated_->see(frame, newest_->view.volts);
      newest_->pressure_psi = compensated_->pressure_psi();
      newest_->status = compensated_->status();
    }
    const bool same = peak_ && peak_->frame.wrench.has_value() == frame.wrench.has_value();
    if (!frame.is_void && (!same || psi_or_n(frame) >= psi_or_n(peak_->frame))) peak_ = newest_;
    newer = true;
  });
  if (!newer && !newest_ && !seated_) {
    seated_ = newest_array(store_, run_);
    newer = seated_.has_value();
  }
  return newer;
}

nlohmann::json RunFrames::picture(bool at_peak) const {
  at_peak = at_peak && peak_;
  const std::optional<Seen>& seen = at_peak ? peak_ : newest_;
  if (!basis_ || (!seen && !seated_)) return {};
  const ArrayView& view = seen ? seen->view : *seated_;
  nlohmann::json data = {{"run", run_.run},
                         {"position", seen ? seen->frame.position : 0},
                         {"last", position_},
                         {"peak", at_peak},
                         JSON_FIELDS(view, title, rows, columns, full_scale_v),
                         {"volts", rounded_all(view.volts, 1e5)},
                         {"dead", view.dead},
                         {"dead_known", view.dead_are_known},
                         {"saturated", view.saturated}};
  if (!seen) return data;
  const db::StoredFrame& frame = seen->frame;
  data["void"] = frame.is_void;
  if (frame.wrench)
    data["press"] = {
        {"target_n", frame.wrench->target_n}, {"wrench", frame.wrench->wrench}, {"place_mm", frame.wrench->place_mm}};
  if (!seen->pressure_psi.empty()) {
    data["psi"] = rounded_all(seen->pressure_psi, 100.0);
    data["model"] = compensated_->model_text();
    data["unknown"] =
        std::ranges::count_if(seen->status, [](std::uint16_t one) { return (one & analysis::kTaxelUnknown) != 0; });
  }
  return data;
}

nlohmann::json loop_points(const db::RunStore& store, std::int64_t run, int taxel, std::int64_t after) {
  const db::RunRecord record = store.run(run);
  nlohmann::json x = nlohmann::json::array(), y = x, set = x, t = x;
  nlohmann::json data = {{"run", run}, {"taxel", taxel}, {"last", after}, {"axis", "psi"}};
  const std::optional<ArrayBasis> basis = array_basis(store, record);
  db::RunFrameReader look(store, run);
  if (basis) {
    look.frames_after(std::max(after, look.before_newest(kLoopPoints)), kLoopPoints, [&](const db::StoredFrame& frame) {
      data["last"] = frame.position;
      const char* axis = frame.wrench ? "N" : "psi";
      if (data["axis"] != axis) x = y = set = t = nlohmann::json::array();  // a run may have both
      data["axis"] = axis;
      const std::vector<double> means = db::mean_counts(frame);
      if (frame.is_void || taxel >= static_cast<int>(means.size())) return;
      double counts = 0.0;
      if (taxel >= 0) {
        counts = means[static_cast<std::size_t>(taxel)];
      } else {
        for (const double mean : means) counts += mean / static_cast<double>(means.size());
      }
      x.push_back(rounded(psi_or_n(frame), 1000.0));
      set.push_back(rounded(frame.wrench ? frame.wrench->target_n : frame.setpoint_psi, 1000.0));
      t.push_back(rounded(1e-9 * static_cast<double>(frame.time_ns), 100.0));
      y.push_back(rounded(counts * basis->volts_per_count, 1e5));
    });
  }
  data.update({{"x", x}, {"y", y}, {"set", set}, {"t", t}});
  return data;
}

}  // namespace tactbench::bench
