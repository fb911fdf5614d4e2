#pragma once
// Whether AddressSanitizer watches, which makes tests up to ten times as slow: what is repeated is repeated less often
// then.
namespace tactbench::tests {

#if defined(__has_feature)
inline constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace tactbench::tests
