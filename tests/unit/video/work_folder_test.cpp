#include "video/chunks/chunk_files.hpp"

#include "altiro3D/file_io.hpp"
#include "support/files.hpp"

#include <algorithm>
#include <chrono>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>
#include <vector>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

// The number of no process: systems have smaller ones.
const std::string kEnded = "2000000001";

class WorkFolderTest : public FileTest {
  protected:
    // Makes a folder with a file in it, as old as this. @return whether the C++ library can do it
    bool makeFolder(const std::string& name, std::chrono::minutes age = {}) const {
        fs::create_directory(directory / name);
        spill(directory / name / "000001.mp4", "a segment");
        std::error_code error; // of MinGW
        fs::last_write_time(directory / name, fs::file_time_type::clock::now() - age, error);
        return !error;
    }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(directory.path()))
            all.push_back(entry.path().filename().string());
        std::sort(all.begin(), all.end());
        return all;
    }
    const std::string here = hostName();
};

TEST_F(WorkFolderTest, IsRemovedUnlessItIsFinished) {
    { const WorkFolder work(directory / "000007"); }
    EXPECT_TRUE(names().empty());
    {
        WorkFolder work(directory / "000007");
        EXPECT_TRUE(startsWith(work.path().filename().string(), "000007." + here + "-"));
        spill(work.path() / "chunk.json", "{}");
        EXPECT_TRUE(work.finish());
    }
    EXPECT_EQ(names(), std::vector<std::string>{"000007"});
    WorkFolder second(directory / "000007");
    EXPECT_FALSE(second.finish());
    second.moveAway();
    EXPECT_TRUE(second.finish());
    EXPECT_TRUE(fs::is_empty(directory / "000007"));
}

TEST_F(WorkFolderTest, WhatKilledProcessesLeftIsRemoved) {
    using std::chrono::minutes;
    const std::string& ended = kEnded;
    const std::string living = std::to_string(getpid());
    const std::vector<std::string> kept = {
        "000007",                               // a chunk
        "000007." + here + "-" + living + "-1", // of a process that runs
        "000007.elsewhere-" + ended + "-1",     // of a machine that may be at work
        "000007.else-where.org-" + ended + "-2",
        "000008." + here + "-" + ended + "-1", // of another chunk
        "000007." + here + "-" + ended,        // not of the form
        "000007." + here + "-" + ended + "-x",
        "notes." + here + "-" + ended + "-1",
    };
    const std::vector<std::string> stale = {
        "000007." + here + "-" + ended + "-1",
        "000007." + here + "-" + ended + "-2-old",
    };
    const std::vector<std::string> old = {"000007.elsewhere-" + ended + "-3",
                                          "000007." + here + "-" + living + "-3"};
    for (const std::string& name : kept)
        makeFolder(name, minutes(name == "000007.elsewhere-" + ended + "-1" ? 58 : 0));
    for (const std::string& name : stale)
        makeFolder(name);
    for (const std::string& name : old)
        if (!makeFolder(name, minutes(62))) fs::remove_all(directory / name);
    {
        const WorkFolder work(directory / "000007");
        work.removeStale("000007");
        EXPECT_TRUE(fs::exists(work.path()));
    }
    std::vector<std::string> expected = kept;
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(names(), expected);
    WorkFolder(directory / "join").removeStale({}); // of all chunks
    expected.erase(
        std::find(expected.begin(), expected.end(), "000008." + here + "-" + ended + "-1"));
    EXPECT_EQ(names(), expected);
}

} // namespace
} // namespace altiro3D::test
