#pragma once

#include <gtest/gtest.h>
#include <string>

namespace altiro3D::test {

/// Whether a text holds a part; a failed expectation shows both.
inline ::testing::AssertionResult holds(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos)
        return ::testing::AssertionSuccess() << '"' << part << "\" is in\n" << text;
    return ::testing::AssertionFailure() << '"' << part << "\" is not in\n" << text;
}

} // namespace altiro3D::test
