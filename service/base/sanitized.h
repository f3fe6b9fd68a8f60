// Whether this program is instrumented: it then has its own heap, reserves terabytes of addresses, makes system calls
// of its own, and must be a program's first library.
#pragma once

namespace omni::base {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace omni::base
