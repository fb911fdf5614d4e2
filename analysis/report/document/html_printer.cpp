#include <algorithm>

#include "analysis/report/document/printers.h"

namespace tactbench::analysis::doc {

using html::Attribute;
using html::markup;
using html::Markup;
using html::Text;

namespace {

const char* class_of(Look look) {
  switch (look) {
    case Look::kStrong:
      return "b";
    case Look::kQuiet:
      return "q";
    case Look::kGood:
      return "good";
    case Look::kDoubt:
      return "doubt";
    case Look::kBad:
      return "bad";
    case Look::kCode:
    case Look::kPlain:
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
    if (words.look == Look::kCode)
      out = markup("<code>{}</code>", out);
    else if (words.look != Look::kPlain)
      out = markup("<span class=\"{}\">{}</span>", Attribute(class_of(words.look)), out);
    return words.to.empty() ? out : markup("<a href=\"#{}\">{}</a>", Attribute(words.to), out);
  }
  Markup operator()(Verdict verdict) const {
    return markup("<span class=\"{} word\"><span class=\"sign\">{}</span> {}</span>",
                  Attribute(class_of(look_of(verdict))), Text(sign_of(verdict)), Text(to_string(verdict)));
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
    out += phrase(paragraph.words);
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
  Markup operator()(const Beside& beside) const {
    Markup out = markup("<div class=\"beside{}\">\n", Attribute(beside.ruled ? " ruled" : ""));
    for (std::size_t i = 0; i < beside.parts.size(); ++i)
      out += markup("<div style=\"flex:{} 1 0\">\n{}</div>\n", i < beside.shares.size() ? beside.shares[i] : 1,
                    document(beside.parts[i]));
    out += markup("</div>\n");
    return out;
  }
  Markup operator()(const Framed& framed) const {
    Markup out = markup("<div class=\"framed {}\">\n", Attribute(class_of(framed.look)));
    for (const Document& part : framed.parts) out += markup("<div>\n{}</div>\n", document(part));
    out += markup("</div>\n");
    return out;
  }
  Markup operator()(const NewPage&) const { return markup("<div class=\"newpage\"></div>\n"); }

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

}  // namespace tactbench::analysis::doc
