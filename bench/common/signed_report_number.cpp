#include "bench/common/signed_report_number.h"

#include <nlohmann/json.hpp>

#include "analysis/json_io.h"

namespace tactbench::bench {

std::string signed_report_number_in(const std::string& text) {
  std::string data = text;
  if (!text.starts_with('{')) {  // a page: its data are inside
    const std::string open = "id=\"report-data\">";
    const std::size_t from = text.find(open);
    if (from == std::string::npos) return {};
    const std::size_t begin = from + open.size(), end = text.find("</script>", begin);
    data = end == std::string::npos ? std::string() : text.substr(begin, end - begin);
  }
  const nlohmann::ordered_json json = analysis::try_ordered_json(data);
  if (!json.is_object() || !json.contains("number") || !json.contains("identification")) return {};
  std::string number = json.value("number", "");
  const nlohmann::ordered_json& identification = json["identification"];
  if (!identification.is_object() || !identification.contains("approvals")) return {};
  for (const auto& approval : identification["approvals"])
    if (approval.is_object() && approval.value("number", "") == number) return number;
  return {};
}

}  // namespace tactbench::bench
