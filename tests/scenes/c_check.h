/* CHECK: for tests in C. Prints a claim that does not hold, and counts it in `failures`. */
#ifndef TREPHINE_TESTS_SCENES_C_CHECK_H
#define TREPHINE_TESTS_SCENES_C_CHECK_H

#include <stdio.h>

static int failures = 0;
#define CHECK(claim)                                             \
  do {                                                           \
    if (!(claim)) {                                              \
      ++failures;                                                \
      printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #claim); \
    }                                                            \
  } while (0)

#endif
