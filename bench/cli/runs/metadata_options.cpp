#include "bench/cli/runs/metadata_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "analysis/documents/run_metadata.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kLongestTag = 64;

[[noreturn]] void refuse_metadata(const std::string& what, const char* option, const std::string& remedy) {
  throw Error("TB-USAGE", what, option, remedy);
}

std::string metadata_tag(const std::string& key, const std::string& value, const char* option) {
  std::string tag = key + "=" + value;
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._:/+-").find(c) != std::string_view::npos;
  };
  if (key.empty() || value.empty() || tag.size() > kLongestTag || !std::ranges::all_of(key, plain) ||
      !std::ranges::all_of(value, plain))
    refuse_metadata(fmt::format("'{}' cannot be recorded as metadata", tag), option,
                    "key and value are words of letters, digits and . _ : / + -, together at most 63 of them; write "
                    "sentences into --purpose or a note");
  return tag;
}

}  // namespace

void add_metadata_options(CLI::App& verb, MetadataOptions& options, bool filter) {
  verb.add_option("--lot", options.lot, filter ? "only of this lot" : "lot that the sensor comes from; recorded");
  verb.add_option("--order", options.order,
                  filter ? "only of this order" : "order that the run is for; recorded, and printed on the report");
  verb.add_option("--meta", options.pairs,
                  filter ? "only with this metadata: KEY=VALUE, or KEY with any value"
                         : "further metadata as KEY=VALUE; recorded, and printed on the report")
      ->take_all();
}

std::vector<std::string> metadata_tags(const MetadataOptions& options) {
  std::vector<std::string> tags, keys;
  const auto add = [&](const std::string& key, const std::string& value, const char* option) {
    if (std::ranges::find(keys, key) != keys.end())
      refuse_metadata(fmt::format("'{}' is named twice", key), option,
                      "name each key once; --lot and --order are the keys lot and order");
    keys.push_back(key);
    tags.push_back(metadata_tag(key, value, option));
  };
  if (!options.lot.empty()) add("lot", options.lot, "--lot");
  if (!options.order.empty()) add("order", options.order, "--order");
  for (const std::string& text : options.pairs) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos)
      refuse_metadata(fmt::format("'{}' is no KEY=VALUE", text), "--meta", "e.g. --meta film=B12");
    add(text.substr(0, equals), text.substr(equals + 1), "--meta");
  }
  return tags;
}

bool fits_metadata(const MetadataOptions& asked, const db::RunRecord& run) {
  const std::map<std::string, std::string> metadata = analysis::metadata_of(run);
  const auto has = [&](const std::string& key, const std::string& value) {
    const auto found = metadata.find(key);
    return found != metadata.end() && found->second == value;
  };
  if (!asked.lot.empty() && !has("lot", asked.lot)) return false;
  if (!asked.order.empty() && !has("order", asked.order)) return false;
  return std::ranges::all_of(asked.pairs, [&](const std::string& text) {
    const std::size_t equals = text.find('=');
    return equals == std::string::npos ? metadata.contains(text) : has(text.substr(0, equals), text.substr(equals + 1));
  });
}

}  // namespace tactbench::bench
