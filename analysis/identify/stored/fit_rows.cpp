#include "analysis/identify/stored/fit_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

std::string differing(const std::string& what, double stored, double recomputed) {
  return fmt::format("{}: stored {:.17g}, recomputed {:.17g}", what, stored, recomputed);
}

std::string differing_words(const std::string& what, const std::string& stored, const std::string& recomputed) {
  return fmt::format("{}: stored '{}', recomputed '{}'", what, stored, recomputed);
}

std::string compare_numbers(const std::string& what, const std::vector<double>& stored,
                            const std::vector<double>& recomputed, double tolerance) {
  if (stored.size() != recomputed.size()) {
    return fmt::format("{}: {} stored, {} recomputed", what, counted(stored.size(), "number"), recomputed.size());
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (same_number(stored[i], recomputed[i], tolerance)) continue;
    return differing(stored.size() == 1 ? what : fmt::format("{}[{}]", what, i), stored[i], recomputed[i]);
  }
  return {};
}

// Of programs that came later.
bool is_newer(const std::string& key) { return key == "residual_psi" || key == "undetermined"; }

// Members that only one side has are named; those that older programs did not keep are looked at only where stored.
std::string compare_json(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                         double tolerance) {
  if (stored.is_number() && recomputed.is_number()) {
    const auto a = stored.get<double>(), b = recomputed.get<double>();
    return same_number(a, b, tolerance) ? std::string() : differing(what, a, b);
  }
  if (stored.is_array() && recomputed.is_array() && stored.size() == recomputed.size()) {
    for (std::size_t i = 0; i < stored.size(); ++i) {
      std::string found = compare_json(fmt::format("{}[{}]", what, i), stored[i], recomputed[i], tolerance);
      if (!found.empty()) return found;
    }
    return {};
  }
  if (stored.is_object() && recomputed.is_object()) {
    for (const auto& [key, value] : stored.items()) {
      const std::string name = fmt::format("{}.{}", what, key);
      if (!recomputed.contains(key)) return differing_words(name, json_line(value), "nothing");
      std::string found = compare_json(name, value, recomputed[key], tolerance);
      if (!found.empty()) return found;
    }
    for (const auto& [key, value] : recomputed.items()) {
      if (stored.contains(key) || (key == "falling" && value == false) || is_newer(key)) continue;
      return differing_words(fmt::format("{}.{}", what, key), "nothing", json_line(value));
    }
    return {};
  }
  return stored == recomputed ? std::string() : differing_words(what, json_line(stored), json_line(recomputed));
}

std::string compare_text(const std::string& what, const std::string& stored, const std::string& recomputed,
                         double tolerance) {
  const nlohmann::json a = try_json(stored), b = try_json(recomputed);
  if (a.is_discarded()) return fmt::format("{}: what is stored cannot be read", what);
  return compare_json(what, a, b, tolerance);
}

std::string name_of(int taxel) { return taxel < 0 ? "mean taxel" : fmt::format("taxel {}", taxel); }

std::string compare_taxel(const db::FitTaxelRecord& a, const db::FitTaxelRecord& b, double tolerance) {
  const std::string name = name_of(a.taxel);
  if (a.status != b.status) return differing_words(fmt::format("{}, status", name), a.status, b.status);
  const bool complete = a.parameters.size() == kElamParameterNames.size() && b.parameters.size() == a.parameters.size();
  for (std::size_t i = 0; complete && i < a.parameters.size(); ++i) {
    if (same_number(a.parameters[i], b.parameters[i], tolerance)) continue;
    return differing(fmt::format("{}, {}", name, kElamParameterNames[i]), a.parameters[i], b.parameters[i]);
  }
  struct Column {
    const char* name;
    std::vector<double> a, b;
  };
  for (const Column& column :
       {Column{"parameters", a.parameters, b.parameters}, Column{"ascending_v", a.ascending_v, b.ascending_v},
        Column{"descending_v", a.descending_v, b.descending_v}, Column{"noise_v", {a.noise_v}, {b.noise_v}},
        Column{"j_v2", {a.j_v2}, {b.j_v2}}, Column{"mean_error_v", {a.mean_error_v}, {b.mean_error_v}},
        Column{"max_error_v", {a.max_error_v}, {b.max_error_v}},
        Column{"full_scale_v", {a.full_scale_v}, {b.full_scale_v}}}) {
    std::string found = compare_numbers(fmt::format("{}, {}", name, column.name), column.a, column.b, tolerance);
    if (!found.empty()) return found;
  }
  if (a.at_bound != b.at_bound) return differing(fmt::format("{}, at_bound", name), a.at_bound, b.at_bound);
  return {};
}

}  // namespace

bool same_number(double a, double b, double tolerance) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  if (std::isinf(a) || std::isinf(b)) return a == b;
  return a == b || std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b));
}

std::string made_by(const db::FitRecord& fit) {
  const nlohmann::json options = try_json(fit.options_json);
  if (!options.is_object() || !options.contains("made_by") || !options["made_by"].is_string()) return {};
  return options["made_by"].get<std::string>();
}

IdentifyOptions options_of(const db::FitRecord& fit) {
  IdentifyOptions options;
  try {
    const nlohmann::json stored = parse_json(fit.options_json);
    stored.at("exact_outer").get_to(options.exact_outer);
    options.settle = stored.value("settled", false);  // fits of older programs
  } catch (const nlohmann::json::exception& error) {
    throw AnalysisError(
        Cause::kStored, "TB-MODEL-STORED",
        fmt::format("the options of fit {} of run {} cannot be read: {}", fit.fit, fit.run, error.what()),
        fmt::format("fit the run again: tactbench fit {}", fit.run));
  }
  return options;
}

std::string first_difference(const FitRows& stored, const FitRows& recomputed, double tolerance) {
  if (stored.taxels.empty() && recomputed.taxels.empty())
    return compare_text("model", stored.fit.patterns_json, recomputed.fit.patterns_json, tolerance);
  std::map<int, const db::FitTaxelRecord*> kept;
  for (const db::FitTaxelRecord& taxel : stored.taxels) kept[taxel.taxel] = &taxel;
  std::string found =
      compare_text("grid and full scale", stored.fit.patterns_json, recomputed.fit.patterns_json, tolerance);
  if (!found.empty()) return found;
  for (const db::FitTaxelRecord& taxel : recomputed.taxels) {
    const auto own = kept.find(taxel.taxel);
    if (own == kept.end()) return fmt::format("{}: not stored", name_of(taxel.taxel));
    found = compare_taxel(*own->second, taxel, tolerance);
    if (!found.empty()) return found;
    kept.erase(own);
  }
  if (!kept.empty()) return fmt::format("{}: stored, but the run has no such taxel", name_of(kept.begin()->first));
  return compare_text("summary", stored.fit.summary_json, recomputed.fit.summary_json, tolerance);
}

std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance) {
  if (stored.size() != recomputed.size()) {
    return fmt::format("{} stored, {} recomputed", counted(stored.size(), "verdict"), recomputed.size());
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const db::VerdictRecord &a = stored[i], &b = recomputed[i];
    const std::string name = fmt::format("verdict on {} ({})", b.criterion, b.scope);
    if (a.criterion != b.criterion || a.scope != b.scope) {
      return differing_words(fmt::format("verdict {}", i + 1), fmt::format("{} ({})", a.criterion, a.scope),
                             fmt::format("{} ({})", b.criterion, b.scope));
    }
    if (!same_number(a.value, b.value, tolerance)) return differing(fmt::format("{}, value", name), a.value, b.value);
    if (!same_number(a.limit, b.limit, tolerance)) return differing(fmt::format("{}, limit", name), a.limit, b.limit);
    if (a.unit != b.unit) return differing_words(fmt::format("{}, unit", name), a.unit, b.unit);
    if (a.rule != b.rule) return differing_words(fmt::format("{}, rule", name), a.rule, b.rule);
    if (a.verdict != b.verdict) return differing_words(name, a.verdict, b.verdict);
    if (a.limits_sha256 != b.limits_sha256) {
      return differing_words("limits, SHA-256", a.limits_sha256, b.limits_sha256);
    }
  }
  return {};
}

}  // namespace tactbench::analysis
