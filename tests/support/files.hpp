#pragma once

#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <string>

/// Skips the test with a clear message where the large test data is not there.
#define ALTIRO3D_REQUIRE_DATA(relativePath)                                                        \
    if (::altiro3D::test::dataPath(relativePath).empty())                                          \
    GTEST_SKIP() << "needs " << (relativePath)                                                     \
                 << " of the test data: set ALTIRO3D_TEST_DATA to its folder"

namespace altiro3D::test {

/// A file or folder of the large test data (`$ALTIRO3D_TEST_DATA`, else `../shared/data` beside the
/// source tree), or an empty path if it is not there.
std::filesystem::path dataPath(const std::string& relative);

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

/// The text of the altiro3D::Error that the call throws; a failure note if it throws none.
std::string errorOf(const std::function<void()>& call);

/// Whole contents of a file.
std::string slurp(const std::filesystem::path& file);

/// Writes a file, for inputs of tests.
void spill(const std::filesystem::path& file, const std::string& contents);

} // namespace altiro3D::test
