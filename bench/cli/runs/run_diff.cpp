// runs diff: compares two runs, from the run's row down to the first frame and the verdicts.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct RunDifference {
  std::string what, first, second;
};

// Members of two documents that are not equal, named by their path; `at` is empty at the top.
void compare_members(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b, const std::string& at,
                     std::vector<RunDifference>& found) {
  if (a == b) return;
  const auto path = [&](const std::string& key) { return at.empty() ? key : fmt::format("{}.{}", at, key); };
  const auto shown = [](const nlohmann::ordered_json& value) {
    return value.is_string() ? value.get<std::string>() : value.is_null() ? "nothing" : analysis::json_line(value);
  };
  const auto parts = [](const nlohmann::ordered_json& value) { return value.is_object() ? value.size() : 0; };
  // Also if one of them lacks a tree, its members are listed one by one.
  if ((a.is_object() && b.is_object()) || (a.is_null() && parts(b) > 0) || (b.is_null() && parts(a) > 0)) {
    for (const auto& [key, value] : a.items())
      compare_members(value, b.is_null() ? nlohmann::ordered_json() : b.value(key, nlohmann::ordered_json()), path(key),
                      found);
    for (const auto& [key, value] : b.items()) {
      if (a.is_null() || !a.contains(key)) compare_members(nlohmann::ordered_json(), value, path(key), found);
    }
  } else if (a.is_array() && b.is_array() && a.size() == b.size()) {
    for (std::size_t i = 0; i < a.size(); ++i) compare_members(a[i], b[i], fmt::format("{}[{}]", at, i), found);
  } else if (shown(a) != shown(b)) {  // two NaN are not equal, but are the same to a reader
    found.push_back({at, shown(a), shown(b)});
  }
}

nlohmann::ordered_json comparable(const db::RunStore& store, const db::RunRecord& run) {
  nlohmann::ordered_json json = analysis::run_json(run);
  // Members that differ between any two runs, or come from the computer and its clock.
  for (const char* own : {"run", "uuid", "started_utc", "ended_utc", "rest_s", "host", "time_zone"}) json.erase(own);
  // Shown apart: runs of two lots may be the same otherwise.
  json.erase("metadata");
  json["tags"] = nlohmann::ordered_json::array();
  for (const std::string& tag : run.tags)
    if (tag.find('=') == std::string::npos) json["tags"].push_back(tag);
  // Settings by their key, so that they can be compared.
  auto settings = nlohmann::ordered_json::object();
  const nlohmann::ordered_json typed = json["overrides"];
  for (const auto& setting : typed.is_array() ? typed : nlohmann::ordered_json::array())
    if (setting.is_object() && setting.contains("key") && setting["key"].is_string())
      settings[setting["key"].get<std::string>()] = setting.value("value", nlohmann::ordered_json());
  json["overrides"] = settings;
  json["frames"] = store.frame_count(run.run);
  json["checks"] = nlohmann::ordered_json::array();
  for (const db::CheckRecord& check : store.checks(run.run)) {
    json["checks"].push_back(fmt::format("{} {}", check.kind, check.verdict));
  }
  for (const analysis::JudgedFigure& figure : analysis::figures_of(store.verdicts(run.run))) {
    json["verdicts"][fmt::format("{} ({})", to_string(figure.criterion),
                                 display_text(figure.scope, analysis::PressureUnit::kPsi))] =
        fmt::format("{}: {:.9g} {}, limit {:g}", to_string(figure.verdict), figure.value,
                    to_string(quantity_of(figure.criterion)), figure.limit);
  }
  return json;
}

// The first difference of two frames; empty: none.
std::string frame_difference(const db::FrameRecord& a, const db::FrameRecord& b) {
  const auto real = [](const char* name, double x, double y) {
    return x == y || (std::isnan(x) && std::isnan(y)) ? std::string() : fmt::format("{} {} and {}", name, x, y);
  };
  if (a.ordinal != b.ordinal) return fmt::format("step {} and {}", a.ordinal, b.ordinal);
  for (const std::string& text :
       {real("setpoint_psi", a.setpoint_psi, b.setpoint_psi), real("reference_psi", a.reference_psi, b.reference_psi),
        real("feedback_psi", a.feedback_psi, b.feedback_psi)}) {
    if (!text.empty()) return text;
  }
  if (a.time_ns != b.time_ns) return fmt::format("time_ns {} and {}", a.time_ns, b.time_ns);
  if (a.flags != b.flags) return fmt::format("flags '{}' and '{}'", a.flags, b.flags);
  if (a.counts.size() != b.counts.size()) return fmt::format("{} and {} counts", a.counts.size(), b.counts.size());
  for (std::size_t i = 0; i < a.counts.size(); ++i) {
    if (a.counts[i] == b.counts[i]) continue;
    const auto taxels = static_cast<std::size_t>(a.rows) * static_cast<std::size_t>(a.columns);
    return fmt::format("scan {}, taxel {}: {} and {} counts", taxels == 0 ? 0 : i / taxels,
                       taxels == 0 ? i : i % taxels, a.counts[i], b.counts[i]);
  }
  return {};
}

void diff_runs(std::int64_t first, std::int64_t second, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord a = store.run(first), b = store.run(second);
  std::vector<RunDifference> found;
  compare_members(comparable(store, a), comparable(store, b), {}, found);
  const std::vector<db::FrameRecord> frames_a = store.frames(first), frames_b = store.frames(second);
  std::size_t equal = 0, position = 0;
  std::string what;
  for (std::size_t i = 0; i < std::min(frames_a.size(), frames_b.size()); ++i) {
    const std::string difference = frame_difference(frames_a[i], frames_b[i]);
    equal += difference.empty() ? 1 : 0;
    if (difference.empty() || position != 0) continue;
    position = i + 1;
    what = difference;
  }
  std::vector<RunDifference> remarked;
  compare_members(analysis::run_json(a)["metadata"], analysis::run_json(b)["metadata"], "metadata", remarked);
  const bool same_content = !a.content_sha256.empty() && a.content_sha256 == b.content_sha256;
  session.code = same_content && found.empty() ? ExitCode::kPass : ExitCode::kCriterionFailed;
  if (session.json) {
    auto list = nlohmann::ordered_json::array();
    for (const RunDifference& d : found) list.push_back({JSON_FIELDS(d, what, first, second)});
    auto metadata = nlohmann::ordered_json::array();
    for (const RunDifference& d : remarked) metadata.push_back({JSON_FIELDS(d, what, first, second)});
    print_json("runs.diff", {{"runs", {first, second}},
                             {"same_content", same_content},
                             {"metadata", metadata},
                             {"differences", list},
                             {"frames_equal", equal},
                             {"first_frame", position},
                             {"first_frame_difference", what}});
    return;
  }
  analysis::doc::Table table{
      .columns = {{"what"}, {fmt::format("run {}", first)}, {fmt::format("run {}", second)}, {}}};
  const auto add = [&](const RunDifference& d, const char* remark) {
    table.rows.push_back({{one_line(d.what), one_line(d.first), one_line(d.second), remark}});
  };
  for (const RunDifference& d : found) add(d, "");
  for (const RunDifference& d : remarked) add(d, "remark: not part of the comparison");
  if (!table.rows.empty()) print_table(std::move(table));
  tty::print("frames: {} of run {} and {} of run {}, {} equal at the same position\n", frames_a.size(), first,
             frames_b.size(), second, equal);
  if (position != 0) tty::print("first frame that differs: {}: {}\n", position, what);
  tty::print("content: {}\n", same_content ? "the same, by its hash" : "not the same");
}

}  // namespace

void add_run_diff(CLI::App& runs, Session& session) {
  auto numbers = std::make_shared<std::pair<std::int64_t, std::int64_t>>();
  CLI::App* verb =
      runs.add_subcommand("diff", "show the differences between two runs (exit code 1), or that there are none (0)");
  verb->add_option("a", numbers->first, "run number")->required();
  verb->add_option("b", numbers->second, "run number")->required();
  verb->callback([numbers, &session] { diff_runs(numbers->first, numbers->second, session); });
}

}  // namespace tactbench::bench
