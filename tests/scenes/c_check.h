/* CHECK: counts and prints the claims of the tests in C that do not hold. */
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
