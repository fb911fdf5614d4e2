// A run as the fleet holds it, and what its server answers to whom takes the run back.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "db/fleet/copy_back.h"
#include "db/fleet/local_runs.h"
#include "db/fleet/remarks.h"
#include "tests/db/fleet/scripted_postgres.h"
#include "tests/db/store_example.h"

namespace tactbench::tests::postgres {

using db::RunStore;
using db::fleet::Column;
using db::fleet::Kind;
using db::fleet::LocalRuns;
using db::fleet::Row;
using db::fleet::Table;
using db::fleet::Value;

inline constexpr std::int64_t kRun = 41, kFit = 71, kRevision = 9;  // the fleet's numbers

// To a COPY ... TO STDOUT: the rows in one piece, and its end.
inline std::string handed_out(const std::vector<Column>& columns, const std::vector<Row>& rows_of_it) {
  std::string bytes;
  db::fleet::add_copy_header(bytes);
  for (const Row& row : rows_of_it) db::fleet::add_copy_row(bytes, columns, row);
  db::fleet::add_copy_trailer(bytes);
  return copy('H') + piece(bytes) + message('c', "") + done("COPY") + ready();
}

inline Value text_value(const std::string& bytes) {
  Value value;
  value.bytes = bytes;
  return value;
}
inline Value number_value(std::int64_t number) {
  Value value;
  value.integer = number;
  return value;
}

// The rows of a table as the bench's store has them, under the fleet's number of the run.
inline std::vector<Row> rows_of(LocalRuns& local, const Table& table, std::int64_t month = 0) {
  db::sqlite::Statement statement(local.connection(), table.from_store);
  statement.bind_at(1, std::int64_t{1});
  if (month != 0) statement.bind_at(2, month);
  std::vector<Row> all;
  while (statement.step()) {
    Row& row = all.emplace_back();
    db::fleet::read_row(statement, table.columns, row, 1);
    row[0] = number_value(kRun);
  }
  return all;
}

// A judged run with all that may be said of one, and what the fleet's server answers to whom takes it back.
struct Fleet {
  TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  std::string uuid = "01234567-89ab-4def-8123-456789abcdef";
  Row sensor;
  db::fleet::Fit fit;
  db::fleet::Remarks remarks;

  Fleet() {
    db::RunRecord record = example_run();
    record.uuid = uuid;
    const std::int64_t run = store_example(store, record);
    db::FitTaxelRecord taxel;
    taxel.taxel = 2;
    taxel.status = "fitted";
    taxel.parameters = {0.1, 1.0 / 3.0};
    taxel.noise_v = 0.25;
    const std::int64_t own = store.add_fit({0, run, "elam", R"({"o":1})", R"({"s":2})", "0.1.0", kUtc, "{}"}, {taxel});
    db::VerdictRecord verdict;
    verdict.verdict = "pass";
    verdict.criterion = "by no fit";
    store.replace_verdicts(run, 0, {verdict});
    verdict.criterion = "by its fit";
    store.replace_verdicts(run, own, {verdict});
    store.replace_figures(run, "rig", {{"y_psi", 2.5}, {"x_psi", 0.5}});
    store.replace_figures(run, "a", {{"z", 1.0}});
    store.add_report({run, "1-a", "h", "K. Lee", kUtc, "", ""});
    store.add_report({run, "1-b", "i", "M. Ito", kUtc, "1-a", "serial corrected"});
    store.set_tags(run, {"lot=A7", "night"}, {});
    store.add_note(run, "the door was open");
    store.void_run(run, "gauge closed", "K. Lee", kUtc);
    LocalRuns local(store.path());
    fit = db::fleet::fits_in(local.connection(), run).at(0);
    std::map<std::int64_t, std::pair<std::string, std::string>> names;
    remarks = db::fleet::remarks_in(local.connection(), run, names);
    const db::SensorRecord s = example_sensor();
    for (const std::string* bytes :
         {&s.serial, &s.type, &s.type_toml, &s.type_sha256, &s.scanner_serial, &s.note, &s.added_utc})
      sensor.push_back(text_value(*bytes));
  }

  [[nodiscard]] std::vector<Column> run_columns() const {
    std::vector<Column> columns = db::fleet::runs_table().columns;
    for (const char* name : {"tags", "notes", "void_reason", "void_by", "void_utc"})
      columns.push_back({name, Kind::kText});
    return columns;
  }

  [[nodiscard]] std::vector<Answer> content(bool with_frames) const {
    LocalRuns local(store.path());
    std::vector<Answer> answers = {handed_out(db::fleet::sensors_table().columns, {sensor})};
    std::vector<Row> run = rows_of(local, db::fleet::runs_table());
    for (const std::string* said :
         {&remarks.tags, &remarks.notes, &remarks.void_reason, &remarks.void_by, &remarks.void_utc})
      run.at(0).push_back(text_value(*said));
    answers.emplace_back(handed_out(run_columns(), run));
    for (const Table& table : db::fleet::content_tables())
      answers.emplace_back(handed_out(table.columns, rows_of(local, table)));
    if (!with_frames) return answers;
    answers.emplace_back(rows(1, {{"202405"}}));
    answers.emplace_back(
        handed_out(db::fleet::frames_table().columns, rows_of(local, db::fleet::frames_table(), 202405)));
    return answers;
  }

  // To add_runs with frames; `hash_of_fit` and `hash_of_remarks` as the fleet keeps them.
  [[nodiscard]] std::vector<Answer> all(const std::string& hash_of_fit, const std::string& hash_of_remarks,
                                        const std::vector<Row>& sensors) const {
    std::vector<Answer> answers = {started(), done("BEGIN") + ready(),
                                   handed_out(db::fleet::sensors_table().columns, sensors)};
    for (const Answer& answer : content(true)) answers.push_back(answer);
    std::vector<Column> columns = db::fleet::fits_table().columns;
    columns.push_back({"run", Kind::kInteger});
    columns.push_back({"sha256", Kind::kText});
    Row row = fit.row;
    row[0] = number_value(kFit);
    row.push_back(number_value(kRun));
    row.push_back(text_value(hash_of_fit));
    answers.emplace_back(handed_out(columns, {row}));
    std::vector<Row> taxels = fit.taxels;
    for (Row& taxel : taxels) taxel[0] = number_value(kFit);
    answers.emplace_back(handed_out(db::fleet::fit_taxels_table().columns, taxels));
    const std::vector<Column> revision = {
        {"run", Kind::kInteger}, {"revision", Kind::kInteger}, {"sha256", Kind::kText},  {"tags", Kind::kText},
        {"notes", Kind::kText},  {"void_reason", Kind::kText}, {"void_by", Kind::kText}, {"void_utc", Kind::kText}};
    answers.emplace_back(
        handed_out(revision, {{number_value(kRun), number_value(kRevision), text_value(hash_of_remarks),
                               text_value(remarks.tags), text_value(remarks.notes), text_value(remarks.void_reason),
                               text_value(remarks.void_by), text_value(remarks.void_utc)}}));
    const auto of_revision = [](std::vector<Row> own) {
      for (Row& one : own) one[0] = number_value(kRevision);
      return own;
    };
    answers.emplace_back(handed_out(db::fleet::verdicts_table().columns, of_revision(remarks.verdicts)));
    std::vector<Row> figures = of_revision(remarks.figures);
    std::reverse(figures.begin(), figures.end());  // as a database of another language may sort them
    answers.emplace_back(handed_out(db::fleet::figures_table().columns, figures));
    answers.emplace_back(handed_out(db::fleet::reports_table().columns, of_revision(remarks.reports)));
    answers.emplace_back(rows(3, {{uuid, fit.sha256, std::to_string(kFit)}}));
    answers.emplace_back(rows(6, {{"3", "rig", "as made", "K. Lee", "2026-01-01", uuid},
                                  {"8", "rig", "elsewhere", "K. Lee", "2026-02-02", "of no run here"},
                                  {"5", "sensor", "new film", "M. Ito", "2026-03-03", uuid},
                                  {"5", "sensor", "new film", "M. Ito", "2026-03-03", "of no run here"}}));
    answers.emplace_back(done("ROLLBACK") + ready());
    return answers;
  }
};

// The rows that a server was sent for a table, between the beginning and the end that PostgreSQL's manual asks for.
inline std::vector<Row> sent_for(const std::vector<std::string>& heard, const Table& table) {
  std::vector<Row> found;
  db::fleet::CopyReader reader(table.columns, [&](const Row& row) { found.push_back(row); });
  const auto statement =
      std::find(heard.begin(), heard.end(), "Q" + db::fleet::copy_into(table) + std::string(1, '\0'));
  REQUIRE(statement != heard.end());
  std::string all;
  for (auto one = statement + 1; one != heard.end() && one->front() == 'd'; ++one) all += one->substr(1);
  reader.piece(all);
  CHECK(all.ends_with("\377\377"));
  CHECK(all.find("PGCOPY", 1) == std::string::npos);
  return found;
}

}  // namespace tactbench::tests::postgres
