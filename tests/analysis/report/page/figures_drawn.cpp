// Figures of the report, coordinate by coordinate: what another implementation of their layout, in Python, draws.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "analysis/report/page/figure.h"

using namespace tactbench::analysis;

namespace {

const double kHole = std::nan("");

}  // namespace

TEST_CASE("drawn: two lines with a legend, their axis moved onto round numbers, a hole in one") {
  const LineChart chart{"t",
                        "x / psi",
                        "y",
                        {{"one", {0.03, 20, 41, 59.98}, {-1.25, 0.5, 2, 1}, 0, false, false},
                         {"two", {10, 30, 30, 50}, {0, 1, kHole, -0.7}, 7, false, false}}};
  CHECK(
      line_chart(chart).value ==
      R"~(<svg role="img" class="chart" viewBox="0 0 680 300" width="680" height="300"><title>t</title>)~"
      R"~(<path class="grid" d="M40.8 246V8"/><text x="40.8" y="260" text-anchor="middle">0</text>)~"
      R"~(<path class="grid" d="M145 246V8"/><text x="145" y="260" text-anchor="middle">10</text>)~"
      R"~(<path class="grid" d="M249.2 246V8"/><text x="249.2" y="260" text-anchor="middle">20</text>)~"
      R"~(<path class="grid" d="M353.4 246V8"/><text x="353.4" y="260" text-anchor="middle">30</text>)~"
      R"~(<path class="grid" d="M457.6 246V8"/><text x="457.6" y="260" text-anchor="middle">40</text>)~"
      R"~(<path class="grid" d="M561.8 246V8"/><text x="561.8" y="260" text-anchor="middle">50</text>)~"
      R"~(<path class="grid" d="M666 246V8"/><text x="666" y="260" text-anchor="middle">60</text>)~"
      R"~(<path class="grid" d="M40.8 222H666"/><text x="34.8" y="226" text-anchor="end">−1</text>)~"
      R"~(<path class="grid" d="M40.8 152.9H666"/><text x="34.8" y="156.9" text-anchor="end">0</text>)~"
      R"~(<path class="grid" d="M40.8 83.8H666"/><text x="34.8" y="87.8" text-anchor="end">1</text>)~"
      R"~(<path class="grid" d="M40.8 14.7H666"/><text x="34.8" y="18.7" text-anchor="end">2</text>)~"
      R"~(<path class="axis" d="M40.8 8V246H666"/><text x="353.4" y="276" text-anchor="middle">x / psi</text>)~"
      R"~(<text transform="translate(12 127) rotate(-90)" text-anchor="middle">y</text>)~"
      R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M41.1 239.3l208.1-120.9l218.8-103.7l197.8 69.1"/>)~"
      R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M40.8 289h28"/>)~"
      R"~(<text x="74.8" y="293">one</text>)~"
      R"~(<path fill="none" stroke="#00669f" stroke-width="1.5" stroke-dasharray="2 2" d="M145)~"
      R"~( 152.9l208.4-69.1m208.4 117.5"/>)~"
      R"~(<path fill="none" stroke="#00669f" stroke-width="1.5" stroke-dasharray="2 2" d="M108 289h28"/>)~"
      R"~(<text x="142" y="293">two</text></svg>)~");
}

TEST_CASE("drawn: an area, dots and a line of one point in a small chart from 0, the legend in two rows") {
  const LineChart chart{"t",
                        "x",
                        "y",
                        {{"", {1, 2, 4}, {0, 3, 1}, 3, false, true},
                         {"a rather long name of a series", {1, 3}, {2, 0.5}, 1, true, false},
                         {"another long name", {2.5}, {2}, -1, false, false}},
                        335,
                        200,
                        true};
  CHECK(
      line_chart(chart).value ==
      R"~(<svg role="img" class="chart" viewBox="0 0 335 200" width="335" height="200"><title>t</title>)~"
      R"~(<path class="grid" d="M34.4 131V8"/><text x="34.4" y="145" text-anchor="middle">1.0</text>)~"
      R"~(<path class="grid" d="M82.2 131V8"/><text x="82.2" y="145" text-anchor="middle">1.5</text>)~"
      R"~(<path class="grid" d="M129.9 131V8"/><text x="129.9" y="145" text-anchor="middle">2.0</text>)~"
      R"~(<path class="grid" d="M177.7 131V8"/><text x="177.7" y="145" text-anchor="middle">2.5</text>)~"
      R"~(<path class="grid" d="M225.5 131V8"/><text x="225.5" y="145" text-anchor="middle">3.0</text>)~"
      R"~(<path class="grid" d="M273.2 131V8"/><text x="273.2" y="145" text-anchor="middle">3.5</text>)~"
      R"~(<path class="grid" d="M321 131V8"/><text x="321" y="145" text-anchor="middle">4.0</text>)~"
      R"~(<path class="grid" d="M34.4 131H321"/><text x="28.4" y="135" text-anchor="end">0</text>)~"
      R"~(<path class="grid" d="M34.4 91.2H321"/><text x="28.4" y="95.2" text-anchor="end">1</text>)~"
      R"~(<path class="grid" d="M34.4 51.4H321"/><text x="28.4" y="55.4" text-anchor="end">2</text>)~"
      R"~(<path class="grid" d="M34.4 11.6H321"/><text x="28.4" y="15.6" text-anchor="end">3</text>)~"
      R"~(<path class="axis" d="M34.4 8V131H321"/><text x="177.7" y="161" text-anchor="middle">x</text>)~"
      R"~(<text transform="translate(12 69.5) rotate(-90)" text-anchor="middle">y</text>)~"
      R"~(<path fill="#d5dde3" d="M34.4 131l95.5-119.4l191.1 79.6V131H34.4z"/>)~"
      R"~(<path fill="none" stroke="#00704f" stroke-width="1.5" stroke-dasharray="9 3 2 3" d="M34.4)~"
      R"~( 131l95.5-119.4l191.1 79.6"/>)~"
      R"~(<path fill="none" stroke="#b84300" stroke-width="3" stroke-linecap="round" d="M34.4 51.4h0m191.1 59.7h0"/>)~"
      R"~(<path fill="none" stroke="#b84300" stroke-width="3" stroke-linecap="round" d="M48.4 174h0"/>)~"
      R"~(<text x="68.4" y="178">a rather long name of a series</text>)~"
      R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M177.7 51.4"/>)~"
      R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M34.4 189h28"/>)~"
      R"~(<text x="68.4" y="193">another long name</text></svg>)~");
}

TEST_CASE("drawn: an axis from 0 begins there, however far away the values are") {
  const std::vector<Series> series{{"", {1, 2}, {30, 50}, 0, false, false}};
  const std::string zero = R"~(text-anchor="end">0</text>)~";
  CHECK_THAT(line_chart({"t", "x", "y", series, 300, 240, true}).value, Catch::Contains(zero));
  CHECK_THAT(line_chart({"t", "x", "y", series, 300, 240, false}).value, !Catch::Contains(zero));
}

TEST_CASE("drawn: axes of an empty chart") {
  CHECK(line_chart({"t", "x", "y", {}, 300, 240, false}).value ==
        R"~(<svg role="img" class="chart" viewBox="0 0 300 240" width="300" height="240"><title>t</title>)~"
        R"~(<path class="grid" d="M47.2 201V8"/><text x="47.2" y="215" text-anchor="middle">0.0</text>)~"
        R"~(<path class="grid" d="M95 201V8"/><text x="95" y="215" text-anchor="middle">0.2</text>)~"
        R"~(<path class="grid" d="M142.7 201V8"/><text x="142.7" y="215" text-anchor="middle">0.4</text>)~"
        R"~(<path class="grid" d="M190.5 201V8"/><text x="190.5" y="215" text-anchor="middle">0.6</text>)~"
        R"~(<path class="grid" d="M238.2 201V8"/><text x="238.2" y="215" text-anchor="middle">0.8</text>)~"
        R"~(<path class="grid" d="M286 201V8"/><text x="286" y="215" text-anchor="middle">1.0</text>)~"
        R"~(<path class="grid" d="M47.2 195.5H286"/><text x="41.2" y="199.5" text-anchor="end">0.0</text>)~"
        R"~(<path class="grid" d="M47.2 159.1H286"/><text x="41.2" y="163.1" text-anchor="end">0.2</text>)~"
        R"~(<path class="grid" d="M47.2 122.7H286"/><text x="41.2" y="126.7" text-anchor="end">0.4</text>)~"
        R"~(<path class="grid" d="M47.2 86.3H286"/><text x="41.2" y="90.3" text-anchor="end">0.6</text>)~"
        R"~(<path class="grid" d="M47.2 49.9H286"/><text x="41.2" y="53.9" text-anchor="end">0.8</text>)~"
        R"~(<path class="grid" d="M47.2 13.5H286"/><text x="41.2" y="17.5" text-anchor="end">1.0</text>)~"
        R"~(<path class="axis" d="M47.2 8V201H286"/><text x="166.6" y="231" text-anchor="middle">x</text>)~"
        R"~(<text transform="translate(12 104.5) rotate(-90)" text-anchor="middle">y</text></svg>)~");
}

TEST_CASE("drawn: a histogram of four bins with its limit, and one of a single value whose limit is far away") {
  CHECK(histogram_chart({"h", "v", "n", {1, 1.2, 2, 5, kHole}, 4.0, "limit", 335, 220, 4}).value ==
        R"~(<svg role="img" class="chart" viewBox="0 0 335 220" width="335" height="220"><title>h</title>)~"
        R"~(<path class="grid" d="M47.2 166V8"/><text x="47.2" y="180" text-anchor="middle">1</text>)~"
        R"~(<path class="grid" d="M115.6 166V8"/><text x="115.6" y="180" text-anchor="middle">2</text>)~"
        R"~(<path class="grid" d="M184.1 166V8"/><text x="184.1" y="180" text-anchor="middle">3</text>)~"
        R"~(<path class="grid" d="M252.6 166V8"/><text x="252.6" y="180" text-anchor="middle">4</text>)~"
        R"~(<path class="grid" d="M321 166V8"/><text x="321" y="180" text-anchor="middle">5</text>)~"
        R"~(<path class="grid" d="M47.2 166H321"/><text x="41.2" y="170" text-anchor="end">0.0</text>)~"
        R"~(<path class="grid" d="M47.2 127.7H321"/><text x="41.2" y="131.7" text-anchor="end">0.5</text>)~"
        R"~(<path class="grid" d="M47.2 89.3H321"/><text x="41.2" y="93.3" text-anchor="end">1.0</text>)~"
        R"~(<path class="grid" d="M47.2 51H321"/><text x="41.2" y="55" text-anchor="end">1.5</text>)~"
        R"~(<path class="grid" d="M47.2 12.6H321"/><text x="41.2" y="16.6" text-anchor="end">2.0</text>)~"
        R"~(<path class="axis" d="M47.2 8V166H321"/><text x="184.1" y="196" text-anchor="middle">v</text>)~"
        R"~(<text transform="translate(12 87) rotate(-90)" text-anchor="middle">n</text>)~"
        R"~(<path fill="#d5dde3" d="M47.2 166l0-153.4l68.4 0l0 76.7l68.5 0l0 76.7l68.5 0l0-76.7l68.4 0l0)~"
        R"~( 76.7V166H47.2z"/>)~"
        R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M47.2 166l0-153.4l68.4 0l0 76.7l68.5 0l0)~"
        R"~( 76.7l68.5 0l0-76.7l68.4 0l0 76.7"/>)~"
        R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M47.2 209h28"/>)~"
        R"~(<text x="81.2" y="213">number</text>)~"
        R"~(<path fill="none" stroke="#b84300" stroke-width="1.5" stroke-dasharray="7 3" d="M252.6 166l0-153.4"/>)~"
        R"~(<path fill="none" stroke="#b84300" stroke-width="1.5" stroke-dasharray="7 3" d="M133.6 209h28"/>)~"
        R"~(<text x="167.6" y="213">limit</text></svg>)~");
  CHECK(histogram_chart({"h", "v", "n", {3}, 40.0, "limit", 335, 220, 1}).value ==
        R"~(<svg role="img" class="chart" viewBox="0 0 335 220" width="335" height="220"><title>h</title>)~"
        R"~(<path class="grid" d="M47.2 181V8"/><text x="47.2" y="195" text-anchor="middle">2.85</text>)~"
        R"~(<path class="grid" d="M92.8 181V8"/><text x="92.8" y="195" text-anchor="middle">2.90</text>)~"
        R"~(<path class="grid" d="M138.5 181V8"/><text x="138.5" y="195" text-anchor="middle">2.95</text>)~"
        R"~(<path class="grid" d="M184.1 181V8"/><text x="184.1" y="195" text-anchor="middle">3.00</text>)~"
        R"~(<path class="grid" d="M229.7 181V8"/><text x="229.7" y="195" text-anchor="middle">3.05</text>)~"
        R"~(<path class="grid" d="M275.4 181V8"/><text x="275.4" y="195" text-anchor="middle">3.10</text>)~"
        R"~(<path class="grid" d="M321 181V8"/><text x="321" y="195" text-anchor="middle">3.15</text>)~"
        R"~(<path class="grid" d="M47.2 181H321"/><text x="41.2" y="185" text-anchor="end">0.0</text>)~"
        R"~(<path class="grid" d="M47.2 147.4H321"/><text x="41.2" y="151.4" text-anchor="end">0.2</text>)~"
        R"~(<path class="grid" d="M47.2 113.8H321"/><text x="41.2" y="117.8" text-anchor="end">0.4</text>)~"
        R"~(<path class="grid" d="M47.2 80.2H321"/><text x="41.2" y="84.2" text-anchor="end">0.6</text>)~"
        R"~(<path class="grid" d="M47.2 46.6H321"/><text x="41.2" y="50.6" text-anchor="end">0.8</text>)~"
        R"~(<path class="grid" d="M47.2 13H321"/><text x="41.2" y="17" text-anchor="end">1.0</text>)~"
        R"~(<path class="axis" d="M47.2 8V181H321"/>)~"
        R"~(<text x="184.1" y="211" text-anchor="middle">v (limit 40: beyond this axis)</text>)~"
        R"~(<text transform="translate(12 94.5) rotate(-90)" text-anchor="middle">n</text>)~"
        R"~(<path fill="#d5dde3" d="M47.2 181l0-168l273.8 0l0 168V181H47.2z"/>)~"
        R"~(<path fill="none" stroke="#000000" stroke-width="1.3" d="M47.2 181l0-168l273.8 0l0 168"/></svg>)~");
  // Two spans of the values away, a limit is still drawn.
  for (const auto& [limit, drawn] : {std::pair{-7.0, true}, {-7.1, false}, {13.0, true}, {13.1, false}}) {
    const std::string chart = histogram_chart({"h", "v", "n", {1, 5}, limit, "limit", 335, 220, 4}).value;
    CHECK((chart.find(">limit</text>") != std::string::npos) == drawn);
    CHECK((chart.find(": beyond this axis)") == std::string::npos) == drawn);
  }
}

TEST_CASE("drawn: maps of an array, values beyond the scale and none, and the scale itself") {
  FrameMap map{"m", 2, 3, {0, 0.5, 0.5, 1, -3, kHole}, {0.0, 1.0}, 60.0};
  CHECK(numbered_map(map, 1).value ==
        R"~(<svg role="img" class="map" viewBox="0 0 60 40" width="60" height="40"><title>m</title>)~"
        R"~(<g transform="scale(20)"><path fill="#002352" d="M0 0h3v2H0z"/>)~"
        R"~(<path fill="#817f77" d="M1 0h2.04v1.04h-2.04z"/><path fill="#fbe649" d="M0 1h1.04v1.04h-1.04z"/>)~"
        R"~(<path fill="#ffffff" d="M2 1h1v1h-1z"/><path class="cross" d="M2.2 1.2l.6 .6m0 -.6l-.6 .6"/></g>)~"
        R"~(<text class="cell" x="10" y="13.2" fill="#ffffff">0.0</text>)~"
        R"~(<text class="cell" x="30" y="13.2" fill="#000000">0.5</text>)~"
        R"~(<text class="cell" x="50" y="13.2" fill="#000000">0.5</text>)~"
        R"~(<text class="cell" x="10" y="33.2" fill="#000000">1.0</text>)~"
        R"~(<text class="cell" x="30" y="33.2" fill="#ffffff">−3.0</text></svg>)~");
  CHECK(frame_map({"f", 1, 4, {0.5, 0.5, kHole, 0.9}, {0.0, 1.0}, 78.0}).value ==
        R"~(<svg role="img" class="map" viewBox="0 0 78 19.5" width="78" height="19.5"><title>f</title>)~"
        R"~(<g transform="scale(19.5)"><path fill="#817f77" d="M0 0h4v1H0z"/>)~"
        R"~(<path fill="#e4cf5b" d="M3 0h1.04v1.04h-1.04z"/><path fill="#ffffff" d="M2 0h1v1h-1z"/>)~"
        R"~(<path class="cross" d="M2.2 0.2l.6 .6m0 -.6l-.6 .6"/></g></svg>)~");
  map.scale = {1.0, 1.0};  // of no length: all are at its low end
  CHECK(frame_map(map).value.find("M0 0h3v2H0z") != std::string::npos);
  CHECK(frame_map(map).value.find("v1.04h") == std::string::npos);
  CHECK(cividis(0.25) == "#414d6c");
  CHECK(cividis(0.6) == "#959077");
  CHECK(colour_bar({-0.5, 2.0}, "bar", "psi", 1).value ==
        R"~(<p class="scale">−0.5 psi <svg role="img" viewBox="0 0 160 10" width="160" height="10">)~"
        R"~(<title>bar</title><path fill="#002352" d="M0 0H160v10H0z"/><path fill="#00285b" d="M5 0H160v10H5z"/>)~"
        R"~(<path fill="#002d65" d="M10 0H160v10H10z"/><path fill="#00336e" d="M15 0H160v10H15z"/>)~"
        R"~(<path fill="#0f396e" d="M20 0H160v10H20z"/><path fill="#1f3e6d" d="M25 0H160v10H25z"/>)~"
        R"~(<path fill="#2f446c" d="M30 0H160v10H30z"/><path fill="#3c4a6b" d="M35 0H160v10H35z"/>)~"
        R"~(<path fill="#45506c" d="M40 0H160v10H40z"/><path fill="#4d556c" d="M45 0H160v10H45z"/>)~"
        R"~(<path fill="#565b6d" d="M50 0H160v10H50z"/><path fill="#5d616e" d="M55 0H160v10H55z"/>)~"
        R"~(<path fill="#646770" d="M60 0H160v10H60z"/><path fill="#6b6d72" d="M65 0H160v10H65z"/>)~"
        R"~(<path fill="#727373" d="M70 0H160v10H70z"/><path fill="#797975" d="M75 0H160v10H75z"/>)~"
        R"~(<path fill="#817f77" d="M80 0H160v10H80z"/><path fill="#888579" d="M85 0H160v10H85z"/>)~"
        R"~(<path fill="#908b78" d="M90 0H160v10H90z"/><path fill="#989277" d="M95 0H160v10H95z"/>)~"
        R"~(<path fill="#9f9876" d="M100 0H160v10H100z"/><path fill="#a79e75" d="M105 0H160v10H105z"/>)~"
        R"~(<path fill="#b0a572" d="M110 0H160v10H110z"/><path fill="#b8ac70" d="M115 0H160v10H115z"/>)~"
        R"~(<path fill="#c1b26d" d="M120 0H160v10H120z"/><path fill="#cab969" d="M125 0H160v10H125z"/>)~"
        R"~(<path fill="#d3c164" d="M130 0H160v10H130z"/><path fill="#dcc860" d="M135 0H160v10H135z"/>)~"
        R"~(<path fill="#e4cf5b" d="M140 0H160v10H140z"/><path fill="#ecd755" d="M145 0H160v10H145z"/>)~"
        R"~(<path fill="#f4df4f" d="M150 0H160v10H150z"/><path fill="#fbe649" d="M155 0H160v10H155z"/></svg> 2.0 psi)~"
        R"~(</p>)~");
}
