// What `benchmark page` reads of the page's process and of the stream that its viewers get.
#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "bench/benchmarks/page.h"
#include "bench/benchmarks/page_viewers.h"

using namespace tactbench::bench;

namespace {

using PictureTime = PictureTimes::Time;

PictureTime at_ms(int ms) { return PictureTime(std::chrono::milliseconds(ms)); }

std::string picture_event(int position) {
  return "event: picture\ndata: {\"run\":7,\"position\":" + std::to_string(position) + ",\"rows\":16}\n\n";
}

}  // namespace

TEST_CASE("benchmark page: a process's seconds are its user and system ticks, whatever its name") {
  // Fields 14 and 15 of /proc/<process>/stat, as proc(5) counts them.
  const std::string stat =
      "4711 (a (b) 1 2) S 1 4711 4711 0 -1 4194304 100 200 300 400 250 50 7 9 20 0 3 0 12345 1000 2000\n";
  CHECK(processor_seconds_of(stat, 100.0) == 3.0);
  CHECK(processor_seconds_of(stat, 1000.0) == 0.3);
}

TEST_CASE("benchmark page: the most memory of a process in megabytes, 0 where nothing is said of it") {
  CHECK(resident_mb_of("Name:\ttactbench\nVmPeak:\t   99999 kB\nVmHWM:\t   13824 kB\nVmRSS:\t 1024 kB\n") == 13.5);
  CHECK(resident_mb_of("VmHWM:\t   1024 kB\n") == 1.0);
  CHECK(resident_mb_of("Name:\tkthreadd\n") == 0.0);
}

TEST_CASE("benchmark page: each picture's first time by its position, from pieces of a stream") {
  PictureTimes pictures;
  const std::string first = picture_event(41), second = picture_event(42);
  pictures.take("event: status\ndata: {\"position\":5}\n\n" + first.substr(0, 20), at_ms(100));
  CHECK(pictures.times().empty());
  pictures.take(first.substr(20, first.size() - 21), at_ms(110));  // all but the last line end
  CHECK(pictures.times().empty());
  pictures.take("\n" + second + picture_event(41), at_ms(120));
  CHECK(pictures.times() == std::map<std::int64_t, PictureTime>{{41, at_ms(120)}, {42, at_ms(120)}});
  pictures.take(picture_event(42) + picture_event(43), at_ms(130));  // the second time does not count
  CHECK(pictures.times() == std::map<std::int64_t, PictureTime>{{41, at_ms(120)}, {42, at_ms(120)}, {43, at_ms(130)}});
  CHECK(pictures.text() == "event: status\ndata: {\"position\":5}\n\n" + first + second + picture_event(41) +
                               picture_event(42) + picture_event(43));
}

TEST_CASE("benchmark page: a picture without a position is passed over, and the next event's is not taken for it") {
  PictureTimes pictures;
  pictures.take("event: picture\ndata: {}\n\nevent: status\ndata: {\"position\":8}\n\n" + picture_event(9), at_ms(5));
  CHECK(pictures.times() == std::map<std::int64_t, PictureTime>{{9, at_ms(5)}});
  pictures.take("event: status\ndata: {\"position\":10}\n\n", at_ms(6));
  CHECK(pictures.times().size() == 1);
}

TEST_CASE("benchmark page: delays of the pictures of this run alone, each from its own frame") {
  const std::vector<PictureTime> stored = {at_ms(1000), at_ms(1050), at_ms(1100)};
  CHECK(delays_ms_of({{0, at_ms(1010)}, {1, at_ms(1004)}, {2, at_ms(1058)}, {3, at_ms(1116)}, {4, at_ms(1200)}}, stored,
                     at_ms(990)) == std::vector<double>{4.0, 8.0, 16.0});
  // Those of the run before came before this one begun, or just then.
  CHECK(delays_ms_of({{1, at_ms(1001)}, {2, at_ms(1052)}, {3, at_ms(1103)}}, stored, at_ms(1052)) ==
        std::vector<double>{3.0});
  CHECK(delays_ms_of({}, stored, at_ms(0)).empty());
}
