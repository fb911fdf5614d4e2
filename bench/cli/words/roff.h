// Text in the language of manual pages, man(7).
#pragma once

#include <string>

namespace tactbench::bench {

// Escapes text: hyphens stay, no line looks like a request, other characters than ASCII by their number.
std::string roff(const std::string& text);
// The same, one sentence a line, as manual pages are written.
std::string roff_paragraph(const std::string& text);

}  // namespace tactbench::bench
