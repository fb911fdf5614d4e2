#include "sequences/step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactbench::sequences {

const char* to_string(StepKind kind) {
  switch (kind) {
    case StepKind::kConditioning:
      return "conditioning";
    case StepKind::kMeasure:
      return "measure";
    case StepKind::kPrompt:
      return "prompt";
    case StepKind::kTare:
      return "tare";
    case StepKind::kHome:
      return "home";
    case StepKind::kMoveXy:
      return "move";
    case StepKind::kApproach:
      return "approach";
    case StepKind::kPress:
      return "press";
    case StepKind::kRetract:
      return "retract";
  }
  return "?";
}

bool has_frame(const Step& step) {
  return (step.kind == StepKind::kMeasure || step.kind == StepKind::kPress) && step.frame;
}

std::string step_line(const Step& step, const char* unit, double per_psi) {
  std::string line = fmt::format("{} sequence {} repeat {} branch {} step {}", to_string(step.kind), step.sequence,
                                 step.repeat, step.branch, step.ordinal);
  const bool of_pressure = step.kind == StepKind::kConditioning || step.kind == StepKind::kMeasure;
  if (of_pressure) {
    const auto in = [&](devices::Psi pressure) {
      return per_psi == 1.0 ? fmt::format("{}", pressure.value()) : fmt::format("{:.6g}", per_psi * pressure.value());
    };
    line +=
        fmt::format(": {} {} ({} to {} {})", in(step.setpoint), unit, in(step.branch_from), in(step.branch_to), unit);
  } else if (step.kind == StepKind::kPress) {
    line += fmt::format(": {} N ({} to {})", step.force_n, step.force_from_n, step.force_to_n);
  }
  if (step.kind == StepKind::kMoveXy || step.kind == StepKind::kApproach || step.kind == StepKind::kPress ||
      step.kind == StepKind::kRetract) {
    line += fmt::format(" at x {} y {} mm", step.x_mm, step.y_mm);
  }
  if (of_pressure || step.kind == StepKind::kPress) line += fmt::format(", dwell {} s", step.dwell_s);
  if (step.ramp_psi_per_s > 0.0) line += fmt::format(", ramp {} {}/s", per_psi * step.ramp_psi_per_s, unit);
  if (!step.settle) line += ", in passing";
  if (step.hold) line += ", held";
  if (!step.frame) line += ", no frame";
  if (step.hold_force) line += ", force held";
  if (!step.text.empty()) line += fmt::format(": \"{}\"", step.text);
  return line;
}

namespace {

SpanKind span_kind_of(const Step& step) {
  if (step.branch < 0 || step.kind == StepKind::kConditioning) return SpanKind::kConditioning;
  if (has_frame(step)) return SpanKind::kBranch;
  return step.kind == StepKind::kPress ? SpanKind::kConditioning : SpanKind::kTravel;
}

// All cycles of one conditioning are one span: the span's reader decides whether the next is needed.
bool belongs(const BranchSpan& span, const Step& step) {
  const SpanKind kind = span_kind_of(step);
  if (kind != span.kind || step.sequence != span.key.sequence) return false;
  return kind != SpanKind::kBranch || (step.repeat == span.key.repeat && step.branch == span.key.branch);
}

}  // namespace

std::vector<BranchSpan> branches(const std::vector<Step>& steps) {
  std::vector<BranchSpan> spans;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    if (spans.empty() || !belongs(spans.back(), step)) {
      spans.push_back({span_kind_of(step), {step.sequence, step.repeat, step.branch}, i, 0});
    }
    ++spans.back().count;
  }
  return spans;
}

Extremes extremes(const std::vector<Step>& steps) {
  Extremes found;
  for (const Step& step : steps) {
    if (step.kind == StepKind::kConditioning || step.kind == StepKind::kMeasure) {
      found.lowest = found.pressurizes ? std::min(found.lowest, step.setpoint) : step.setpoint;
      found.highest = found.pressurizes ? std::max(found.highest, step.setpoint) : step.setpoint;
      found.pressurizes = true;
      found.fastest_ramp_psi_per_s = std::max(found.fastest_ramp_psi_per_s, step.ramp_psi_per_s);
    }
    if (step.kind == StepKind::kApproach || step.kind == StepKind::kPress) {
      found.presses = true;
      found.largest_force_n = std::max(found.largest_force_n, step.force_n);
    }
    if (step.kind == StepKind::kMoveXy) {
      found.lowest_x_mm = found.moves ? std::min(found.lowest_x_mm, step.x_mm) : step.x_mm;
      found.highest_x_mm = found.moves ? std::max(found.highest_x_mm, step.x_mm) : step.x_mm;
      found.lowest_y_mm = found.moves ? std::min(found.lowest_y_mm, step.y_mm) : step.y_mm;
      found.highest_y_mm = found.moves ? std::max(found.highest_y_mm, step.y_mm) : step.y_mm;
      found.moves = true;
    }
  }
  return found;
}

}  // namespace tactbench::sequences
