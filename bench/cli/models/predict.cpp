// predict and compensate: apply a stored model to a table, line by line, so that they work in a pipe.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "analysis/counted.h"
#include "analysis/export/quantise.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/read_whole_file.h"
#include "analysis/table.h"
#include "bench/cli/models/fixed_options.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/runs/source.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

struct PredictOptions {
  std::string model, file = "-", output, taxel;
  TableOptions table;
  double conditioned_s = 0.0;
  FixedWords fixed;
  bool counts = false, tared = false;                       // outputs are the converter's; the first is the zero
  std::shared_ptr<const analysis::FixedModel> fixed_model;  // no option: of `fixed`
};

// The single taxel of a model, for rows that do not name one.
int only_taxel(const analysis::SensorModel& model, const std::string& wanted) {
  if (wanted == "mean") return analysis::kMeanTaxel;
  if (!wanted.empty()) {
    int taxel = 0;
    const char* end = wanted.data() + wanted.size();
    if (const auto [last, fault] = std::from_chars(wanted.data(), end, taxel); fault == std::errc() && last == end)
      return taxel;
    throw Error("TB-MODEL-TAXEL", fmt::format("'{}' is not the number of a taxel", wanted), "--taxel",
                "add --taxel N or --taxel mean");
  }
  if (model.taxels.size() == 1) return model.taxels.front().taxel;
  throw Error("TB-MODEL-TAXEL", fmt::format("the model has {} taxels, but the table names none", model.taxels.size()),
              "--taxel");
}

const analysis::ModelTaxel& fitted(const analysis::SensorModel& model, int number) {
  const analysis::ModelTaxel& taxel = model.taxel(number);
  if (taxel.fit.model != nullptr) return taxel;
  throw Error("TB-ANALYSIS-NO-TAXEL", fmt::format("taxel {} has no model: {}", number, taxel.why()), "--taxel",
              "choose another taxel");
}

// One history: a taxel in a sequence. Makes the text that is added to a row of the table.
class Predictor {
 public:
  static constexpr std::array kColumns{"predicted"};
  static std::array<std::string, 1> units(const analysis::SensorModel& model) { return {model.output_unit}; }
  Predictor(const analysis::SensorModel& model, const analysis::ModelTaxel& taxel, const PredictOptions&)
      : model_(&model), taxel_(&taxel), state_(taxel.fit.model->state()) {}
  std::string step(const analysis::TableReader::Row& row, std::size_t /*column*/, char /*separator*/) {
    state_->go(row.input);
    return fmt::format("{}", model_->from_model(*taxel_, state_->output_at(row.input)));
  }

 private:
  const analysis::SensorModel* model_;
  const analysis::ModelTaxel* taxel_;
  std::unique_ptr<analysis::ModelState> state_;
};

class Compensation {
 public:
  static constexpr std::array kColumns{"compensated", "uncertainty", "flags"};
  static std::array<std::string, 3> units(const analysis::SensorModel& model) {
    return {model.input_unit, model.input_unit, {}};
  }
  Compensation(const analysis::SensorModel& model, const analysis::ModelTaxel& taxel, const PredictOptions& options)
      : sign_(model.falling ? -1.0 : 1.0),
        timed_(model.dynamics && analysis::in_time(*model.dynamics)),
        conditioned_s_(options.conditioned_s),
        stream_(analysis::compensator_of(model, taxel)) {}
  std::string step(const analysis::TableReader::Row& row, std::size_t column, char separator) {
    double seconds = 0.0;
    const double output = sign_ * row.outputs[column];
    if (!begun_ && std::isnan(output)) return nothing("bad", separator);
    if (timed_ && !row.time && std::isnan(output)) return nothing("bad", separator);  // the next row's time covers it
    if (timed_) {
      const std::string place = fmt::format("line {}", row.line);
      if (!row.time) throw Error("TB-TABLE-ROW", "the time is not a number", place, "times are numbers, in seconds");
      double now_s = *row.time;
      const std::size_t wraps = order_.wraps();
      if (const std::string wrong = order_.see(now_s); !wrong.empty()) throw Error("TB-TABLE-TIME", wrong, place);
      if (order_.wraps() > wraps && column == 0)
        tty::print(stderr, "{}: the time wraps as a counter or clock does: unwrapped\n", place);
      seconds = now_s - before_.value_or(now_s);
      before_ = now_s;
    }
    if (!begun_) begin(output);
    const analysis::Compensated now = stream_->step(output, seconds);
    if (now.held) return nothing(std::isnan(output) ? "bad" : "range", separator);
    // Not known: beyond the loop, where the input is its end, and where the model does not know the noise (0).
    const bool known = !now.out_of_range && now.uncertainty_psi > 0.0;
    const double uncertainty = known ? now.uncertainty_psi : std::numeric_limits<double>::quiet_NaN();
    std::vector<const char*> flags;
    if (now.out_of_range) flags.push_back("range");
    if (now.flat) flags.push_back("flat");
    if (now.unknown) flags.push_back("unknown");
    return fmt::format("{:.6g}{}{:.4g}{}{}", now.pressure_psi, separator, uncertainty, separator,
                       fmt::join(flags, " "));
  }

 private:
  // For an invalid sample.
  static std::string nothing(const char* flag, char separator) {
    return fmt::format("nan{0}nan{0}{1}", separator, flag);
  }

  // A recording that does not begin at the unloaded output begins in mid-branch.
  void begin(double output) {
    begun_ = true;
    if (!stream_->at_rest(output)) stream_->start(analysis::Start::kUnknown);
    stream_->work(conditioned_s_);
  }

  double sign_;
  bool timed_, begun_ = false;
  double conditioned_s_;
  analysis::TimeOrder order_;
  std::optional<double> before_;
  std::unique_ptr<analysis::Compensator> stream_;
};

// The same with the integers of a device.
class FixedCompensation {
 public:
  static constexpr std::array kColumns{"compensated", "pressure_count", "flags"};
  static std::array<std::string, 3> units(const analysis::SensorModel& model) { return {model.input_unit, {}, {}}; }
  FixedCompensation(const analysis::SensorModel& model, const analysis::ModelTaxel& taxel,
                    const PredictOptions& options)
      : counts_(options.counts), tares_(options.tared), stream_(options.fixed_model, place_of(model, taxel)) {}
  std::string step(const analysis::TableReader::Row& row, std::size_t column, char separator) {
    const double output = row.outputs[column];
    const bool lost = std::isnan(output);
    std::vector<const char*> flags;
    analysis::FixedReading now;
    if (lost) {
      now = stream_.lost();
    } else if (tares_) {
      tares_ = false;
      now.status = stream_.tare(count(output)) ? 0 : TB_UNKNOWN;
      flags.push_back("tare");
    } else {
      now = stream_.step(count(output));
    }
    if (lost) flags.push_back("bad");
    if ((now.status & TB_OUT_OF_RANGE) != 0) flags.push_back("range");
    if ((now.status & TB_UNKNOWN) != 0) flags.push_back("unknown");
    if ((now.status & TB_DEAD) != 0) flags.push_back("dead");
    return fmt::format("{:.6g}{}{}{}{}", stream_.model().pressure(now.pressure), separator, now.pressure, separator,
                       fmt::join(flags, " "));
  }

 private:
  static std::size_t place_of(const analysis::SensorModel& model, const analysis::ModelTaxel& taxel) {
    const std::span<const analysis::ModelTaxel> array = model.array();
    if (&taxel < array.data() || &taxel >= array.data() + array.size())
      throw Error("TB-MODEL-TAXEL", "the mean taxel is not on the device", "--taxel", "name a taxel of the array");
    return static_cast<std::size_t>(&taxel - array.data());
  }
  [[nodiscard]] std::uint16_t count(double output) const {
    if (!counts_) return analysis::count_of(stream_.model(), output);
    return static_cast<std::uint16_t>(std::lround(std::clamp(output, 0.0, 65535.0)));
  }
  bool counts_, tares_;
  analysis::FixedTaxel stream_;
};

// The text added to a row, with the table's decimal separator.
std::string written(std::string added, const analysis::TableReader& reader) {
  if (!reader.decimal_comma() || reader.separator() == ',') return added;
  std::ranges::replace(added, '.', ',');
  return added;
}

template <class Applied>
void apply(PredictOptions options, const Session& session, analysis::TableNeeds needs) {
  const analysis::SensorModel model = load_model(options.model, session);
  constexpr bool kFixed = std::is_same_v<Applied, FixedCompensation>;
  if constexpr (kFixed) {
    options.fixed.options.conditioned_s = options.conditioned_s;
    options.fixed_model =
        std::make_shared<analysis::FixedModel>(fixed_model(options.model, model, options.fixed.options, session));
  }
  tty::print(stderr, "{}{}", undetermined_text(model), any_unfit(model) ? left_out_text(model) : "");
  std::ifstream file;
  if (options.file != "-") {
    const char* remedy = "check its name and permissions; - is standard input";
    const bool has_text = analysis::check_file(options.file, true, "TB-TABLE-OPEN", remedy);
    if (has_text) file.open(options.file);
    if (!file) throw Error("TB-TABLE-OPEN", "the table cannot be read", options.file, remedy);
  }
  std::istream& in = options.file == "-" ? std::cin : file;
  analysis::TableReader reader(in, options.file == "-" ? "standard input" : options.file, layout_of(options.table),
                               needs);
  const bool wide = reader.outputs() > 1;  // one column per taxel
  const std::span<const analysis::ModelTaxel> array = model.array();
  if (wide && (array.size() != reader.outputs() || !options.taxel.empty()))
    throw Error("TB-TABLE-MAP",
                fmt::format("{} output columns, but {} to compensate", reader.outputs(),
                            options.taxel.empty() ? analysis::counted(array.size(), "taxel") : "one taxel"),
                "--map",
                "name one column for each of the model's taxels, in their order; or one column and its --taxel");
  const bool in_time = model.dynamics && analysis::in_time(*model.dynamics);
  if (in_time && !kFixed && needs == analysis::TableNeeds::kOutput && !reader.has_seconds())
    throw Error("TB-TABLE-COLUMN", "the model compensates lag and creep, but the table has no column of times",
                options.file,
                "add a column time_s in seconds or name it (--map time=COL), or use a model without them");
  if (in_time && needs == analysis::TableNeeds::kInput)
    tty::print(stderr,
               "the predicted outputs are static, without lag and creep: the values at the end of all creep, somewhat "
               "above the output that a held pressure reaches\n");
  const int only = reader.has_taxel() || wide ? 0 : only_taxel(model, options.taxel);
  std::map<std::pair<std::string, int>, Applied, std::less<>> histories;
  const std::string separator(1, reader.separator());
  const std::size_t taxels = wide ? array.size() : 1;  // a row
  std::string text, names, units;
  for (std::size_t k = 0; k < taxels; ++k) {
    for (const char* name : Applied::kColumns)
      names += wide ? fmt::format("{}{}_{}", separator, name, array[k].taxel) : separator + name;
    units += fmt::format("{}{}", separator, fmt::join(Applied::units(model), separator));
  }
  if (!reader.header().empty()) text = analysis::without_formulas(reader.header(), reader.separator()) + names + "\n";
  if (!reader.units_line().empty()) text += reader.units_line() + units + "\n";
  if (!options.output.empty()) check_output(options.output, kind_of_file(text), session.replace);
  const auto flush = [&] {
    const std::string& sent = ::isatty(STDOUT_FILENO) != 0 ? text = terminal_safe(text) : text;
    if (std::fwrite(sent.data(), 1, sent.size(), stdout) != sent.size() || std::fflush(stdout) != 0)
      throw Error("TB-FILE-WRITE", "the table cannot be written", "standard output",
                  "check space and permissions of the file, or the program that reads the pipe");
    text.clear();
  };
  const std::optional<analysis::Range>& range = model.validity.input;
  const double slack = range ? analysis::kInputSlack * (range->high - range->low) : 0.0;
  std::size_t rows = 0, outside = 0, bad = 0, none = 0, beyond = 0;
  std::string first_bad;
  for (analysis::TableReader::Row row; reader.next(row);) {
    ++rows;
    if (!row.bad.empty() && ++bad == 1) first_bad = row.bad;
    if (!row.bad.empty() && std::ranges::all_of(row.outputs, [](double y) { return std::isnan(y); })) ++none;
    if (needs == analysis::TableNeeds::kInput && range && !range->contains(row.input, slack)) ++outside;
    text += analysis::without_formulas(row.text, reader.separator());
    for (std::size_t k = 0; k < taxels; ++k) {
      if (wide && array[k].fit.model == nullptr) {
        text += fmt::format("{0}nan{0}nan{0}{1}", separator, analysis::to_string(array[k].status));
        continue;
      }
      if (needs == analysis::TableNeeds::kOutput && row.outputs.empty()) {
        text += fmt::format("{0}nan{0}nan{0}bad", separator);
        continue;
      }
      const analysis::ModelTaxel& taxel = wide ? array[k] : fitted(model, reader.has_taxel() ? row.taxel : only);
      try {
        auto& history = histories.try_emplace({row.sequence, taxel.taxel}, model, taxel, options).first->second;
        const std::string added = history.step(row, k, reader.separator());
        if (added.ends_with("range")) ++beyond;
        text += separator + written(added, reader);
      } catch (const std::invalid_argument& error) {
        throw Error("TB-MODEL-DOCUMENT",
                    fmt::format("the model of taxel {} has no value there: {}", taxel.taxel, error.what()),
                    fmt::format("{}, line {}", options.file, row.line),
                    "check its parameters (tactbench model show), or fit it again");
      }
    }
    text += "\n";
    if (options.output.empty()) flush();
  }
  if (none > 0 && none == rows)
    throw Error("TB-TABLE-SKIPPED", fmt::format("no row has the values to be compensated; the first: {}", first_bad),
                options.file, "check separators, decimal commas and the assignment of columns (--map)");
  if (options.output.empty())
    flush();
  else
    write_output(options.output, text, session.replace);
  for (const std::string& line : reader.assumed())
    tty::print(stderr, "{}: {}\n", options.file == "-" ? "standard input" : options.file, line);
  if (bad > 0)
    tty::print(stderr, "warning: no output in {} of {}; these have nan and the flag bad; the first: {}\n", bad,
               analysis::counted(rows, "row"), first_bad);
  if (2 * beyond > rows * taxels)
    tty::print(stderr, "warning: {} of {} outputs are beyond the model's range: are they in {}?\n", beyond,
               rows * taxels, model.output_unit.empty() ? "the unit of the fit" : model.output_unit);
  if (outside > 0)
    tty::print(stderr, "{} of {} inputs are outside the model's validity, {}\n", outside, rows,
               model.input_unit == "psi"
                   ? session.unit().short_span(range->low, range->high)
                   : fmt::format("{:.4g} to {:.4g} {}", range->low, range->high, model.input_unit));
}

CLI::App* add_verb(CLI::App& app, Session& session, const std::shared_ptr<PredictOptions>& options, const char* name,
                   const char* what) {
  CLI::App* verb = app.add_subcommand(name, what);
  verb->add_option("model", options->model, "a .json that fit -o wrote, or RUN or RUN:FIT of the store")->required();
  verb->add_option("file", options->file, "table; - for standard input, line by line")->capture_default_str();
  verb->add_option("-o,--output", options->output, "file to write (default: standard output)");
  add_replace(*verb, session);
  add_layout_options(*verb, options->table);
  verb->add_option("--taxel", options->taxel, "taxel of a model of many, if the table has no column taxel: N, or mean")
      ->check(CLI::NonNegativeNumber | CLI::IsMember({"mean"}));
  add_void_too(*verb, session);
  return verb;
}

}  // namespace

void add_predict(CLI::App& app, Session& session) {
  auto predict = std::make_shared<PredictOptions>(), compensate = std::make_shared<PredictOptions>();
  add_verb(app, session, predict, "predict",
           "compute a model's outputs for the inputs of a table: adds a column predicted")
      ->callback([predict, &session] { apply<Predictor>(*predict, session, analysis::TableNeeds::kInput); });
  CLI::App* verb = add_verb(
      app, session, compensate, "compensate",
      "compute pressures (inputs) from the outputs of a table, by a model's inverse\n"
      "Adds columns compensated, uncertainty (standard; nan where it is not known: the model has no noise, or the "
      "output "
      "lies far outside the loop) and flags (flat; range: an output that the taxel cannot give, the input is the "
      "loop's "
      "end or nan; bad: the row holds no output, and what follows is as without it; unknown: the recording begins in "
      "mid-branch, and the input is midway between all that its history may be). Of a table with one column a taxel "
      "(--map output=3-18, or what runs export wrote) each taxel's, with its number, as compensated_0; flags of a "
      "taxel "
      "without a model say why. A model that undoes lag and creep needs a column time_s, in seconds.");
  verb->add_option("--conditioned", compensate->conditioned_s,
                   "dynamic: seconds for which the pressure cycled over its range just before the first row")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  add_fixed_options(*verb, compensate->fixed);
  verb->add_flag("--counts", compensate->counts, "--as fixed: the outputs are counts of the device's converter");
  verb->add_flag("--tared", compensate->tared,
                 "--as fixed: the first row is the unloaded sensor, with which the device was tared");
  verb->callback([compensate, &session] {
    if (compensate->fixed.as == "fixed")
      apply<FixedCompensation>(*compensate, session, analysis::TableNeeds::kOutput);
    else
      apply<Compensation>(*compensate, session, analysis::TableNeeds::kOutput);
  });
}

}  // namespace tactbench::bench
