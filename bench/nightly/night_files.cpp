#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "bench/nightly/night.h"

namespace tactbench::bench {
namespace {

// Escapes text for XML 1.0, which cannot represent most control characters.
std::string xml_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')
      escaped += '?';
    else
      escaped += c;
  }
  return escaped;
}

const ScenarioResult* result_of(const std::vector<ScenarioResult>& results, const Scenario& scenario) {
  const auto found = std::ranges::find(results, scenario.label, &ScenarioResult::name);
  return found == results.end() ? nullptr : &*found;
}

}  // namespace

std::string junit_xml(const Suite& suite, const std::vector<ScenarioResult>& results) {
  const auto red = std::ranges::count_if(results, [](const ScenarioResult& r) { return !r.wrong.empty(); });
  double seconds = 0.0;
  for (const ScenarioResult& result : results) seconds += result.seconds;
  std::string cases;
  for (const Scenario& scenario : suite.scenarios) {
    const ScenarioResult* result = result_of(results, scenario);
    cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", xml_text(suite.name),
                         scenario.label, result == nullptr ? 0.0 : result->seconds);
    if (result == nullptr) {
      cases += "><error message=\"it did not run\"/></testcase>\n";
    } else if (result->wrong.empty() && result->remarks.empty()) {
      cases += "/>\n";
    } else if (result->wrong.empty()) {
      cases += fmt::format("><system-out>{}</system-out></testcase>\n",
                           xml_text(fmt::format("{}", fmt::join(result->remarks, "\n"))));
    } else {
      cases += fmt::format(">\n    <failure message=\"{}\">{}\n{}</failure>\n  </testcase>\n",
                           xml_text(result->wrong.front()), xml_text(scenario.about),
                           xml_text(fmt::format("{}", fmt::join(result->wrong, "\n"))));
    }
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n{}</testsuite>\n",
      xml_text(suite.name), suite.scenarios.size(), red, suite.scenarios.size() - results.size(), seconds, cases);
}

std::string metrics_text(const Suite& suite, const std::vector<ScenarioResult>& results) {
  std::string green =
      "# HELP tactbench_nightly_green 1 when a scenario gave the expected result.\n# TYPE tactbench_nightly_green "
      "gauge\n";
  std::string figures =
      "# HELP tactbench_nightly_figure Figure measured by a scenario; its name includes the unit.\n# TYPE "
      "tactbench_nightly_figure gauge\n";
  for (const Scenario& scenario : suite.scenarios) {
    const ScenarioResult* result = result_of(results, scenario);
    green += fmt::format("tactbench_nightly_green{{scenario=\"{}\"}} {}\n", scenario.label,
                         result != nullptr && result->wrong.empty() ? 1 : 0);
    if (result == nullptr) continue;
    for (const auto& [figure, value] : result->figures)
      figures +=
          fmt::format("tactbench_nightly_figure{{scenario=\"{}\",figure=\"{}\"}} {}\n", scenario.label, figure, value);
  }
  return green + figures;
}

}  // namespace tactbench::bench
