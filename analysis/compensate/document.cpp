#include "analysis/compensate/document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/model_json.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

PatternCurve loop_curve(const std::vector<double>& x, std::vector<double> y, double zero, double gain) {
  for (double& own : y) own = zero + gain * own;
  return {x, y, y.front(), y.back()};
}

// The external loop: the patterns of ELAM, for other models the loop in the document.
std::vector<double> residual_of(const Json& taxel, const Json& document, double zero, double gain) {
  const double scale = taxel.contains("residual_psi") ? json_number(taxel, "residual_psi") : 0.0;
  const Json& model = json_member(taxel, "model");
  const bool elam = model.contains("ascending");
  if (!elam && !taxel.contains("loop")) return {};
  const Json& loop = elam ? model : taxel.at("loop");
  const std::vector<double> x = elam ? json_numbers(model, "x") : json_numbers(document, "loop_inputs");
  if (!elam) zero = 0.0, gain = 1.0;  // is as measured
  return residual_by_level(loop_curve(x, json_numbers(loop, "ascending"), zero, gain),
                           loop_curve(x, json_numbers(loop, "descending"), zero, gain), scale);
}

std::shared_ptr<PassedTime> time_of(const Json& dynamics) {
  auto time = std::make_shared<PassedTime>();
  const auto three = [&](const char* name, std::array<double, kCreepElements>& to) {
    const std::vector<double> list = json_numbers(dynamics, name);
    if (list.size() != to.size()) throw std::invalid_argument(std::string("\"") + name + "\" is not three numbers");
    std::ranges::copy(list, to.begin());
  };
  Dynamics& d = time->dynamics;
  three("creep_s", d.creep_s);
  three("creep_share", d.creep_share);
  d.creep_half = json_number(dynamics, "creep_half");
  d.lag_s = json_number(dynamics, "lag_s");
  d.lag_share = json_number(dynamics, "lag_share");
  return time;
}

DocumentFrames frames_of(const Json& document, int scans) {
  if (document.value("schema", "") != "tactbench.model")
    throw std::invalid_argument("\"schema\" is not tactbench.model");
  const Json& output = json_member(document, "output");
  const double sign = json_member(output, "falling").get<bool>() ? -1.0 : 1.0;
  const double fitted_scans = json_number(output, "scans");
  const double noisier = scans > 0 ? std::sqrt(fitted_scans / scans) : 1.0;
  const Json& sensor = json_member(document, "sensor");
  FrameCompensator::Setup setup;
  std::shared_ptr<PassedTime> time;
  if (document.contains("dynamics")) time = time_of(document.at("dynamics"));
  setup.in_time = time != nullptr && undoes(time->dynamics);
  std::vector<std::shared_ptr<const HysteresisModel>> models;
  bool ranged = false;
  for (const Json& taxel : json_member(document, "taxels")) {
    const double number = json_number(taxel, "taxel");
    if (number < 0.0) continue;  // the mean of the array
    if (number != static_cast<double>(setup.taxels.size())) throw std::invalid_argument("it is not of a whole array");
    setup.taxels.emplace_back();
    if (json_member(taxel, "status") != "fitted") continue;
    const double zero = json_number(taxel, "zero"), gain = json_number(taxel, "gain");
    CompensatorSetup own;
    own.zero = sign * zero;
    own.gain = sign * gain;
    own.noise = noisier * json_number(taxel, "noise");
    own.highest = json_number(taxel, "loop_low") + json_number(json_member(taxel, "figures"), "full_scale");
    if (time != nullptr) {
      own.time = time;
      own.creep_scale = json_number(taxel, "creep_scale");
      own.lag_share = json_number(taxel, "lag_share");
      own.residual = json_numbers(document.at("dynamics"), "residual_shape");
      for (double& left : own.residual) left *= json_number(taxel, "residual_psi");
      own.options.top_share = kTopShare;
    } else {
      own.residual = residual_of(taxel, document, zero, gain);
    }
    models.push_back(model_from_json(json_member(taxel, "model")));
    setup.x_low = ranged ? std::min(setup.x_low, models.back()->x_low()) : models.back()->x_low();
    setup.x_high = ranged ? std::max(setup.x_high, models.back()->x_high()) : models.back()->x_high();
    ranged = true;
    try {
      setup.taxels.back() = make_compensator(*models.back(), own);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("taxel " + std::to_string(setup.taxels.size() - 1) + ": " + error.what());
    }
  }
  if (!ranged) throw std::invalid_argument("none of its taxels is fitted");
  if (static_cast<double>(setup.taxels.size()) != json_number(sensor, "rows") * json_number(sensor, "columns"))
    throw std::invalid_argument("it is not of a whole array");
  DocumentFrames made{std::move(models), FrameCompensator(std::move(setup))};
  made.frames.start(Start::kUnknown);
  return made;
}

}  // namespace

std::vector<double> residual_by_level(const PatternCurve& ascending, const PatternCurve& descending, double scale) {
  constexpr std::size_t kLevels = 20;
  // The flatter the branch, the larger the input error for an output error; limited, because not all errors are output
  // errors.
  constexpr double kMostOfMean = 4.0, kLeastOfMean = 0.5;
  if (!(scale > 0.0) || ascending.x().size() < 2) return {};
  const double low = ascending.x().front(), high = ascending.x().back();
  const double rise = ascending.y().back() - ascending.y().front();
  std::vector<double> residual;
  for (const PatternCurve* const branch : {&ascending, &descending})
    for (std::size_t k = 0; k < kLevels; ++k) {
      const auto at = [&](std::size_t i) { return low + (high - low) * static_cast<double>(i) / kLevels; };
      const double own = kLevels * ((*branch)(at(k + 1)) - (*branch)(at(k)));
      residual.push_back(scale * (own > rise / kMostOfMean ? std::max(rise / own, kLeastOfMean) : kMostOfMean));
    }
  return residual;
}

DocumentFrames frames_from_document(const std::string& text, int scans) {
  try {
    return frames_of(Json::parse(text), scans);
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace tactbench::analysis
