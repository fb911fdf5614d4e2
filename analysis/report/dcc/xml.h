// Elements that several parts of a DCC have.
#pragma once

#include <string>

#include "analysis/report/page/html.h"

namespace tactbench::analysis::dcc {

using html::Markup;
using html::markup;
using html::Text;

inline constexpr const char* kLanguage = "en";  // language of the program's texts; typed texts have none
// "v0.1.0" of "0.1.0, commit 0123": a letter and numbers.
std::string release_of(const std::string& version);

// Text in the form that the schema requires: not empty, no blanks at its ends; "not stated" if it is empty.
Text stated_text(const std::string& untrusted);
Markup english(const std::string& words);                // dcc:content
Markup name_of(const std::string& words);                // dcc:name in English
Markup described(const std::string& words);              // dcc:description in English
Markup declared(const std::string& words);               // dcc:declaration in English
Markup typed_name(const std::string& untrusted);         // dcc:name of a person, firm, instrument
Markup software(const std::string& version);             // dcc:software, this program
Markup serial_number(const std::string& serial);         // dcc:identifications
Markup real(double value, int digits, bool kilopascal);  // si:value, si:unit; `digits` significant ones
void append_number(Markup& to, double value, int digits);

}  // namespace tactbench::analysis::dcc
