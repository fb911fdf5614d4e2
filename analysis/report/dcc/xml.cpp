#include "analysis/report/dcc/xml.h"

#include <array>
#include <charconv>
#include <cmath>

#include "analysis/report/document/document.h"

namespace tactbench::analysis::dcc {

std::string release_of(const std::string& version) {
  return "v" + version.substr(0, version.find_first_not_of("0123456789."));
}

Text stated_text(const std::string& untrusted) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t from = untrusted.find_first_not_of(kBlanks);
  return Text(from == std::string::npos
                  ? doc::stated("").text
                  : doc::stated(untrusted.substr(from, untrusted.find_last_not_of(kBlanks) + 1 - from)).text);
}

Markup english(const std::string& words) {
  return markup("<dcc:content lang=\"{}\">{}</dcc:content>", Text(kLanguage), stated_text(words));
}
Markup name_of(const std::string& words) { return markup("<dcc:name>{}</dcc:name>", english(words)); }
Markup described(const std::string& words) { return markup("<dcc:description>{}</dcc:description>", english(words)); }
Markup declared(const std::string& words) { return markup("<dcc:declaration>{}</dcc:declaration>", english(words)); }
Markup typed_name(const std::string& untrusted) {
  return markup("<dcc:name><dcc:content>{}</dcc:content></dcc:name>", stated_text(untrusted));
}

Markup software(const std::string& version) {
  return markup("<dcc:software>{}<dcc:release>{}</dcc:release><dcc:type>application</dcc:type>{}</dcc:software>",
                typed_name("tactbench"), stated_text(release_of(version)), described(version));
}

Markup serial_number(const std::string& serial) {
  return markup(
      "<dcc:identifications><dcc:identification><dcc:issuer>manufacturer</dcc:issuer><dcc:value>{}</dcc:value>{}"
      "</dcc:identification></dcc:identifications>",
      stated_text(serial), name_of("serial number"));
}

void append_number(Markup& to, double value, int digits) {
  if (!std::isfinite(value)) {
    to.value += "NaN";
    return;
  }
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value + 0.0, std::chars_format::general, digits);
  to.value.append(text.data(), end.ptr);
}

Markup real(double value, int digits, bool kilopascal) {
  Markup number;
  append_number(number, value, digits);
  return markup("<si:value>{}</si:value><si:unit>{}</si:unit>", number, Text(kilopascal ? "\\kilo\\pascal" : "\\one"));
}

}  // namespace tactbench::analysis::dcc
