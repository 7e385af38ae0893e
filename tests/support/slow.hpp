#pragma once

#include <cstdlib>
#include <gtest/gtest.h>

/// For the first line of tests that are long, above all with sanitizers: skips the test if tests as
/// long as it are not asked for. The environment variable ALTIRO3D_LONGEST_TEST (default: 10) is
/// the limit in seconds; .ci/run has a lower one for sanitizers, scripts/check-all.sh none.
/// @param seconds what the test takes on two cores, without sanitizers
#define ALTIRO3D_TAKES(seconds)                                                                    \
    if ((seconds) > ::altiro3D::test::longestTest())                                               \
    GTEST_SKIP() << "is long: ALTIRO3D_LONGEST_TEST=1000 runs it"

namespace altiro3D::test {

inline double longestTest() {
    const char* const limit = std::getenv("ALTIRO3D_LONGEST_TEST");
    return limit != nullptr ? std::atof(limit) : 10;
}

} // namespace altiro3D::test
