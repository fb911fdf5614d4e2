#include "analysis/report/shell.h"

#include <cctype>

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr const char* kPolicy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
constexpr const char* kBanner = "SIMULATED – made on simulated devices, not a measurement of a real sensor";

}  // namespace

std::string page_of(const Shell& shell) {
  Markup page = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{} {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html::Attribute(kPolicy), Text(shell.document), Text(shell.number),
      style_sheet({shell.document, shell.number, shell.simulated, shell.paper}));
  if (shell.simulated)
    page += markup("<aside class=\"banner\" aria-label=\"Origin of the data\">{}</aside>\n", Text(kBanner));
  page += markup("<header>\n<h1>{}</h1>\n<p class=\"number\">No. {}</p>\n", Text(shell.document), Text(shell.number));
  std::size_t size = page.value.size() + shell.json.size() + 65536;
  for (const Markup& part : shell.main) size += part.value.size();
  page.value.reserve(size);
  page += shell.opening;
  if (!shell.contents.empty()) {
    page += markup("<nav aria-label=\"Contents\"><ul>\n");
    for (const auto& [id, title] : shell.contents)
      page += markup("<li><a href=\"#{}\">{}</a></li>\n", html::Attribute(id), Text(title));
    page += markup("</ul></nav>\n");
  }
  page += markup("</header>\n<main>\n");
  for (const Markup& part : shell.main) page += part;
  std::string name = shell.document;
  name.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(name.front())));
  page += markup(
      "</main>\n<footer>\n<p>End of {} {}. The data behind each figure stand in this file as JSON (element "
      "“report-data”); shares of full scale are not in per cent there, and null means not available.</p>\n</footer>\n",
      Text(name), Text(shell.number));
  page += markup("<script type=\"application/json\" id=\"report-data\">");
  page += html::JsonInHtml(shell.json);
  page += markup("</script>\n</body>\n</html>\n");
  return std::move(page.value);
}

}  // namespace tactbench::analysis
