// A printable document as data: headings, paragraphs, lists, tables of typed cells, drawings. Report sections return
// it; the printers below write it. A pressure is a number in psi here and becomes text in the printer, in the requested
// unit.
#pragma once

#include <concepts>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "analysis/judgement/figure.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/page/html.h"

namespace tactbench::analysis::doc {

enum class TextStyle { kPlain, kStrong, kQuiet, kCode, kGood, kDoubt, kBad };

struct StyledText {
  std::string text = {};
  TextStyle look = TextStyle::kPlain;
  std::string to = {};  // id of the heading or table to which it links; empty: no link
};

// A number to print. With a known U (`expanded` > 0) it is rounded to the decimal place of U's two digits, else to
// `digits` decimals (for a pressure: decimals of psi).
struct Quantity {
  enum class Unit { kNone, kNamed, kBoth };  // "20.7", "20.7 kPa", "20.7 kPa (3.0 psi)": for pressures only
  double value = 0.0;
  int digits = 1;
  double expanded = 0.0;
  bool pressure = false;
  Unit unit = Unit::kNone;
  bool with_expanded = true;  // "3.1 ± 0.4"; else "3.1"
};

// A place of the array: "13, 6" of taxel 214 of 16 columns. Below 0: none.
struct Taxel {
  int taxel = -1, columns = 1;
};

using Piece = std::variant<StyledText, Quantity, Taxel, Verdict>;

class Phrase;
template <class T>
concept PhrasePart = std::convertible_to<T, std::string> || std::constructible_from<Piece, T> ||
                     std::same_as<std::remove_cvref_t<T>, Phrase>;

// Text of pieces, one after the other without blanks.
class Phrase {
 public:
  Phrase() = default;
  template <PhrasePart First, PhrasePart... More>
    requires(sizeof...(More) > 0 || !std::same_as<std::remove_cvref_t<First>, Phrase>)
  Phrase(First&& first, More&&... more) {  // NOLINT(google-explicit-constructor): a text is a phrase
    add(std::forward<First>(first));
    (add(std::forward<More>(more)), ...);
  }
  Phrase& add(const Phrase& more);
  Phrase& add(std::string text);
  Phrase& add(const char* text);
  Phrase& add(StyledText text);
  Phrase& add(Quantity quantity);
  Phrase& add(Taxel taxel);
  Phrase& add(Verdict verdict);
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  [[nodiscard]] bool empty() const { return pieces_.empty(); }

 private:
  std::vector<Piece> pieces_;
};

StyledText strong(std::string text);
StyledText quiet(std::string text);
StyledText code_text(std::string text);
// As typed by a person; "not stated" when empty or blank.
StyledText stated(const std::string& untrusted);
Quantity number(double value, int digits);
Quantity number_with_u(double value, double expanded);
Quantity two_digits(double expanded);  // U itself
Quantity percent_of(double share, int digits);
// Pressures. `digits`: decimals of psi.
Quantity pressure(double psi, int digits = 1);                    // "20.7 kPa"
Quantity both_units(double psi, int digits = 1);                  // "20.7 kPa (3.0 psi)"
Quantity bare_pressure(double psi, int digits = 1);               // "20.7", if a heading names the unit
Quantity pressure_with_u(double psi, double expanded_psi);        // "3.1 ± 0.4 kPa"
Quantity bare_pressure_with_u(double psi, double expanded_psi);   // "3.1 ± 0.4"
Quantity pressure_rounded_to_u(double psi, double expanded_psi);  // "3.1", at U's decimal place

struct Heading {
  int level = 2;  // 1 the document, 2 a section, 3 a part
  std::string text, id = {};
};

struct Paragraph {
  enum Kind { kBody, kNote, kLarge };
  Phrase text;
  Kind kind = kBody;
};

struct List {
  std::vector<Phrase> items;  // each begins with its own bullet, if any
};

// The part of a heading before " | " is shared with its neighbours: "increasing | median error".
struct Column {
  std::string title = {};
  bool right = false;  // numbers
  bool cut = false;    // the first column to be cut on a narrow terminal
};
struct Row {
  std::vector<Phrase> cells =
      {};               // the first cell names the row; in a row with fewer cells the last one spans the rest
  bool marked = false;  // shaded
  bool total = false;
};
struct Table {
  std::string id = {}, caption = {};
  std::vector<Column> columns = {};  // empty for pairs
  std::vector<Row> rows = {};
  bool dense = false, keep = false;  // small rows; not cut between two pages
};

struct Drawing {
  html::Markup svg = {};
  std::string title = {};
  Phrase caption;
};

struct Document;
// Documents side by side; `shares` of the width, one per document.
struct SideBySide {
  std::vector<Document> parts;
  std::vector<int> shares = {};
  bool ruled = false;  // a line above and below
};
// The verdict of page 1, framed.
struct VerdictBox {
  TextStyle look = TextStyle::kPlain;
  std::vector<Document> parts;
};
struct PageBreak {};

using Block = std::variant<Heading, Paragraph, List, Table, Drawing, SideBySide, VerdictBox, PageBreak>;

struct Document {
  std::vector<Block> blocks;
  // Blocks of one kind, or all blocks of a document.
  template <class Part>
  void add(Part part);
};

// A table of names and values without headings.
Table pairs(std::string caption, std::vector<std::pair<std::string, Phrase>> rows);

// Printers of a document: HTML, which is also well-formed XML, and plain text for a terminal. The only place where a
// number is converted to text.
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
