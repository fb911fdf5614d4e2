#include <algorithm>
#include <numeric>

#include "analysis/report/document/printers.h"
#include "analysis/text_width.h"

namespace tactbench::analysis::doc {

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
  std::string operator()(const Paragraph& paragraph) const { return lines_of(text_of(paragraph.words, unit_)); }
  std::string operator()(const List& list) const {
    std::string out;
    for (const Phrase& item : list.items) out += lines_of("- " + text_of(item, unit_));
    return out;
  }
  std::string operator()(const Table& table) const {
    return (table.caption.empty() ? "" : table.caption + "\n") + grid(table);
  }
  std::string operator()(const Drawing& figure) const { return lines_of("[" + figure.title + "]"); }
  std::string operator()(const Beside& beside) const { return all_of(beside.parts); }
  std::string operator()(const Framed& framed) const { return all_of(framed.parts); }
  std::string operator()(const NewPage&) const { return {}; }

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
  // The column that gives up a letter where a table is too wide: one that is meant to, else the widest without numbers;
  // none: widths.size().
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
  // Columns as wide as their longest cell, else cut, and the last ones left out; values behind names are wrapped.
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
          const std::size_t above = head ? height - cells[i].size() : 0;  // a heading stands at the bottom
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
