#include "analysis/report/document/document.h"

namespace tactbench::analysis::doc {

StyledText strong(std::string text) { return {std::move(text), TextStyle::kStrong, {}}; }
StyledText quiet(std::string text) { return {std::move(text), TextStyle::kQuiet, {}}; }
StyledText code_text(std::string text) { return {text.empty() ? "none" : std::move(text), TextStyle::kCode, {}}; }
StyledText stated(const std::string& untrusted) {
  return {
      untrusted.find_first_not_of(" \t\r\n") == std::string::npos ? "not stated" : untrusted, TextStyle::kPlain, {}};
}

Quantity number(double value, int digits) { return {.value = value, .digits = digits}; }
Quantity number_with_u(double value, double expanded) { return {.value = value, .expanded = expanded}; }
Quantity two_digits(double expanded) { return {.value = expanded, .expanded = expanded, .with_expanded = false}; }
Quantity percent_of(double share, int digits) { return number(100.0 * share, digits); }

Quantity pressure(double psi, int digits) {
  return {.value = psi, .digits = digits, .pressure = true, .unit = Quantity::Unit::kNamed};
}
Quantity both_units(double psi, int digits) {
  return {.value = psi, .digits = digits, .pressure = true, .unit = Quantity::Unit::kBoth};
}
Quantity bare_pressure(double psi, int digits) { return {.value = psi, .digits = digits, .pressure = true}; }
Quantity pressure_with_u(double psi, double expanded_psi) {
  return {.value = psi, .expanded = expanded_psi, .pressure = true, .unit = Quantity::Unit::kNamed};
}
Quantity bare_pressure_with_u(double psi, double expanded_psi) {
  return {.value = psi, .expanded = expanded_psi, .pressure = true};
}
Quantity pressure_rounded_to_u(double psi, double expanded_psi) {
  return {.value = psi, .expanded = expanded_psi, .pressure = true, .with_expanded = false};
}

Phrase& Phrase::add(const Phrase& more) {
  pieces_.insert(pieces_.end(), more.pieces_.begin(), more.pieces_.end());
  return *this;
}
Phrase& Phrase::add(StyledText words) {
  pieces_.emplace_back(std::move(words));
  return *this;
}
Phrase& Phrase::add(Quantity quantity) {
  pieces_.emplace_back(quantity);
  return *this;
}
Phrase& Phrase::add(Taxel taxel) {
  pieces_.emplace_back(taxel);
  return *this;
}
Phrase& Phrase::add(Verdict verdict) {
  pieces_.emplace_back(verdict);
  return *this;
}
Phrase& Phrase::add(std::string text) { return add(StyledText{std::move(text)}); }
Phrase& Phrase::add(const char* text) { return add(std::string(text)); }

template <class Part>
void Document::add(Part part) {
  blocks.emplace_back(std::move(part));
}
template <>
void Document::add(Document more) {
  for (Block& block : more.blocks) blocks.push_back(std::move(block));
}
template void Document::add(Heading);
template void Document::add(Paragraph);
template void Document::add(List);
template void Document::add(Table);
template void Document::add(Drawing);
template void Document::add(SideBySide);
template void Document::add(VerdictBox);
template void Document::add(PageBreak);

Table pairs(std::string caption, std::vector<std::pair<std::string, Phrase>> rows) {
  Table table{.id = {}, .caption = std::move(caption), .columns = {}, .rows = {}};
  for (auto& [name, value] : rows) table.rows.push_back({{Phrase(std::move(name)), std::move(value)}});
  return table;
}

}  // namespace tactbench::analysis::doc
