#include "analysis/identify/stored/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/histories.h"
#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

std::string differing(const std::string& what, double stored, double recomputed) {
  return fmt::format("{}: stored {:.17g}, recomputed {:.17g}", what, stored, recomputed);
}

std::string differing_text(const std::string& what, const std::string& stored, const std::string& recomputed) {
  return fmt::format("{}: stored '{}', recomputed '{}'", what, stored, recomputed);
}

std::string compare_json(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                         double tolerance);

// The elements of a model's "taxels" are named by their number.
std::string name_of_element(const std::string& what, std::size_t i, const nlohmann::json& element) {
  if (!element.is_object() || !element.contains("taxel") || !element["taxel"].is_number_integer())
    return fmt::format("{}[{}]", what, i);
  const int taxel = element["taxel"].get<int>();
  return taxel == kMeanTaxel ? "mean taxel" : fmt::format("taxel {}", taxel);
}

std::string compare_arrays(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                           double tolerance) {
  if (stored.size() != recomputed.size())
    return fmt::format("{}: {} stored, {} recomputed", what, counted(stored.size(), "element"), recomputed.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    std::string found = compare_json(name_of_element(what, i, recomputed[i]), stored[i], recomputed[i], tolerance);
    if (!found.empty()) return found;
  }
  return {};
}

std::string compare_objects(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                            double tolerance) {
  for (const auto& [key, value] : stored.items()) {
    const std::string name = fmt::format("{}.{}", what, key);
    if (!recomputed.contains(key)) return differing_text(name, json_line(value), "nothing");
    std::string found = compare_json(name, value, recomputed[key], tolerance);
    if (!found.empty()) return found;
  }
  for (const auto& [key, value] : recomputed.items())
    if (!stored.contains(key)) return differing_text(fmt::format("{}.{}", what, key), "nothing", json_line(value));
  return {};
}

std::string compare_json(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                         double tolerance) {
  if (stored.is_number() && recomputed.is_number()) {
    const auto a = stored.get<double>(), b = recomputed.get<double>();
    const bool same = tolerance > 0.0 ? same_number(a, b, tolerance)
                                      : std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
    return same ? std::string() : differing(what, a, b);
  }
  if (stored.is_array() && recomputed.is_array()) return compare_arrays(what, stored, recomputed, tolerance);
  if (stored.is_object() && recomputed.is_object()) return compare_objects(what, stored, recomputed, tolerance);
  return stored == recomputed ? std::string() : differing_text(what, json_line(stored), json_line(recomputed));
}

std::string scope_named(const db::VerdictRecord& v) {
  if (v.scope_kind == "array") return "verdict on " + v.criterion;
  return fmt::format("verdict on {} ({}, {:g} to {:g} psi, {}, share {:g})", v.criterion, v.scope_kind, v.low_psi,
                     v.high_psi, v.direction, v.share);
}

}  // namespace

bool same_number(double a, double b, double tolerance) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  if (std::isinf(a) || std::isinf(b)) return a == b;
  return a == b || std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b));
}

std::string first_difference(const std::string& stored, const std::string& recomputed, double tolerance) {
  const nlohmann::json a = try_json(stored), b = try_json(recomputed);
  if (a.is_discarded()) return "model: what is stored cannot be read";
  return compare_json("model", a, b, tolerance);
}

std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance, bool with_u) {
  if (stored.size() != recomputed.size()) {
    return fmt::format("{} stored, {} recomputed", counted(stored.size(), "verdict"), recomputed.size());
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const db::VerdictRecord &a = stored[i], &b = recomputed[i];
    const std::string name = scope_named(b);
    if (scope_named(a) != name) return differing_text(fmt::format("verdict {}", i + 1), scope_named(a), name);
    if (!same_number(a.value, b.value, tolerance)) return differing(fmt::format("{}, value", name), a.value, b.value);
    if (with_u && !same_number(a.expanded, b.expanded, tolerance))
      return differing(fmt::format("{}, U", name), a.expanded, b.expanded);
    if (!same_number(a.limit, b.limit, tolerance)) return differing(fmt::format("{}, limit", name), a.limit, b.limit);
    if (a.unit != b.unit) return differing_text(fmt::format("{}, unit", name), a.unit, b.unit);
    if (a.rule != b.rule) return differing_text(fmt::format("{}, rule", name), a.rule, b.rule);
    if (a.verdict != b.verdict) return differing_text(name, a.verdict, b.verdict);
    if (a.limits_sha256 != b.limits_sha256) {
      return differing_text("limits, SHA-256", a.limits_sha256, b.limits_sha256);
    }
  }
  return {};
}

}  // namespace tactbench::analysis
