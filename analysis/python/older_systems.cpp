// Only for the shared library in the wheel: binds calls to versions that older systems have, instead of the newest
// version in Debian 12. The linker's --wrap sends the calls here (wheel.cmake).
#if !defined(__x86_64__)
#error "the versions below are those of glibc on x86-64"
#endif

#include <new>

// NOLINTBEGIN(readability-identifier-naming,bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp): the linker's
// names
extern "C" {

__asm__(".symver exp_2_2_5, exp@GLIBC_2.2.5");
__asm__(".symver hypot_2_2_5, hypot@GLIBC_2.2.5");
double exp_2_2_5(double x);
double hypot_2_2_5(double x, double y);
double __wrap_exp(double x);
double __wrap_hypot(double x, double y);
[[noreturn]] void __wrap__ZSt28__throw_bad_array_new_lengthv();

double __wrap_exp(double x) { return exp_2_2_5(x); }
double __wrap_hypot(double x, double y) { return hypot_2_2_5(x, y); }
// libstdc++ has it from GCC 11 on; it throws a bad_alloc, as here.
[[noreturn]] void __wrap__ZSt28__throw_bad_array_new_lengthv() { throw std::bad_alloc(); }
// glibc has it from 2.32 on, and shared pointers read it; false means that they always count atomically.
[[gnu::visibility("hidden")]] char __libc_single_threaded = 0;

}  // extern "C"
// NOLINTEND(readability-identifier-naming,bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
