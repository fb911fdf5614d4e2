#include "analysis/report/page/page.h"

#include <cctype>

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr const char* kPolicy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
constexpr const char* kBanner = "SIMULATED – made on simulated devices, not a measurement of a real sensor";

}  // namespace

std::string page_of(const Page& page) {
  Markup text = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{} {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html::Attribute(kPolicy), Text(page.document), Text(page.title.empty() ? page.number : page.title),
      style_sheet({page.document, page.number, page.simulated, page.paper}));
  if (page.simulated)
    text += markup("<aside class=\"banner\" aria-label=\"Origin of the data\">{}</aside>\n", Text(kBanner));
  text += markup("<header>\n<h1>{}</h1>\n<p class=\"number\">No. {}</p>\n", Text(page.document), Text(page.number));
  std::size_t size = text.value.size() + page.json.size() + 65536;
  for (const Markup& part : page.main) size += part.value.size();
  text.value.reserve(size);
  text += page.opening;
  if (!page.contents.empty()) {
    text += markup("<nav aria-label=\"Contents\"><ul>\n");
    for (const auto& [id, title] : page.contents)
      text += markup("<li><a href=\"#{}\">{}</a></li>\n", html::Attribute(id), Text(title));
    text += markup("</ul></nav>\n");
  }
  text += markup("</header>\n<main>\n");
  for (const Markup& part : page.main) text += part;
  std::string name = page.document;
  name.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(name.front())));
  text += markup(
      "</main>\n<footer>\n<p>End of {} {}. The data behind each figure stand in this file as JSON (element "
      "“report-data”); pressures are in psi there, shares of full scale are not in per cent, and null means not "
      "available.</p>\n</footer>\n",
      Text(name), Text(page.number));
  text += markup("<script type=\"application/json\" id=\"report-data\">");
  text += html::JsonInHtml(page.json);
  text += markup("</script>\n</body>\n</html>\n");
  return std::move(text.value);
}

}  // namespace tactbench::analysis
