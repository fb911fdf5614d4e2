// The whole table of beginnings by which files are known, and names that are open files already.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

TEST_CASE("a file's kind: each beginning in the table is of its own, and none without its last byte") {
  const std::string other = kind_of_file("my notes\n");
  const std::vector<std::vector<std::string>> kinds = {
      {std::string("SQLite format 3\0", 16)},
      {"\x37\x7f\x06\x82", "\x37\x7f\x06\x83", "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"},
      {"%PDF-"},
      {"\x89HDF\r\n\x1a\n"},
      {"<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
       "http-equiv=\"Content-Security-Policy\""},
      {"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name="},
      {"# HELP tactbench_"},
      {"# Talk of tactbench nightly, scenario "},
      {"tactbench selfcheck, "},
      {"# Written by `tactbench simulate`"},
      {"# correction of ", "# SIMULATED correction of "},
      {"# tactbench: frames of run "},
  };
  std::set<std::string> seen = {other};
  for (const std::vector<std::string>& beginnings : kinds) {
    const std::string kind = kind_of_file(beginnings.front());
    INFO(kind);
    CHECK(seen.insert(kind).second);
    for (const std::string& beginning : beginnings) {
      CHECK(kind_of_file(beginning + "\x01more\n") == kind);
      CHECK(kind_of_file(beginning.substr(0, beginning.size() - 1)) == other);
      CHECK(kind_of_file(" " + beginning) == other);
    }
  }
}

TEST_CASE("a file's kind: documents by their schema after blanks of all kinds, tables by their first line") {
  const std::string other = kind_of_file("my notes\n");
  const std::string document = kind_of_file("{\"schema\":\"tactbench.x\",\"version\":1}");
  CHECK_THAT(document, Catch::Contains("tactbench.x "));
  CHECK(kind_of_file(" \t\r\n{ \t\r\n\"schema\" \t\r\n: \t\r\n\"tactbench.x\"") == document);
  CHECK(kind_of_file("{\"schema\":\"tactbench.y\"}") != document);
  CHECK_THAT(kind_of_file("a;b\nx"), Catch::EndsWith(" a;b"));
  CHECK_THAT(kind_of_file("a b,\x7f\xc3\n\x01"), Catch::EndsWith(" a b,\x7f\xc3"));
  CHECK_THAT(kind_of_file("a\tb\n"), Catch::EndsWith(" a\tb"));
  for (const char* none :
       {"", "{", "{\"schema\":\"theirs\"}", "<!DOCTYPE html><html>", "\"schema\":\"tactbench.x\"", "{:\"tactbench.x\"",
        "{\"schema\"\"tactbench.x\"", "{\"schema\":\"tactbenchx\"", "{\"schema\":tactbench.x",
        "{\v\"schema\":\"tactbench.x\"", "a,b", "a b\n", "\na,b\n", "a,\x1f\n", "a,\x0b\n", "\n"})
    CHECK(kind_of_file(none) == other);
}

TEST_CASE("names of open files are written into where they stand, whatever was there") {
  const TemporaryFolder folder;
  for (const char* form : {"/dev/fd/", "/proc/self/fd/"}) {
    INFO(form);
    write_file(folder.path("f"), "my notes\nmore\n");
    const int file = ::open(folder.path("f").c_str(), O_WRONLY | O_CLOEXEC);
    REQUIRE(file >= 0);
    CHECK(::lseek(file, 3, SEEK_SET) == 3);
    write_output(form + std::to_string(file), "NO", false);
    CHECK(read_file(folder.path("f")) == "my NOtes\nmore\n");
    write_output(form + std::to_string(file), "T", false);  // behind what was written
    CHECK(read_file(folder.path("f")) == "my NOTes\nmore\n");
    ::close(file);
    try {
      write_output(form + std::to_string(file), "x", false);
      FAIL("it is closed");
    } catch (const Error& error) {
      CHECK(error.id() == "TB-FILE-WRITE");
    }
  }
}

TEST_CASE("text of any length is written, and how many bytes it has is told") {
  const TemporaryFolder folder;
  for (const std::size_t size : {0U, 1U, 65'535U, 65'536U, 65'537U, 200'000U}) {
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; i += 1000) text[i] = static_cast<char>('a' + i / 1000 % 26);
    const std::string path = folder.path(std::to_string(size));
    CHECK(write_output(
              path, "k", [&](std::ostream& stream) { stream << text; }, false) == size);
    CHECK(read_file(path) == text);
    CHECK(write_output(
              path, "k",
              [&](std::ostream& stream) {
                for (const char c : text) stream.put(c);
              },
              true) == size);
    CHECK(read_file(path) == text);
  }
}

TEST_CASE("a whole file is written with its folders, or not at all") {
  const TemporaryFolder folder;
  write_whole(folder.path("a/b/c"), "one");
  write_whole(folder.path("a/b/c"), "two");
  CHECK(read_file(folder.path("a/b/c")) == "two");
  CHECK_THROWS_AS(write_whole(folder.path("a/b"), "x"), Error);
  CHECK(read_file(folder.path("a/b/c")) == "two");
  CHECK_THROWS_AS(write_whole(folder.path("a/b/c/d"), "x"), Error);
}
