#include "analysis/report/page/page.h"

#include <algorithm>
#include <stdexcept>

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

namespace {

constexpr char kRules[] = R"(
html { color: #1a2026; background: #fff; font: 12.5px/1.34 "Liberation Sans", Arial, Helvetica, sans-serif;
  font-variant-numeric: tabular-nums lining-nums; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
body { margin: 0; }
main { max-width: 720px; margin: 0 auto; padding: 12px 16px 32px; }
h1 { font-size: 24px; line-height: 1.1; margin: 0 0 4px; }
h2 { font-size: 15px; line-height: 1.2; margin: 14px 0 6px; break-after: avoid; }
h3 { font-size: 12px; margin: 9px 0 3px; break-after: avoid; }
p { margin: 0 0 5px; }
p.note, figcaption { font-size: 9.8px; line-height: 1.3; color: #3c464e; }
figcaption { margin-top: 4px; }
p.large { font-size: 20px; font-weight: bold; line-height: 1.15; margin-bottom: 6px; }
a { color: #00507d; }
ul { margin: 0 0 6px; padding: 0; list-style: none; }
li { padding-left: 12px; text-indent: -12px; margin-bottom: 2px; }
code { font: 9.5px "Liberation Mono", "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
.b { font-weight: bold; }
.q { color: #5b6670; }
.good { color: #1b6e3c; font-weight: bold; }
.doubt { color: #7d5200; font-weight: bold; }
.bad { color: #a11212; font-weight: bold; }
.word { white-space: nowrap; }
.sign { font-family: "DejaVu Sans", "Segoe UI Symbol", "Apple Symbols", sans-serif; }
.banner { position: sticky; top: 0; z-index: 1; background: #a11212; color: #fff; text-align: center; font-weight: bold;
  letter-spacing: .05em; padding: 5px 16px; }
.columns { display: flex; flex-wrap: wrap; gap: 0 18px; }
.columns > div { min-width: 96px; }
.columns > div > table:first-child caption, .columns > div > h3:first-child { padding-top: 0; margin-top: 0; }
.ruled { border-top: 1px solid #8a949c; padding-top: 7px; margin-top: 7px; gap: 0 16px; break-inside: avoid; }
.ruled .q:first-child { font-size: 10px; }
.framed { display: flex; gap: 18px; border: 1px solid #8a949c; border-left: 8px solid #8a949c; border-radius: 3px;
  padding: 9px 12px; margin: 9px 0; break-inside: avoid; }
.framed > div { flex: 3 1 0; min-width: 0; }
.framed > div + div { flex: 7 1 0; }
.framed table { margin: 0; }
.framed caption, .framed tbody th br { display: none; }
.framed tbody th .q { margin-left: 7px; }
.framed.good { color: inherit; font-weight: inherit; border-color: #1b6e3c; }
.framed.bad { color: inherit; font-weight: inherit; border-color: #a11212; }
.framed.doubt { color: inherit; font-weight: inherit; border-color: #b88000; }
.framed.good .large { color: #1b6e3c; }
.framed.bad .large { color: #a11212; }
.framed.doubt .large { color: #7d5200; }
.framed > div > p:not(.large) { font-weight: normal; }
table { border-collapse: collapse; width: 100%; margin: 4px 0 8px; }
caption { text-align: left; font-weight: bold; padding: 5px 0 3px; break-inside: avoid; break-after: avoid; }
thead { display: table-header-group; break-after: avoid; }
tr { break-inside: avoid; }
th, td { text-align: left; vertical-align: top; font-weight: normal; padding: 3px 5px; border-bottom: 1px solid #dde3e8;
  overflow-wrap: anywhere; }
thead th, thead td { color: #3c464e; font-weight: bold; font-size: .92em; line-height: 1.2; vertical-align: bottom;
  border-bottom: 1.2px solid #1a2026; overflow-wrap: normal; }
thead tr:first-child th[scope=colgroup] { border-bottom: 0; padding-bottom: 0; }
#levels tbody th { font-weight: bold; }
.tab th:first-child, .tab td:first-child, .pairs th { padding-left: 0; }
.pairs th { width: 34%; color: #5b6670; }
.n { text-align: right; white-space: nowrap; }
thead .n { white-space: normal; }
.dense { font-size: 10.6px; }
.dense th, .dense td { vertical-align: baseline; }
.dense th, .dense td { padding-top: 2px; padding-bottom: 2px; }
#levels td, #levels th { padding: 1.7px 4px; }
#levels td:nth-child(7n), #levels td:nth-child(2) { border-right: 1px solid #aab4bc; }
#levels td:nth-child(7), #levels td:nth-child(12) { font-size: .88em; color: #5b6670; }
.total th, .total td { font-weight: bold; border-bottom: 0; }
tr:has(+ .total) > * { border-bottom: 1.2px solid #1a2026; }
.total + .total > * { border-top: 0; }
.keep { break-inside: avoid; }
.newpage { break-after: page; height: 0; }
figure { margin: 3px 0 6px; break-inside: avoid; }
svg { display: block; max-width: 100%; height: auto; }
)";

constexpr char kChartRules[] = R"(svg text { font: 10px "Liberation Sans", Arial, Helvetica, sans-serif; }
svg text:not([fill]) { fill: #1a2026; }
svg .head { font-weight: bold; font-size: 11px; }
svg .mid, svg .cell { text-anchor: middle; }
svg .end { text-anchor: end; }
svg text.quiet { fill: #5b6670; font-size: 9px; }
svg text.good { fill: #1b6e3c; font-size: 9.5px; }
svg .cell { font-size: 8px; }
svg .cell.b { font-weight: bold; font-size: 8.4px; }
svg .label { paint-order: stroke; stroke: #fff; stroke-width: 2.4px; stroke-linejoin: round; }
.grid { stroke: #e0e5e9; fill: none; }
.zero { stroke: #8a949c; fill: none; }
.axis { stroke: #1a2026; stroke-width: .9; fill: none; }
.cross { stroke: #a11212; stroke-width: 1.1; fill: none; }
.beyond { fill: #1a2026; }
)";

constexpr char kPrintRules[] = R"(@media print {
  html { font-size: 11.1px; line-height: 1.28; }
  .dense { font-size: 10.3px; }
  figure { margin-bottom: 3px; }
  main { max-width: none; padding: 0; }
  .banner { display: none; }
  .ruled { font-size: 10.8px; }
  .pairs th, .pairs td { padding-top: 1.6px; padding-bottom: 1.6px; }
  .dense th, .dense td { padding-top: 1.3px; padding-bottom: 1.3px; }
  h2 { margin-top: 10px; }
}
)";

// Margin boxes work in Chromium since 131 and in WeasyPrint.
constexpr char kPaper[] = R"(@page {{ size: {3}; margin: 17mm 15mm 16mm;
  @top-center {{ content: "{0}"; font: bold 9.5px "Liberation Sans", Arial, sans-serif; letter-spacing: .05em; color: #a11212; }}
  @bottom-left {{ content: "{2} {1} · {4}"; font: 9px "Liberation Sans", Arial, sans-serif; color: #444; }}
  @bottom-right {{ content: "page " counter(page) " of " counter(pages); font: 9px "Liberation Sans", Arial, sans-serif;
    color: #444; }} }}
)";

}  // namespace

html::Markup style_sheet(const StyleOptions& options) {
  if (options.number.find_first_not_of("0123456789abcdef-") != std::string::npos) {
    throw std::invalid_argument("a report number has digits, a-f and hyphens only");
  }
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == ' '; };
  if (!std::ranges::all_of(options.document, plain))
    throw std::invalid_argument("a document's name has letters and spaces only");
  if (!std::ranges::all_of(options.state,
                           [&](char c) { return plain(c) || (c >= '0' && c <= '9') || c == ',' || c == '-'; }))
    throw std::invalid_argument("a report's state has letters, digits, blanks, commas and hyphens only");
  html::Markup out = plain_style_sheet();
  out += html::markup(kPaper,
                      html::Text(options.simulated ? "SIMULATED DEVICES - NOT A MEASUREMENT OF A REAL SENSOR" : ""),
                      html::Text(options.number), html::Text(options.document),
                      html::Text(options.paper == PaperSize::kA4 ? "A4" : "letter"), html::Text(options.state));
  return out;
}

html::Markup plain_style_sheet() {
  html::Markup out = html::Markup::literal(kRules);
  out += chart_rules();
  out += html::Markup::literal(kPrintRules);
  return out;
}

html::Markup chart_rules() { return html::Markup::literal(kChartRules); }

}  // namespace tactbench::analysis
