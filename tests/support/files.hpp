#pragma once

#include "altiro3D/error.hpp"

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

/// While it exists, the standard input is a file.
class StandardInput {
  public:
    explicit StandardInput(const std::filesystem::path& file);
    ~StandardInput();
    StandardInput(const StandardInput&) = delete;
    StandardInput& operator=(const StandardInput&) = delete;

  private:
    int before_;
};

/// A suite whose tests write files.
class FileTest : public ::testing::Test {
  protected:
    TemporaryDirectory directory;
};

/// The text of the altiro3D::Error that the call throws, "(no error)" if it throws none. Any other
/// exception fails the test.
std::string errorOf(const std::function<void()>& call);

/// As errorOf(), without the file's name at the beginning of the text.
std::string problemOf(const std::filesystem::path& file, const std::function<void()>& call);

/// The code of the altiro3D::Error that the call throws; without one, the test fails.
ErrorCode codeOf(const std::function<void()>& call);

/// Success if the text has the part, or begins with it.
::testing::AssertionResult holds(const std::string& text, const std::string& part);
::testing::AssertionResult startsWith(const std::string& text, const std::string& part);

/// The text of all notes, a line each.
std::string textOf(const Notes& notes);

/// The only note. Of none or of several, one that tells them.
Note only(const Notes& notes);

/// How many files and folders a folder holds.
std::size_t filesIn(const std::filesystem::path& folder);

/// The contents of a file of some size, hard to compress.
std::string someBytes(std::size_t size);
/// Whole contents of a file; throws if it does not exist, so that two missing files are not equal.
std::string slurp(const std::filesystem::path& file);

/// Writes a file, for inputs of tests.
void spill(const std::filesystem::path& file, const std::string& contents);

} // namespace altiro3D::test
