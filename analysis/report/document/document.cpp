#include "analysis/report/document/document.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/text_width.h"

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
    std::string text = fixed_text(known ? rounded_to_uncertainty(value, expanded) : value, digits);
    if (known && quantity.with_expanded && std::isfinite(value))
      text += " ± " + fixed_text(rounded_to_uncertainty(expanded, expanded), digits);
    const bool named = quantity.pressure && quantity.unit != Quantity::Unit::kNone;
    return named ? text + "\u00A0" + shown.symbol() : text;
  };
  if (!std::isfinite(quantity.value)) return "–";
  return quantity.unit == Quantity::Unit::kBoth ? in(unit) + " (" + in(unit.other()) + ")" : in(unit);
}

std::string text_of(const Phrase& phrase, PressureUnit unit) {
  std::string text;
  for (const Piece& piece : phrase.pieces()) text += std::visit(PieceText{unit}, piece);
  return text;
}

std::string sign_of(Verdict verdict) {
  switch (style_of(verdict)) {
    case TextStyle::kGood:
      return "✓";
    case TextStyle::kBad:
      return "✗";
    default:
      return verdict == Verdict::kReportOnly ? "–" : "▲";
  }
}

TextStyle style_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kReportOnly:
      return TextStyle::kPlain;
    case Verdict::kPass:
      return TextStyle::kGood;
    case Verdict::kFail:
      return TextStyle::kBad;
    default:
      return TextStyle::kDoubt;
  }
}

using html::Attribute;
using html::markup;
using html::Markup;
using html::Text;

namespace {

const char* class_of(TextStyle look) {
  switch (look) {
    case TextStyle::kStrong:
      return "b";
    case TextStyle::kQuiet:
      return "q";
    case TextStyle::kGood:
      return "good";
    case TextStyle::kDoubt:
      return "doubt";
    case TextStyle::kBad:
      return "bad";
    case TextStyle::kCode:
    case TextStyle::kPlain:
      break;
  }
  return "";
}

// "\n" breaks the line.
Markup with_breaks(const std::string& text) {
  Markup out;
  std::size_t from = 0;
  for (std::size_t at = text.find('\n'); at != std::string::npos; from = at + 1, at = text.find('\n', from))
    out += markup("{}<br/>", Text(text.substr(from, at - from)));
  out += Text(text.substr(from));
  return out;
}

struct PieceMarkup {
  PressureUnit unit;

  Markup operator()(const StyledText& words) const {
    Markup out = with_breaks(words.text);
    if (words.look == TextStyle::kCode)
      out = markup("<code>{}</code>", out);
    else if (words.look != TextStyle::kPlain)
      out = markup("<span class=\"{}\">{}</span>", Attribute(class_of(words.look)), out);
    return words.to.empty() ? out : markup("<a href=\"#{}\">{}</a>", Attribute(words.to), out);
  }
  Markup operator()(Verdict verdict) const {
    return markup("<span class=\"{} word\"><span class=\"sign\">{}</span> {}</span>",
                  Attribute(class_of(style_of(verdict))), Text(sign_of(verdict)), Text(to_string(verdict)));
  }
  template <class Other>
  Markup operator()(const Other& other) const {
    return markup("{}", Text(text_of(Phrase(other), unit)));
  }
};

// "increasing | median error": the shared part, if any, and the rest.
std::pair<std::string, std::string> split_title(const std::string& title) {
  const std::size_t bar = title.find(" | ");
  if (bar == std::string::npos) return {"", title};
  return {title.substr(0, bar), title.substr(bar + 3)};
}

Markup headings_of(const Table& table) {
  const bool grouped =
      std::ranges::any_of(table.columns, [](const Column& c) { return !split_title(c.title).first.empty(); });
  Markup groups, names;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const Column& column = table.columns[i];
    const auto [group, name] = split_title(column.title);
    const char* const side = column.right ? "n" : "t";
    if (grouped && group.empty()) {
      groups += markup("<th scope=\"col\" rowspan=\"2\" class=\"{}\">{}</th>", Attribute(side), with_breaks(name));
      continue;
    }
    const bool begins = i == 0 || split_title(table.columns[i - 1].title).first != group;
    if (grouped && begins) {
      std::size_t end = i;
      while (end < table.columns.size() && split_title(table.columns[end].title).first == group) ++end;
      groups += markup("<th scope=\"colgroup\" colspan=\"{}\">{}</th>", end - i, with_breaks(group));
    }
    names += name.empty() ? markup("<td></td>")
                          : markup("<th scope=\"col\" class=\"{}{}\">{}</th>", Attribute(side),
                                   Attribute(grouped && begins ? " first" : ""), with_breaks(name));
  }
  return grouped ? markup("<thead><tr>{}</tr><tr>{}</tr></thead>", groups, names)
                 : markup("<thead><tr>{}</tr></thead>", names);
}

class HtmlPrinter {
 public:
  explicit HtmlPrinter(PressureUnit unit) : unit_(unit) {}

  Markup operator()(const Heading& heading) const {
    const Markup id = heading.id.empty() ? Markup() : markup(" id=\"{}\"", Attribute(heading.id));
    return markup("<h{0}{1}>{2}</h{0}>\n", heading.level, id, with_breaks(heading.text));
  }
  Markup operator()(const Paragraph& paragraph) const {
    static constexpr const char* kClasses[] = {"", " class=\"note\"", " class=\"large\""};
    Markup out;
    out.value = fmt::format("<p{}>", kClasses[paragraph.kind]);
    out += phrase(paragraph.text);
    out += markup("</p>\n");
    return out;
  }
  Markup operator()(const List& list) const {
    Markup out = markup("<ul>");
    for (const Phrase& item : list.items) out += markup("<li>{}</li>", phrase(item));
    out += markup("</ul>\n");
    return out;
  }
  Markup operator()(const Table& table) const {
    const Markup id = table.id.empty() ? Markup() : markup(" id=\"{}\"", Attribute(table.id));
    Markup out =
        markup("<table class=\"{}{}{}\"{}><caption>{}</caption>", Attribute(table.columns.empty() ? "pairs" : "tab"),
               Attribute(table.dense ? " dense" : ""), Attribute(table.keep ? " keep" : ""), id, Text(table.caption));
    if (!table.columns.empty()) out += headings_of(table);
    out += markup("<tbody>\n");
    for (const Row& row : table.rows) out += row_of(table, row);
    out += markup("</tbody></table>\n");
    return out;
  }
  Markup operator()(const Drawing& figure) const {
    Markup out = markup("<figure>{}", figure.svg);
    if (!figure.caption.empty()) out += markup("<figcaption>{}</figcaption>", phrase(figure.caption));
    out += markup("</figure>\n");
    return out;
  }
  Markup operator()(const SideBySide& blocks) const {
    Markup out = markup("<div class=\"columns{}\">\n", Attribute(blocks.ruled ? " ruled" : ""));
    for (std::size_t i = 0; i < blocks.parts.size(); ++i)
      out += markup("<div style=\"flex:{} 1 0\">\n{}</div>\n", i < blocks.shares.size() ? blocks.shares[i] : 1,
                    document(blocks.parts[i]));
    out += markup("</div>\n");
    return out;
  }
  Markup operator()(const VerdictBox& framed) const {
    Markup out = markup("<div class=\"framed {}\">\n", Attribute(class_of(framed.look)));
    for (const Document& part : framed.parts) out += markup("<div>\n{}</div>\n", document(part));
    out += markup("</div>\n");
    return out;
  }
  Markup operator()(const PageBreak&) const { return markup("<div class=\"newpage\"></div>\n"); }

  [[nodiscard]] Markup document(const Document& all) const {
    Markup out;
    for (const Block& block : all.blocks) out += std::visit(*this, block);
    return out;
  }
  [[nodiscard]] Markup phrase(const Phrase& all) const {
    Markup out;
    for (const Piece& piece : all.pieces()) out += std::visit(PieceMarkup{unit_}, piece);
    return out;
  }

 private:
  [[nodiscard]] Markup row_of(const Table& table, const Row& row) const {
    const std::size_t width = table.columns.empty() ? 2 : table.columns.size();
    const std::string name = fmt::format("{}{}", row.marked ? " in" : "", row.total ? " total" : "");
    Markup out = name.empty() ? markup("<tr>") : markup("<tr class=\"{}\">", Attribute(name.substr(1)));
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const bool right = i < table.columns.size() && table.columns[i].right;
      const bool spans = i + 1 == row.cells.size() && row.cells.size() < width;
      const Markup inside = phrase(row.cells[i]);
      const Markup span = spans ? markup(" colspan=\"{}\"", width - i) : Markup();
      const Markup side = right && !spans ? markup(" class=\"n\"") : Markup();
      out += i == 0 ? markup("<th scope=\"row\"{}{}>{}</th>", side, span, inside)
                    : markup("<td{}{}>{}</td>", side, span, inside);
    }
    out += markup("</tr>\n");
    return out;
  }

  PressureUnit unit_;
};

}  // namespace

Markup to_html(const Document& document, PressureUnit unit) { return HtmlPrinter(unit).document(document); }
Markup to_html(const Phrase& phrase, PressureUnit unit) { return HtmlPrinter(unit).phrase(phrase); }

namespace {

std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines = {""};
  std::string word;
  const auto end_word = [&] {
    if (word.empty()) return;
    const bool fits = display_width(lines.back()) + display_width(word) + 1 <= width;
    if (!lines.back().empty() && !fits) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    word.clear();
  };
  for (const char c : text) {
    if (c != ' ' && c != '\n') {
      word += c;
      continue;
    }
    end_word();
    if (c == '\n') lines.emplace_back();
  }
  end_word();
  return lines;
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(width > display_width(text) ? width - display_width(text) : 0, ' ');
  return right ? blanks + text : text + blanks;
}

class TextPrinter {
 public:
  TextPrinter(PressureUnit unit, std::size_t width) : unit_(unit), width_(width) {}

  std::string operator()(const Heading& heading) const { return lines_of(heading.text) + "\n"; }
  std::string operator()(const Paragraph& paragraph) const { return lines_of(text_of(paragraph.text, unit_)); }
  std::string operator()(const List& list) const {
    std::string out;
    for (const Phrase& item : list.items) out += lines_of("- " + text_of(item, unit_));
    return out;
  }
  std::string operator()(const Table& table) const {
    return (table.caption.empty() ? "" : table.caption + "\n") + grid(table);
  }
  std::string operator()(const Drawing& figure) const { return lines_of("[" + figure.title + "]"); }
  std::string operator()(const SideBySide& blocks) const { return all_of(blocks.parts); }
  std::string operator()(const VerdictBox& framed) const { return all_of(framed.parts); }
  std::string operator()(const PageBreak&) const { return {}; }

  [[nodiscard]] std::string document(const Document& all) const {
    std::string out;
    for (const Block& block : all.blocks) out += std::visit(*this, block);
    return out;
  }

 private:
  [[nodiscard]] std::string all_of(const std::vector<Document>& parts) const {
    std::string out;
    for (const Document& part : parts) out += document(part);
    return out;
  }
  [[nodiscard]] std::string lines_of(const std::string& text) const {
    std::string out;
    for (const std::string& line : wrapped(text, width_)) out += line + "\n";
    return out;
  }
  [[nodiscard]] std::vector<std::string> cell_lines(const std::string& text, std::size_t width, bool whole) const {
    std::vector<std::string> lines = wrapped(text, whole ? width : text.size());
    for (std::string& line : lines) line = cut_to(line, width);
    return lines;
  }
  // The column to cut by one letter if a table is too wide: one marked `cut`, else the widest without numbers;
  // widths.size() if there is none.
  static std::size_t to_cut(const Table& table, const std::vector<std::size_t>& widths) {
    constexpr std::size_t kLeast = 8, kLeastToRead = 14;
    std::size_t widest = widths.size();
    for (std::size_t i = 0; i < widths.size(); ++i) {
      const Column column = i < table.columns.size() ? table.columns[i] : Column();
      if (column.cut && widths[i] > kLeastToRead) return i;
      if (!column.right && widths[i] > kLeast && (widest == widths.size() || widths[i] > widths[widest])) widest = i;
    }
    return widest;
  }
  // Columns as wide as their longest cell; if they do not fit, they are cut and the last ones left out. Values after
  // names are wrapped.
  [[nodiscard]] std::string grid(const Table& table) const {
    const bool names = table.columns.empty();
    std::vector<std::vector<std::string>> rows;
    if (!names) {
      std::vector<std::string>& head = rows.emplace_back();
      for (const Column& column : table.columns) head.push_back(column.title);
    }
    for (const Row& row : table.rows) {
      std::vector<std::string>& cells = rows.emplace_back();
      for (const Phrase& cell : row.cells) cells.push_back(text_of(cell, unit_));
    }
    std::vector<std::size_t> widths;
    for (const auto& row : rows) {
      widths.resize(std::max(widths.size(), row.size()), 1);
      for (std::size_t i = 0; i < row.size(); ++i)
        for (const std::string& line : wrapped(row[i], row[i].size()))
          widths[i] = std::max(widths[i], display_width(line));
    }
    while (!widths.empty() && std::accumulate(widths.begin(), widths.end(), 2 * (widths.size() - 1)) > width_) {
      const std::size_t cut = to_cut(table, widths);
      if (cut < widths.size())
        --widths[cut];
      else
        widths.pop_back();
    }
    std::string out;
    for (const auto& row : rows) {
      std::vector<std::vector<std::string>> cells;
      std::size_t height = 1;
      for (std::size_t i = 0; i < std::min(row.size(), widths.size()); ++i) {
        cells.push_back(wrapped(row[i], names && i > 0 ? widths[i] : row[i].size()));
        height = std::max(height, cells.back().size());
      }
      const bool head = !names && &row == &rows.front();
      for (std::size_t line = 0; line < height; ++line) {
        std::string text;
        for (std::size_t i = 0; i < cells.size(); ++i) {
          const std::size_t above = head ? height - cells[i].size() : 0;  // a heading is aligned at the bottom
          const bool in = line >= above && line - above < cells[i].size();
          text += padded(in ? cut_to(cells[i][line - above], widths[i]) : "", widths[i],
                         i < table.columns.size() && table.columns[i].right) +
                  "  ";
        }
        text.erase(text.find_last_not_of(' ') + 1);
        out += text + "\n";
      }
    }
    return out;
  }

  PressureUnit unit_;
  std::size_t width_;
};

}  // namespace

std::string to_text(const Document& document, PressureUnit unit, std::size_t width) {
  std::string text = TextPrinter(unit, width).document(document);
  for (std::size_t at = 0; (at = text.find("\u00A0", at)) != std::string::npos;) text.replace(at, 2, " ");
  return text;
}

}  // namespace tactbench::analysis::doc
