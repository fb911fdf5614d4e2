#include "analysis/export/fixed_stream.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace tactbench::analysis {
namespace {

void demand(bool holds) {
  if (!holds) throw std::invalid_argument("fixed frames: the number of values is not that of the taxels");
}

}  // namespace

FixedFrames::FixedFrames(std::shared_ptr<const FixedModel> model)
    : model_(std::move(model)), dynamic_(model_->dynamic_model()), elam_(model_->elam_model()) {
  if (model_->dynamic) {
    dynamic_taxels_.resize(model_->taxels);
    (void)tb_dynamic_init(&dynamic_, &frames_, dynamic_taxels_.data());
  } else {
    elam_taxels_.resize(model_->taxels);
    (void)tb_elam_init(&elam_, &frames_, elam_taxels_.data());
  }
}

void FixedFrames::frame(std::span<const std::uint16_t> counts, std::span<std::uint16_t> pressures,
                        std::span<std::uint16_t> status) {
  demand(counts.size() == model_->taxels && pressures.size() == model_->taxels && status.size() == model_->taxels);
  if (model_->dynamic)
    tb_dynamic_frame(&dynamic_, &frames_, dynamic_taxels_.data(), counts.data(), pressures.data(), status.data());
  else
    tb_elam_frame(&elam_, &frames_, elam_taxels_.data(), counts.data(), pressures.data(), status.data());
}

void FixedFrames::lost_frame(std::span<std::uint16_t> pressures, std::span<std::uint16_t> status) {
  demand(pressures.size() == model_->taxels && status.size() == model_->taxels);
  if (model_->dynamic)
    tb_dynamic_lost_frame(&dynamic_, &frames_, dynamic_taxels_.data(), pressures.data(), status.data());
  else
    tb_elam_lost_frame(&elam_, &frames_, elam_taxels_.data(), pressures.data(), status.data());
}

std::size_t FixedFrames::tare(std::span<const std::uint16_t> counts) {
  demand(counts.size() == model_->taxels);
  return model_->dynamic ? tb_dynamic_tare(&dynamic_, &frames_, dynamic_taxels_.data(), counts.data())
                         : tb_elam_tare(&elam_, &frames_, elam_taxels_.data(), counts.data());
}

FixedTaxel::FixedTaxel(std::shared_ptr<const FixedModel> model, std::size_t place)
    : model_(std::move(model)),
      place_(static_cast<std::uint32_t>(place)),
      dynamic_(model_->dynamic_model()),
      elam_(model_->elam_model()) {
  demand(place < model_->taxels);
  if (model_->dynamic) {
    const tb_dynamic_words& words = dynamic_.words[place];
    dynamic_taxel_.at.zero = tb_signed(words.front.zero[0], words.front.zero[1]);
    tb_dynamic_start(&dynamic_, &words, &dynamic_taxel_, 0);
  } else {
    const tb_elam_words& words = elam_.words[place];
    elam_taxel_.at.zero = tb_signed(words.front.zero[0], words.front.zero[1]);
    tb_elam_start(&elam_, &words, &elam_taxel_, 0);
  }
}

int FixedTaxel::renews() { return frame_++ % dynamic_.every == place_ % dynamic_.every ? 1 : 0; }

FixedReading FixedTaxel::step(std::uint16_t count) {
  gap_ = 0;
  if (model_->dynamic) {
    const std::uint16_t status = tb_dynamic_step(&dynamic_, place_, &dynamic_taxel_, count, renews());
    return {dynamic_taxel_.at.pressure, status};
  }
  const std::uint16_t status = tb_elam_step(&elam_, place_, &elam_taxel_, count);
  return {elam_taxel_.at.pressure, status};
}

FixedReading FixedTaxel::lost() {
  const int forgets = ++gap_ > TB_LONGEST_GAP ? 1 : 0;
  if (model_->dynamic) {
    const std::uint16_t status = tb_dynamic_lose(&dynamic_, place_, &dynamic_taxel_, forgets, renews());
    return {dynamic_taxel_.at.pressure, status};
  }
  const std::uint16_t status = tb_elam_lose(&elam_, place_, &elam_taxel_, forgets);
  return {elam_taxel_.at.pressure, status};
}

bool FixedTaxel::tare(std::uint16_t count) {
  frame_ = gap_ = 0;
  if (model_->dynamic) return tb_dynamic_tare_taxel(&dynamic_, place_, &dynamic_taxel_, count) != 0;
  return tb_elam_tare_taxel(&elam_, place_, &elam_taxel_, count) != 0;
}

std::uint16_t count_of(const FixedModel& model, double output) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(output / model.options.per_count, 0.0, 65535.0)));
}

}  // namespace tactbench::analysis
