// A model's document and frames: whatever stands in it, a stream of it reads its own memory alone, and a pressure that
// it calls valid is a number. The document, a byte 0, then bytes that set up the stream and make its frames.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/compensate/document.h"
#include "analysis/error.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"

using namespace tactbench::analysis;

namespace {

struct Bytes {
  const std::uint8_t* at;
  std::size_t left;
  std::uint8_t next() { return left == 0 ? 0 : (--left, *at++); }
};

// Low bytes are outputs from 0 to `full`.
float sample_of(std::uint8_t byte, double full) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr std::array<float, 8> kOdd = {std::numeric_limits<float>::quiet_NaN(), kInf,  -kInf, 1e30F, -1e30F,
                                         std::numeric_limits<float>::max(),       -1.0F, 1e-30F};
  return byte >= 248 ? kOdd[byte - 248U] : static_cast<float>(full * byte / 247.0);
}

void put_through(FrameCompensator& stream, Bytes bytes, double full) {
  const std::size_t taxels = stream.taxels();
  std::vector<float> volts(taxels), pressure(taxels), uncertainty(taxels);
  std::vector<std::uint16_t> status(taxels);
  const FrameCompensator::Output output{pressure, uncertainty, status};
  for (int frame = 0; frame < 64 && bytes.left > 0; ++frame) {
    const std::uint8_t what = bytes.next();
    const double seconds = what % 16 > 8 ? std::pow(10.0, what / 8 - 16) : 0.4;
    for (float& sample : volts) sample = sample_of(what, full);
    if (what % 16 == 1) (void)stream.tare(volts);
    if (what % 16 == 2) stream.start(Start::kAtRest);
    if (what % 16 == 3) stream.start(Start::kUnknown);
    if (what % 16 == 5) stream.work(seconds);
    if (what % 16 == 4) {
      stream.lost_frame(seconds, output);
    } else {
      for (float& sample : volts) sample = sample_of(bytes.next(), full);
      stream.frame(volts, seconds, output);
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
  const std::string text(reinterpret_cast<const char*>(data), end);
  Bytes bytes{data + end, size - end};
  (void)bytes.next();
  const double volts = std::pow(10.0, bytes.next() % 32 - 16), noisier = std::pow(10.0, bytes.next() % 32 - 16);
  const double full = bytes.next() < 128 ? 65535.0 * volts : 5.0;
  // As a robot reads it, and as the program does.
  try {
    DocumentFrames own = frames_from_document(text, static_cast<int>(std::min(noisier, 100.0)));
    if (own.frames.taxels() <= 1000) put_through(own.frames, bytes, full);
  } catch (const std::invalid_argument&) {
  }
  try {
    const SensorModel model = document_from_text(text, "fuzzed.json");
    if (model.array().size() > 1000) return 0;
    FrameCompensator frames = frames_of(model, noisier, 2);
    put_through(frames, bytes, full);
  } catch (const AnalysisError& error) {
    if (!error.id().starts_with("TB-MODEL-")) std::abort();
  }
  return 0;
}
