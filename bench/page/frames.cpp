#include "bench/page/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

constexpr int kFramesACall = 200;
constexpr int kLoopPoints = 4000;
constexpr int kLongestGap = 10;
constexpr double kLongestInterval = 86'400.0;  // s between two frames

std::uint16_t rounded(double value) {
  return std::isfinite(value) ? static_cast<std::uint16_t>(std::clamp(std::lround(value), 0L, 65535L))
                              : std::uint16_t{0};
}

double psi_or_n(const db::SeenFrame& frame) { return frame.wrench ? -frame.wrench->wrench[2] : frame.reference_psi; }

// The whole array's models of that run; none: it has none that stream.
std::optional<analysis::SensorModel> models_of(const db::RunStore& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = store.standing_fit(run);
  if (!record) return std::nullopt;
  analysis::SensorModel model = analysis::load_model(fmt::format("{}:{}", run, record->fit), &store);
  if (model.fitted().empty()) return std::nullopt;
  return model;
}

}  // namespace

std::string base64(const std::vector<std::uint16_t>& numbers) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  for (const unsigned number : numbers) {
    bytes += static_cast<char>(number & 255U);
    bytes += static_cast<char>(number >> 8U);
  }
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8U) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kLetters[(group >> (18U - 6U * static_cast<unsigned>(k))) & 63U] : '=';
  }
  return text;
}

CompensatedRun::CompensatedRun(analysis::SensorModel model, std::string words)
    : model_(std::make_unique<analysis::SensorModel>(std::move(model))), words_(std::move(words)) {
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
      const std::string words = fmt::format("{} of run {}", analysis::label_of(*model), other->run);
      return std::unique_ptr<CompensatedRun>(new CompensatedRun(*std::move(model), words));
    } catch (const analysis::AnalysisError&) {  // of one taxel, or of another kind: the next older one
    } catch (const std::invalid_argument&) {
    }
  }
  return nullptr;
}

void CompensatedRun::see(const db::SeenFrame& frame, const std::vector<double>& volts) {
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
  look_.frames_after(position_, kFramesACall, [&](const db::SeenFrame& frame) {
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
  std::vector<std::uint16_t> counts, hundredths;
  for (const double volts : view.volts) counts.push_back(rounded(volts / basis_->volts_per_count));
  nlohmann::json told = {{"run", run_.run},
                         {"position", seen ? seen->frame.position : 0},
                         {"last", position_},
                         {"peak", at_peak},
                         {"title", view.title},
                         {"rows", view.rows},
                         {"columns", view.columns},
                         {"volts_per_count", basis_->volts_per_count},
                         {"full_scale_v", view.full_scale_v},
                         {"counts", base64(counts)},
                         {"dead", view.dead},
                         {"dead_known", view.dead_are_known},
                         {"saturated", view.saturated}};
  if (!seen) return told;
  const db::SeenFrame& frame = seen->frame;
  told.update({{"time_s", static_cast<double>(frame.time_ns) * 1e-9},
               {"setpoint_psi", frame.setpoint_psi},
               {"feedback_psi", frame.feedback_psi},
               {"reference_psi", frame.reference_psi},
               {"flags", frame.flags},
               {"void", frame.is_void}});
  if (frame.wrench)
    told["press"] = {
        {"target_n", frame.wrench->target_n}, {"wrench", frame.wrench->wrench}, {"place_mm", frame.wrench->place_mm}};
  if (!seen->pressure_psi.empty()) {
    for (const float psi : seen->pressure_psi) hundredths.push_back(rounded(100.0 * static_cast<double>(psi)));
    told["psi"] = base64(hundredths);
    told["model"] = compensated_->words();
    const auto bits = [&](std::uint16_t bit) {
      return std::ranges::count_if(seen->status, [bit](std::uint16_t one) { return (one & bit) != 0; });
    };
    told["unknown"] = bits(analysis::kTaxelUnknown);
    told["out_of_range"] = bits(analysis::kTaxelOutOfRange);
  }
  return told;
}

nlohmann::json loop_points(const db::RunStore& store, std::int64_t run, int taxel, std::int64_t after) {
  const db::RunRecord record = store.run(run);
  nlohmann::json x = nlohmann::json::array(), y = x, set = x, t = x;
  nlohmann::json told = {{"run", run}, {"taxel", taxel}, {"last", after}, {"axis", "psi"}};
  const std::optional<ArrayBasis> basis = array_basis(store, record);
  db::RunLook look(store, run);
  if (basis) {
    look.frames_after(std::max(after, look.before_newest(kLoopPoints)), kLoopPoints, [&](const db::SeenFrame& frame) {
      told["last"] = frame.position;
      const char* axis = frame.wrench ? "N" : "psi";
      if (told["axis"] != axis) x = y = set = t = nlohmann::json::array();  // a run may have both
      told["axis"] = axis;
      const std::vector<double> means = db::mean_counts(frame);
      if (frame.is_void || taxel >= static_cast<int>(means.size())) return;
      double counts = 0.0;
      if (taxel >= 0) {
        counts = means[static_cast<std::size_t>(taxel)];
      } else {
        for (const double mean : means) counts += mean / static_cast<double>(means.size());
      }
      x.push_back(std::round(1000.0 * psi_or_n(frame)) / 1000.0);
      set.push_back(std::round(1000.0 * (frame.wrench ? frame.wrench->target_n : frame.setpoint_psi)) / 1000.0);
      t.push_back(std::round(1e-7 * static_cast<double>(frame.time_ns)) / 100.0);
      y.push_back(std::round(100000.0 * counts * basis->volts_per_count) / 100000.0);
    });
  }
  told.update({{"x", x}, {"y", y}, {"set", set}, {"t", t}});
  return told;
}

}  // namespace tactbench::bench
