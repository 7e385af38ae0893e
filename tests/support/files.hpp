#pragma once

#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <vector>

/// Skips the test with a clear message if the large test data is missing.
#define ALTIRO3D_REQUIRE_DATA(relativePath)                                                        \
    if (::altiro3D::test::dataPath(relativePath).empty())                                          \
    GTEST_SKIP() << "needs " << (relativePath)                                                     \
                 << " of the test data: set ALTIRO3D_TEST_DATA to its folder"

namespace altiro3D::test {

/// A file or folder of the large test data (`$ALTIRO3D_TEST_DATA`, else `../shared/data` beside the
/// source tree), or an empty path if it is not there.
std::filesystem::path dataPath(const std::string& relative);

/// The calibrations of the large test data, one per display; the test fails if some are missing.
/// Empty without the data.
std::vector<std::filesystem::path> realCalibrations();

/// A file of the source tree.
std::filesystem::path sourcePath(const std::string& relative);

/// A fresh directory, removed with its contents at the end.
class TemporaryDirectory {
  public:
    TemporaryDirectory();
    ~TemporaryDirectory();
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

/// The text of the altiro3D::Error that the call throws, "(no error)" if it throws none. Any other
/// exception fails the test.
std::string errorOf(const std::function<void()>& call);

/// Whole contents of a file; throws if it does not exist, so that two missing files are not equal.
std::string slurp(const std::filesystem::path& file);

/// Writes a file, for inputs of tests.
void spill(const std::filesystem::path& file, const std::string& contents);

} // namespace altiro3D::test
