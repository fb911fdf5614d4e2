// A model's document and frames: whatever stands in it, a stream of it reads its own memory alone, and a pressure that
// it calls valid is a number. The document, a byte 0, then bytes that set up the stream and make its frames.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/dynamic_setup_of.h"
#include "analysis/identify/stored/array_stream.h"
#include "analysis/identify/stored/model_document.h"

using namespace tactbench::analysis;

namespace {

struct Bytes {
  const std::uint8_t* at;
  std::size_t left;
  std::uint8_t next() { return left == 0 ? 0 : (--left, *at++); }
};

// Low bytes are outputs from 0 to the scanner's full scale, as `full`.
template <class Real>
Real sample_of(std::uint8_t byte, double full) {
  constexpr Real kInf = std::numeric_limits<Real>::infinity();
  constexpr std::array<Real, 8> kOdd = {
      std::numeric_limits<Real>::quiet_NaN(), kInf,     -kInf,      Real(1e30), Real(-1e30),
      std::numeric_limits<Real>::max(),       Real(-1), Real(1e-30)};
  return byte >= 248 ? kOdd[byte - 248U] : static_cast<Real>(full * byte / 247.0);
}

template <class Real, class Stream>
void put_through(Stream& stream, Bytes bytes, double full) {
  const std::size_t taxels = stream.taxels();
  std::vector<Real> volts(taxels), pressure(taxels), uncertainty(taxels);
  std::vector<std::uint16_t> status(taxels), counts(taxels);
  for (int frame = 0; frame < 64 && bytes.left > 0; ++frame) {
    const std::uint8_t what = bytes.next();
    if constexpr (requires { stream.tare(counts); }) {
      for (std::uint16_t& count : counts) count = static_cast<std::uint16_t>(257 * what);
      if (what % 16 == 1) (void)stream.tare(counts);
      if (what % 16 == 2) stream.reset();
      if (what % 16 == 3) stream.reset_unknown();
    }
    if constexpr (requires { stream.set_interval(0.0); })
      if (what % 16 > 8) stream.set_interval(std::pow(10.0, what / 8 - 16));
    if (what % 16 == 4) {
      stream.lost_frame({pressure, uncertainty, status});
    } else {
      for (Real& sample : volts) sample = sample_of<Real>(bytes.next(), full);
      stream.frame(std::span<const Real>(volts), {pressure, uncertainty, status});
    }
    for (std::size_t i = 0; i < taxels; ++i)
      if ((status[i] & kTaxelValid) != 0 && !(std::isfinite(pressure[i]) && std::isfinite(uncertainty[i])))
        std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::size_t end = 0;
  while (end < size && data[end] != 0) ++end;
  try {
    const SensorModel model = document_from_text({reinterpret_cast<const char*>(data), end}, "fuzzed.json");
    Bytes bytes{data + end, size - end};
    (void)bytes.next();
    const double volts_per_count = std::pow(10.0, bytes.next() % 32 - 16),
                 noisier = std::pow(10.0, bytes.next() % 32 - 16);
    const double full = bytes.next() < 128 ? 65535.0 * volts_per_count : 5.0;
    if (model.array().size() > 1000) return 0;
    ArrayStream stream(model, volts_per_count, noisier, 2);
    put_through<float>(stream, bytes, full);
    if (model.dynamics) {
      DynamicFrameCompensator<double> frames(dynamic_setup_of(model, model.array(), volts_per_count, noisier));
      put_through<double>(frames, bytes, full);
    } else if (paper_elam_of(model.taxels.front()) != nullptr) {
      FrameCompensator<double> frames(frame_setup_of(model, volts_per_count));
      put_through<double>(frames, bytes, full);
    }
  } catch (const AnalysisError& error) {
    if (!error.id().starts_with("TB-MODEL-")) std::abort();
  } catch (const std::invalid_argument&) {  // numbers that make no compensator
  }
  return 0;
}
