// A run that is known value by value, and an HDF5 file that writes down what it is told.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <string>
#include <utility>

#include "bench/cli/export/hdf5_file.h"
#include "tests/db/store_example.h"

namespace tactbench::tests {

// One line a call.
class ToldFile : public bench::Hdf5File {
 public:
  void group(const std::string& path) override { line("group {}", path); }
  [[nodiscard]] bool has(const std::string& path) const override { return text_.find(" " + path + " ") != text_.npos; }
  void array(const std::string& path, const Reals& values, const std::string& unit, const Shape& shape) override {
    line("reals {} [{}] ({}) {}", path, unit, fmt::join(shape, "x"), fmt::join(values, ", "));
  }
  void array(const std::string& path, const Integers& values, const std::string& unit) override {
    line("integers {} [{}] {}", path, unit, fmt::join(values, ", "));
  }
  void array(const std::string& path, const Counts& values, const std::string& unit, const Shape& shape) override {
    line("counts {} [{}] ({}) {}", path, unit, fmt::join(shape, "x"), fmt::join(values, ", "));
  }
  void array(const std::string& path, const Texts& values) override {
    line("texts {} {}", path, fmt::join(values, " | "));
  }
  void axis(const std::string& path, std::size_t length) override { line("axis {} 0..{}", path, length); }
  void axis(const std::string& path, const Texts& names) override { line("axis {} {}", path, fmt::join(names, ", ")); }
  void axes_of(const std::string& path, const Texts& axes) override { line("axes {} {}", path, fmt::join(axes, ", ")); }
  void link(const std::string& there, const std::string& path) override { line("link {} = {}", path, there); }
  void text(const std::string& path, const std::string& value) override { line("text {} {}", path, value); }
  void attribute(const std::string& object, const std::string& name, const std::string& value) override {
    line("{}@{} '{}'", object, name, value);
  }
  void attribute(const std::string& object, const std::string& name, const Texts& values) override {
    line("{}@{} {}", object, name, fmt::join(values, ", "));
  }
  void attribute(const std::string& object, const std::string& name, double value) override {
    line("{}@{} {} real", object, name, value);
  }
  void attribute(const std::string& object, const std::string& name, std::int64_t value) override {
    line("{}@{} {}", object, name, value);
  }
  void close() override { line("close"); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  template <class... Parts>
  void line(fmt::format_string<Parts...> form, Parts&&... parts) {
    text_ += fmt::format(form, std::forward<Parts>(parts)...) + "\n";
  }
  std::string text_;
};

// Two frames of one scan, 3 x 2 taxels, the second with a force, on two branches, the first of them void.
inline std::int64_t store_known_run(db::RunStore& store) {
  db::RunRecord run = example_run();
  run.uuid = "01234567-89ab-4def-8123-456789abcdef";
  run.purpose = "to see";
  run.bench_toml = "bench file";
  run.sensor_toml = "sensor file";
  run.rest_s = 1.5;
  const Begun begun = begin_example(store, run);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.scans = 1;
  frame.counts = {1, 2, 3, 4, 5, 6};
  frame.trace = {{1.5F, 2.0F, 2.25F, 2.5F}};
  frame.wrench.reset();
  store.append_frame(begun.run, frame);
  store.void_branch(begun.branch, "scanner lost");
  db::BranchRecord again = example_branch();
  again.sequence = 0;
  again.repeat = 1;
  again.ordinal = 2;
  again.attempt = 3;
  again.from_psi = 60.0;
  again.to_psi = 0.5;
  again.from_n.reset();
  again.to_n.reset();
  frame = example_frame(store.begin_branch(begun.run, again), 1);
  frame.scans = 1;
  frame.counts = {11, 12, 13, 14, 15, 65535};
  frame.flags = "late";
  frame.since_command_ns = 21;
  frame.in_band_ns = 22;
  frame.device_time_us = 23;
  frame.status = 5;
  frame.exchanges = 12;
  frame.trace = {{0.5F, 3.0F, 3.25F, 3.5F}, {0.25F, 4.0F, 4.25F, 4.5F}};
  store.append_frame(begun.run, frame);
  store.append_check(begun.run, {begun.run, 4, "seating", "pass", R"({"rows":3})", {}});
  store.append_series(begun.run, {{0, 3, {0.5, 1.5}, {2.5, 3.5}}, {1, 2, {0.25}, {4.5}}});
  store.append_event(begun.run, {6, "fault", "TB-SCANNER-SILENT", "no report"});
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, kUtc);
  store.replace_verdicts(begun.run, 0,
                         {{1, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", "pass", "limits", "sha"}});
  store.set_tags(begun.run, {"lot=A7", "night"}, {});
  store.add_note(begun.run, "the door was open");
  return begun.run;
}

}  // namespace tactbench::tests
