#include <algorithm>

#include "analysis/report/document/printers.h"

namespace tactbench::analysis::doc {

namespace {

// Letters, not bytes: continuation bytes of UTF-8 do not count.
std::size_t letters_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines = {""};
  std::string word;
  const auto end_word = [&] {
    if (word.empty()) return;
    const bool fits = letters_of(lines.back()) + letters_of(word) + 1 <= width;
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
  const std::string blanks(width > letters_of(text) ? width - letters_of(text) : 0, ' ');
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
  std::string operator()(const Figure& figure) const { return lines_of("[" + figure.title + "]"); }
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
  // Columns as wide as their longest cell; what does not fit is taken from the widest one, whose cells are wrapped.
  [[nodiscard]] std::string grid(const Table& table) const {
    std::vector<std::vector<std::string>> rows;
    if (!table.columns.empty()) {
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
      for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], letters_of(row[i]));
    }
    std::size_t sum = 2 * widths.size();
    for (const std::size_t one : widths) sum += one;
    while (sum > width_) {
      std::size_t& widest = *std::ranges::max_element(widths);
      if (widest <= 8) break;
      --widest;
      --sum;
    }
    std::string out;
    for (const auto& row : rows) {
      std::vector<std::vector<std::string>> cells;
      std::size_t height = 1;
      for (std::size_t i = 0; i < row.size(); ++i) {
        cells.push_back(wrapped(row[i], widths[i]));
        height = std::max(height, cells.back().size());
      }
      for (std::size_t line = 0; line < height; ++line) {
        std::string text;
        for (std::size_t i = 0; i < cells.size(); ++i) {
          const bool right = i < table.columns.size() && table.columns[i].right;
          text += padded(line < cells[i].size() ? cells[i][line] : "", widths[i], right) + "  ";
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
  return TextPrinter(unit, width).document(document);
}

}  // namespace tactbench::analysis::doc
