// The contract of the C API: sizes, versions, nulls refused; and no allocation in a frame.
#include "analysis/compensate/compensator_c.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <new>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

// Counts what this thread takes from the heap while it is told to.
thread_local bool counting = false;
thread_local int allocations = 0;

void* counted_or_null(std::size_t size) noexcept {
  if (counting) ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}

void* counted(std::size_t size) {
  void* memory = counted_or_null(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Not inlined: GCC 12 would see malloc() meet delete, or new meet free(), and warn.
[[gnu::noinline]] void* operator new(std::size_t size) { return counted(size); }
[[gnu::noinline]] void* operator new[](std::size_t size) { return counted(size); }
// The standard library's temporary buffers ask so, and give back through the plain delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return counted_or_null(size);
}
[[gnu::noinline]] void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return counted_or_null(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

struct Given {
  tb_compensator_setup setup;
  std::vector<tb_compensator_taxel> taxels;
  explicit Given(const Frames& frames) : setup(c_setup_of(frames.setup, TB_COMPENSATOR_START_AT_REST)) {
    for (const TaxelSetup& own : frames.setup.taxels) taxels.push_back(c_taxel_of(own));
  }
  int create(tb_compensator** handle, std::string* why = nullptr) const {
    char message[80] = "untouched";
    const int code = tb_compensator_create(&setup, taxels.data(), handle, message, sizeof message);
    if (why != nullptr) *why = message;
    return code;
  }
};

}  // namespace

TEST_CASE("C API: null pointers, wrong sizes and invalid values are refused with a message, and no object is created") {
  const Frames frames = random_reversals(4, 10, 0.002, 0.7);
  tb_compensator* handle = nullptr;
  std::string why;
  const auto refused = [&](int code, const auto& spoil) {
    Given given(frames);
    spoil(given);
    handle = reinterpret_cast<tb_compensator*>(1);
    CHECK(given.create(&handle, &why) == code);
    CHECK(handle == nullptr);
    CHECK_FALSE(why.empty());
  };
  refused(TB_COMPENSATOR_SIZE, [](Given& g) { g.setup.struct_size -= 16; });
  refused(TB_COMPENSATOR_SIZE, [](Given& g) { g.taxels[0].struct_size = 8; });
  refused(TB_COMPENSATOR_SIZE, [](Given& g) { g.taxels[2].struct_size += 8; });
  for (const std::size_t none : {std::size_t{65544}, SIZE_MAX - 7}) {  // addresses of such taxels would wrap around
    refused(TB_COMPENSATOR_SIZE, [&](Given& g) { g.setup.struct_size = none; });
    refused(TB_COMPENSATOR_SIZE, [&](Given& g) {
      for (tb_compensator_taxel& taxel : g.taxels) taxel.struct_size = none;
    });
  }
  refused(TB_COMPENSATOR_SIZE, [](Given& g) { g.setup.knots = 1; });
  refused(TB_COMPENSATOR_SIZE, [](Given& g) { g.setup.taxels = 0; });
  refused(TB_COMPENSATOR_NULL, [](Given& g) { g.setup.pressure = nullptr; });
  refused(TB_COMPENSATOR_NULL, [](Given& g) { g.taxels[1].descending = nullptr; });
  refused(TB_COMPENSATOR_VALUE, [](Given& g) { g.setup.volts_per_count = -1.0; });
  refused(TB_COMPENSATOR_VALUE, [](Given& g) { g.taxels[3].beta_a = 2.0; });
  CHECK_THAT(why, Catch::Contains("taxel 3"));
  const Given given(frames);
  CHECK(tb_compensator_create(nullptr, given.taxels.data(), &handle, nullptr, 0) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_create(&given.setup, nullptr, &handle, nullptr, 0) == TB_COMPENSATOR_NULL);
  CHECK(tb_compensator_create(&given.setup, given.taxels.data(), nullptr, nullptr, 0) == TB_COMPENSATOR_NULL);
  char small[5];
  Given spoilt(frames);
  spoilt.setup.volts_per_count = 0.0;
  tb_compensator_create(&spoilt.setup, spoilt.taxels.data(), &handle, small, sizeof small);
  CHECK(std::strlen(small) == 4);
  CHECK(tb_compensator_taxels(nullptr) == 0);
  tb_compensator_destroy(nullptr);
}

TEST_CASE("C API: the longer structs of a later version are read by their own size") {
  struct Longer {
    tb_compensator_taxel taxel;
    double later;
  };
  const Frames frames = random_reversals(4, 10, 0.002, 0.7);
  const Given given(frames);
  std::vector<Longer> longer;
  for (const tb_compensator_taxel& taxel : given.taxels) {
    longer.push_back({taxel, 1e300});
    longer.back().taxel.struct_size = sizeof(Longer);
  }
  tb_compensator *one = nullptr, *other = nullptr;
  REQUIRE(tb_compensator_create(&given.setup, &longer.front().taxel, &one, nullptr, 0) == TB_COMPENSATOR_OK);
  REQUIRE(given.create(&other) == TB_COMPENSATOR_OK);
  for (std::size_t f = 0; f < 10; ++f) {
    float a[4], b[4];
    tb_compensator_counts(one, frames.at(f).data(), 4, a, nullptr, nullptr);
    tb_compensator_counts(other, frames.at(f).data(), 4, b, nullptr, nullptr);
    CHECK(std::equal(a, a + 4, b));
  }
  tb_compensator_destroy(one);
  tb_compensator_destroy(other);
}

TEST_CASE(
    "nothing is allocated after start-up: frames, turns, unknown starts, lost frames, tare, reset, on 64 x 64 taxels") {
  const Frames frames = random_reversals(64, 120, 0.004, 2.5);
  FrameSetup setup = frames.setup;
  const std::vector<TaxelSetup> row = setup.taxels;
  while (setup.taxels.size() < 64 * 64) setup.taxels.insert(setup.taxels.end(), row.begin(), row.end());
  setup.start_unknown = true;
  FrameCompensator<float> fast(setup);
  Results<float> results(64 * 64);
  std::vector<std::uint16_t> counts(64 * 64);
  std::vector<float> volts(64 * 64);
  counting = true;
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    for (std::size_t t = 0; t < counts.size(); ++t) {
      counts[t] = frames.at(f)[t % 64];
      volts[t] = static_cast<float>(counts[t] * setup.volts_per_count);
    }
    if (f % 7 == 3) volts[f] = std::nanf("");
    f % 2 == 0 ? fast.frame(counts, results.output()) : fast.frame(std::span<const float>(volts), results.output());
    if (f % 11 == 10) fast.lost_frame(results.output());
    if (f == 50) fast.reset_unknown();
    if (f == 80) fast.tare(counts);
    if (f == 90) fast.reset();
  }
  counting = false;
  CHECK(allocations == 0);
  for (std::size_t t = 192; t < counts.size(); ++t) REQUIRE(results.pressure[t] == results.pressure[128 + t % 64]);
}

TEST_CASE("the dynamic compensator allocates nothing after start-up", "[dynamic]") {
  constexpr std::size_t kTaxels = 40;
  DynamicArray array = dynamic_array(kTaxels, 0.002);
  array.setup.start_unknown = true;
  DynamicFrameCompensator<float> fast(array.setup);
  Results<float> results(kTaxels);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> volts(0.0, 2.5);
  std::vector<std::uint16_t> counts(kTaxels);
  std::vector<float> same(kTaxels);
  counting = true;
  for (int f = 0; f < 400; ++f) {
    for (std::size_t t = 0; t < kTaxels; ++t) {
      counts[t] = static_cast<std::uint16_t>(volts(random) / array.setup.volts_per_count);
      same[t] = t == 7 ? std::nanf("") : static_cast<float>(volts(random));
    }
    fast.set_interval(0.01 * (f % 3));
    f % 2 == 0 ? fast.frame(counts, results.output()) : fast.frame(std::span<const float>(same), results.output());
    if (f % 50 == 10) fast.lost_frame(results.output());
    if (f == 100) fast.reset_unknown();
    if (f == 200) fast.tare(counts);
    if (f == 300) fast.reset();
  }
  counting = false;
  CHECK(allocations == 0);
}
