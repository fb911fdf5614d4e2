#include "analysis/report/page/page.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr const char* kPolicy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
constexpr const char* kBanner = "SIMULATED DEVICES – NOT A MEASUREMENT OF A REAL SENSOR";

}  // namespace

std::string page_of(const Page& page) {
  Markup text = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{} {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html::Attribute(kPolicy), Text(page.document), Text(page.title.empty() ? page.number : page.title),
      style_sheet({page.document, page.number, page.state, page.simulated, page.paper}));
  if (page.simulated)
    text += markup("<aside class=\"banner\" aria-label=\"Origin of the data\">{}</aside>\n", Text(kBanner));
  text.value.reserve(text.value.size() + page.body.value.size() + page.json.size() + 1024);
  text += markup("<main>\n{}</main>\n<script type=\"application/json\" id=\"report-data\">", page.body);
  text += html::JsonInHtml(page.json);
  text += markup("</script>\n</body>\n</html>\n");
  return std::move(text.value);
}

}  // namespace tactbench::analysis
