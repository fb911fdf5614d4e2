// Linked into the unit tests that start no thread: ThreadSanitizer does not run them. Stands in for the C library's
// function, which it never calls.
#include <pthread.h>

#include <cstdio>
#include <cstdlib>

extern "C" int pthread_create(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) {
  std::fputs("a unit test starts a thread; let its file's name end in _threads.cpp\n", stderr);
  std::abort();
}
