#include "analysis/compensate/compensator_c.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/compensate/document.h"

using namespace tactbench::analysis;

static_assert(static_cast<int>(TB_TAXEL_VALID) == kTaxelValid && static_cast<int>(TB_TAXEL_FLAT) == kTaxelFlat &&
              static_cast<int>(TB_TAXEL_OUT_OF_RANGE) == kTaxelOutOfRange &&
              static_cast<int>(TB_TAXEL_DEAD) == kTaxelDead && static_cast<int>(TB_TAXEL_OUTSIDE) == kTaxelOutside &&
              static_cast<int>(TB_TAXEL_UNKNOWN) == kTaxelUnknown && static_cast<int>(TB_TAXEL_LOST) == kTaxelLost);

struct tb_compensator {
  DocumentFrames own;
  std::vector<float> spare;  // for results that the caller does not request: twice as many as taxels
  std::vector<std::uint16_t> bits;
};

namespace {

// Copies the error text, cut to the caller's buffer; returns `code`.
int refuse(int code, const char* why, char* message, std::size_t size) {
  if (message != nullptr && size > 0) {
    const std::size_t length = std::min(std::strlen(why), size - 1);
    std::memcpy(message, why, length);
    message[length] = 0;
  }
  return code;
}

int created(const std::string& text, unsigned scans, tb_compensator** handle, char* message, std::size_t size) {
  try {
    auto made = std::make_unique<tb_compensator>(
        tb_compensator{frames_from_document(text, static_cast<int>(std::min(scans, 1'000'000U))), {}, {}});
    const std::size_t count = made->own.frames.taxels();
    made->spare.resize(2 * count);
    made->bits.resize(count);
    *handle = made.release();
    return TB_COMPENSATOR_OK;
  } catch (const std::bad_alloc&) {
    return refuse(TB_COMPENSATOR_MEMORY, "not enough memory", message, size);
  } catch (const std::exception& fault) {
    return refuse(TB_COMPENSATOR_VALUE, fault.what(), message, size);
  }
}

// Calls `act` if the handle is not null; exceptions become error codes.
template <class Act>
int guarded(tb_compensator* handle, const Act& act) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  try {
    act(handle->own.frames);
    return TB_COMPENSATOR_OK;
  } catch (const std::bad_alloc&) {
    return TB_COMPENSATOR_MEMORY;
  } catch (const std::exception&) {
    return TB_COMPENSATOR_VALUE;
  }
}

}  // namespace

uint32_t tb_compensator_abi_version(void) { return TB_COMPENSATOR_ABI_VERSION; }

int tb_compensator_parse(const char* text, unsigned scans, tb_compensator** handle, char* message,
                         size_t message_size) {
  (void)refuse(0, "", message, message_size);
  if (handle != nullptr) *handle = nullptr;
  if (handle == nullptr || text == nullptr)
    return refuse(TB_COMPENSATOR_NULL, "handle or text is null", message, message_size);
  return created(text, scans, handle, message, message_size);
}

int tb_compensator_load(const char* file, unsigned scans, tb_compensator** handle, char* message, size_t message_size) {
  (void)refuse(0, "", message, message_size);
  if (handle != nullptr) *handle = nullptr;
  if (handle == nullptr || file == nullptr)
    return refuse(TB_COMPENSATOR_NULL, "handle or file is null", message, message_size);
  std::string text;
  try {
    std::ifstream in;
    in.exceptions(std::ios::failbit | std::ios::badbit);
    in.open(file, std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(in), {});
  } catch (const std::exception&) {  // also for a folder
    return refuse(TB_COMPENSATOR_FILE, "the file cannot be read", message, message_size);
  }
  return created(text, scans, handle, message, message_size);
}

void tb_compensator_destroy(tb_compensator* handle) { delete handle; }

size_t tb_compensator_taxels(const tb_compensator* handle) { return handle == nullptr ? 0 : handle->bits.size(); }

int tb_compensator_frame(tb_compensator* handle, const float* outputs, size_t count, double seconds, float* pressure,
                         float* uncertainty, uint16_t* status) {
  if (handle == nullptr || outputs == nullptr || pressure == nullptr) return TB_COMPENSATOR_NULL;
  if (count != handle->bits.size()) return TB_COMPENSATOR_SIZE;
  if (std::isnan(seconds) && handle->own.frames.needs_time()) return TB_COMPENSATOR_TIME;
  float* const doubt = uncertainty != nullptr ? uncertainty : handle->spare.data();
  std::uint16_t* const bits = status != nullptr ? status : handle->bits.data();
  return guarded(handle, [&](FrameCompensator& frames) {
    frames.frame({outputs, count}, seconds, {{pressure, count}, {doubt, count}, {bits, count}});
  });
}

int tb_compensator_lost_frame(tb_compensator* handle, double seconds) {
  if (handle == nullptr) return TB_COMPENSATOR_NULL;
  if (std::isnan(seconds) && handle->own.frames.needs_time()) return TB_COMPENSATOR_TIME;
  const std::size_t count = handle->bits.size();
  float* const spare = handle->spare.data();
  return guarded(handle, [&](FrameCompensator& frames) {
    frames.lost_frame(seconds, {{spare, count}, {spare + count, count}, handle->bits});
  });
}

int tb_compensator_start(tb_compensator* handle, int at_rest, double worked_seconds) {
  if (!std::isfinite(worked_seconds) || worked_seconds < 0.0) return TB_COMPENSATOR_VALUE;
  return guarded(handle, [&](FrameCompensator& frames) {
    frames.start(at_rest != 0 ? Start::kAtRest : Start::kUnknown);
    frames.work(worked_seconds);
  });
}

int tb_compensator_tare(tb_compensator* handle, const float* outputs, size_t count, size_t* refused) {
  if (handle == nullptr || outputs == nullptr) return TB_COMPENSATOR_NULL;
  if (count != handle->bits.size()) return TB_COMPENSATOR_SIZE;
  return guarded(handle, [&](FrameCompensator& frames) {
    const std::size_t off = frames.tare({outputs, count});
    if (refused != nullptr) *refused = off;
  });
}

int tb_compensator_set_outside_validity(tb_compensator* handle, int outside) {
  return guarded(handle, [&](FrameCompensator& frames) { frames.set_outside_validity(outside != 0); });
}
