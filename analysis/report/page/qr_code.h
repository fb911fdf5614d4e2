// A QR code (ISO/IEC 18004) as SVG.
#pragma once

#include <string>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

// Byte mode, error correction level M, with the quiet zone of four modules; `size` px wide. The same text gives the
// same bytes. Throws std::invalid_argument if the text is empty or longer than 2331 bytes.
html::Markup qr_code_svg(const std::string& text, const std::string& title, double size);

}  // namespace tactbench::analysis
