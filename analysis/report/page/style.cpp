#include "analysis/report/page/style.h"

#include <algorithm>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

constexpr char kRules[] = R"(
html { color: #1a1a1a; background: #ffffff; font: 14px/1.45 "DejaVu Sans", "Liberation Sans", Arial, sans-serif;
  print-color-adjust: exact; -webkit-print-color-adjust: exact; }
body { margin: 0; }
header, main, footer { max-width: 720px; margin: 0 auto; padding: 0 16px; }
h1 { font-size: 26px; margin: 24px 0 4px; }
h2 { font-size: 18px; margin: 32px 0 8px; padding-top: 6px; border-top: 2px solid #1a1a1a; break-after: avoid; }
h3 { font-size: 14px; margin: 20px 0 6px; break-after: avoid; }
h4 { font-size: 12px; margin: 12px 0 2px; break-after: avoid; }
p { margin: 6px 0; }
a { color: #00507d; }
.banner { position: sticky; top: 0; z-index: 1; background: #aa1111; color: #ffffff; text-align: center;
  font-weight: bold; letter-spacing: .06em; padding: 6px 16px; }
.number { font-size: 16px; font-weight: bold; }
.note { color: #444444; font-size: 12px; }
nav ul { display: flex; flex-wrap: wrap; gap: 2px 18px; list-style: none; padding: 0; font-size: 12px; }
code { font-family: "DejaVu Sans Mono", "Liberation Mono", monospace; font-size: 11px; overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; margin: 8px 0 12px; font-size: 12px; }
caption { text-align: left; font-weight: bold; padding: 6px 0 4px; break-inside: avoid; break-after: avoid; }
thead { display: table-header-group; }
thead, thead tr { break-after: avoid; }
tbody tr:first-child { break-before: avoid; }
tr { break-inside: avoid; }
th, td { text-align: left; vertical-align: top; padding: 3px 8px 3px 0; border-bottom: 1px solid #c8c8c8;
  overflow-wrap: anywhere; }
thead th { border-bottom: 1.5px solid #1a1a1a; vertical-align: bottom; overflow-wrap: normal; }
th { font-weight: 600; }
th[scope=row] { min-width: 7em; }
th[scope=colgroup] { text-align: center; border-left: 1px solid #c8c8c8; }
th[scope=colgroup]:first-child { border-left: 0; }
table.pairs th { width: 32%; font-weight: normal; color: #444444; }
table.verdicts td:nth-last-child(2) { white-space: nowrap; }
table.verdicts td:last-child { min-width: 10em; }
td.state { overflow-wrap: normal; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; overflow-wrap: normal; }
table.levels { font-size: 11px; }
table.levels th[scope=row] { min-width: 0; }
table.levels td:last-child { min-width: 11em; padding-left: 6px; }
table.levels.even td:last-child { min-width: 0; padding-left: 0; }
table.ranks th[scope=row] { min-width: 7em; }
table.levels th, table.levels td { padding: 2px 5px 2px 0; }
table.strip { table-layout: fixed; font-size: 11px; break-inside: avoid; }
table.strip th, table.strip td { padding: 3px 2px; text-align: center; border: 0; overflow-wrap: normal; }
table.strip th[scope=row] { width: 62px; min-width: 0; text-align: left; vertical-align: middle; font-weight: 600; }
.plain { font-weight: normal; }
.pass { color: #1b6e3c; font-weight: bold; }
.fail, .worse { color: #aa1111; font-weight: bold; }
.void { color: #aa1111; font-size: 20px; font-weight: bold; border: 3px solid #aa1111; padding: 8px 12px; }
.doubt { color: #8a5a00; font-weight: bold; }
.sign { font-family: "DejaVu Sans", "Segoe UI Symbol", "Apple Symbols", sans-serif; }
.keep { break-inside: avoid; }
figure { margin: 10px 0 16px; break-inside: avoid; }
figcaption { font-size: 12px; color: #444444; }
.pair { display: flex; flex-wrap: wrap; gap: 0 12px; }
.pair figure { flex: 1 1 300px; min-width: 0; }
.triple { display: flex; flex-wrap: wrap; gap: 0 4px; }
.triple figure { flex: 1 1 200px; min-width: 0; max-width: 232px; }
.beside { display: flex; flex-wrap: wrap; gap: 0 20px; break-inside: avoid; }
.beside > div { flex: 1 1 220px; min-width: 0; }
.beside figure { flex: 0 1 416px; }
.beside figure.narrow { flex: 0 1 auto; }
svg { max-width: 100%; vertical-align: middle; }
svg.chart, svg.map { height: auto; }
svg text { font: 11px "DejaVu Sans", "Liberation Sans", Arial, sans-serif; }
svg text:not(.cell) { fill: #1a1a1a; }
svg text.cell { font-size: 9px; text-anchor: middle; }
.grid { stroke: #dddddd; stroke-width: 1; fill: none; }
.axis { stroke: #1a1a1a; stroke-width: 1; fill: none; }
.cross { stroke: #aa1111; stroke-width: .14; fill: none; }
.scale { font-size: 12px; }
.scale svg { margin: 0 6px; }
footer { break-before: avoid; border-top: 2px solid #1a1a1a; margin-top: 32px; padding-top: 8px; padding-bottom: 24px; font-size: 12px; }
@media print {
  html { font-size: 12px; }
  .banner { position: static; }
  nav { display: none; }
  header, main, footer { max-width: none; padding: 0; }
  .wide { overflow: visible; }
  h2 { margin-top: 22px; }
}
)";

// Margin boxes work in Chromium since 131 and in WeasyPrint.
constexpr char kPaper[] = R"(@page {{ size: {3}; margin: 20mm 14mm 18mm;
  @top-center {{ content: "{0}"; font: bold 10px "DejaVu Sans", sans-serif; color: {1}; }}
  @bottom-left {{ content: "{4} {2}"; font: 9px "DejaVu Sans", sans-serif; color: #444444; }}
  @bottom-right {{ content: "page " counter(page) " of " counter(pages); font: 9px "DejaVu Sans", sans-serif;
    color: #444444; }} }}
)";

}  // namespace

html::Markup style_sheet(const StyleOptions& options) {
  if (options.number.find_first_not_of("0123456789abcdef-") != std::string::npos) {
    throw std::invalid_argument("a report number has digits, a-f and hyphens only");
  }
  if (std::ranges::any_of(options.document,
                          [](char c) { return c != ' ' && (c < 'A' || c > 'z' || (c > 'Z' && c < 'a')); }))
    throw std::invalid_argument("a document's name has letters and spaces only");
  html::Markup out = html::Markup::literal(kRules);
  out += html::markup(kPaper,
                      html::Text(options.simulated ? "SIMULATED DEVICES - NOT A MEASUREMENT OF A REAL SENSOR" : ""),
                      html::Text(options.simulated ? "#aa1111" : "#444444"), html::Text(options.number),
                      html::Text(options.paper == PaperSize::kA4 ? "A4" : "letter"), html::Text(options.document));
  return out;
}

html::Markup plain_style_sheet() { return html::Markup::literal(kRules); }

}  // namespace tactbench::analysis
