// Printers of a document: HTML, which is also well-formed XML, and plain text for a terminal. The only place where a
// number is converted to text.
#pragma once

#include <string>

#include "analysis/pressure_unit.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/html.h"

namespace tactbench::analysis::doc {

using analysis::fixed_text;

// "−0.12 ± 0.34", "20.7 kPa (3.00 psi)"; U+2212 for a minus, no sign for zero, "–" for a non-finite number.
std::string text_of(const Quantity& quantity, PressureUnit unit);
std::string text_of(const Phrase& phrase, PressureUnit unit);
std::string sign_of(Verdict verdict);  // "✓", "▲", "✗"
TextStyle style_of(Verdict verdict);

html::Markup to_html(const Document& document, PressureUnit unit);
html::Markup to_html(const Phrase& phrase, PressureUnit unit);
// `width`: columns of the terminal.
std::string to_text(const Document& document, PressureUnit unit, std::size_t width);

}  // namespace tactbench::analysis::doc
