#include <cmath>

#include "analysis/report/document/printers.h"

namespace tactbench::analysis::doc {

namespace {

struct PieceText {
  PressureUnit unit;
  std::string operator()(const StyledText& words) const { return words.text; }
  std::string operator()(const Quantity& quantity) const { return text_of(quantity, unit); }
  std::string operator()(Verdict verdict) const { return sign_of(verdict) + " " + to_string(verdict); }
  std::string operator()(const Taxel& taxel) const {
    if (taxel.taxel < 0 || taxel.columns < 1) return "–";
    return fmt::format("{}, {}", taxel.taxel / taxel.columns, taxel.taxel % taxel.columns);
  }
};

}  // namespace

std::string text_of(const Quantity& quantity, PressureUnit unit) {
  const auto in = [&](PressureUnit shown) {
    const double value = quantity.pressure ? shown.of(quantity.value) : quantity.value;
    const double expanded = quantity.pressure ? shown.of(quantity.expanded) : quantity.expanded;
    const bool known = std::isfinite(expanded) && expanded > 0.0;
    const int digits = known               ? gum_decimals(expanded)
                       : quantity.pressure ? shown.digits(quantity.digits)
                                           : quantity.digits;
    std::string text = fixed_text(known ? rounded_beside(value, expanded) : value, digits);
    if (known && quantity.with_expanded && std::isfinite(value))
      text += " ± " + fixed_text(rounded_beside(expanded, expanded), digits);
    const bool named = quantity.pressure && quantity.unit != Quantity::Unit::kNone;
    return named ? text + "\u00A0" + shown.symbol() : text;
  };
  if (!std::isfinite(quantity.value)) return "–";
  return quantity.unit == Quantity::Unit::kBoth ? in(unit) + " (" + in(unit.beside()) + ")" : in(unit);
}

std::string text_of(const Phrase& phrase, PressureUnit unit) {
  std::string text;
  for (const Piece& piece : phrase.pieces()) text += std::visit(PieceText{unit}, piece);
  return text;
}

std::string sign_of(Verdict verdict) {
  switch (look_of(verdict)) {
    case Look::kGood:
      return "✓";
    case Look::kBad:
      return "✗";
    default:
      return verdict == Verdict::kReportOnly ? "–" : "▲";
  }
}

Look look_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kReportOnly:
      return Look::kPlain;
    case Verdict::kPass:
      return Look::kGood;
    case Verdict::kFail:
      return Look::kBad;
    default:
      return Look::kDoubt;
  }
}

}  // namespace tactbench::analysis::doc
