#include "analysis/report/page/qr_code.h"

#include <qrencode.h>

#include <memory>
#include <stdexcept>

namespace tactbench::analysis {

html::Markup qr_code_svg(const std::string& text, const std::string& title, double size) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeData(static_cast<int>(text.size()), reinterpret_cast<const unsigned char*>(text.data()), 0,
                        QR_ECLEVEL_M),
      QRcode_free);
  if (!code) throw std::invalid_argument("a QR code holds 1 to 2331 bytes");
  constexpr int kQuiet = 4;
  html::PathData dark;  // a rectangle for each row's run of dark modules
  for (int row = 0; row < code->width; ++row)
    for (int begin = 0, end = 0; begin < code->width; begin = end + 1) {
      const auto is_dark = [&](int column) { return (code->data[row * code->width + column] & 1) != 0; };
      for (end = begin; end < code->width && is_dark(end);) ++end;
      if (end > begin)
        dark.literal("M")
            .number(begin + kQuiet)
            .literal(" ")
            .number(row + kQuiet)
            .literal("h")
            .number(end - begin)
            .literal("v1h")
            .number(begin - end)
            .literal("z");
    }
  return html::markup(
      "<svg role=\"img\" viewBox=\"0 0 {0} {0}\" width=\"{1}\" height=\"{1}\"><title>{2}"
      "</title><path d=\"{3}\" fill=\"#000\"/></svg>",
      code->width + 2 * kQuiet, html::CssNumber(size), html::Text(title), dark);
}

}  // namespace tactbench::analysis
