#include "base/checks.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"

#include <gtest/gtest.h>
#include <set>

namespace altiro3D::test {
namespace {

enum class Letter { A, B, C };
static_assert(enumCount<Letter>() == 3 && enumCount<ErrorCode>() == 10);
constexpr char kLetters[] = {'a', 'b', 'c'};
static_assert(entryOf(kLetters, Letter::C) == 'c');

std::set<const uchar*> bytesOf(const cv::Mat& picture) {
    std::set<const uchar*> bytes;
    for (int y = 0; y < picture.rows; ++y) {
        const uchar* const row = picture.ptr(y);
        for (std::size_t i = 0; i < picture.elemSize() * static_cast<std::size_t>(picture.cols);
             ++i)
            bytes.insert(row + i);
    }
    return bytes;
}

TEST(Error, NamesItsSubject) {
    const Error error(ErrorCode::NotFound, "a: b\n\xc2\x85.png", "does not exist: no such file");
    EXPECT_EQ(error.subject(), "a: b  .png");
    EXPECT_STREQ(error.what(), "a: b  .png: does not exist: no such file");
}

TEST(Error, EachCodeHasItsName) {
    EXPECT_STREQ(errorCodeName(ErrorCode::InvalidArgument), "InvalidArgument");
    EXPECT_STREQ(errorCodeName(ErrorCode::BadFormat), "BadFormat");
    EXPECT_STREQ(errorCodeName(ErrorCode::Mismatch), "Mismatch");
    EXPECT_STREQ(errorCodeName(ErrorCode::NetworkFailed), "NetworkFailed");
}

TEST(ShareMemory, RegionsShareItExactlyIfTheyHaveBytesInCommon) {
    const cv::Mat canvas(7, 12, CV_8UC3);
    const cv::Mat views[] = {canvas, canvas.reshape(1), canvas.reshape(3, 14), canvas.row(3)};
    cv::RNG rng(4);
    const auto region = [&] {
        const cv::Mat& view = views[rng.uniform(0, 4)];
        const int x = rng.uniform(0, view.cols);
        const int y = rng.uniform(0, view.rows);
        return view(cv::Rect(x, y, std::min(rng.uniform(1, 9), view.cols - x),
                             std::min(rng.uniform(1, 4), view.rows - y)));
    };
    int shared = 0;
    for (int i = 0; i < 3000; ++i) {
        const cv::Mat a = region();
        const cv::Mat b = region();
        const std::set<const uchar*> bytes = bytesOf(a);
        const std::set<const uchar*> others = bytesOf(b);
        const bool expected = std::any_of(
            bytes.begin(), bytes.end(), [&](const uchar* byte) { return others.count(byte) > 0; });
        EXPECT_EQ(shareMemory(a, b), expected) << i;
        shared += expected ? 1 : 0;
    }
    EXPECT_GT(shared, 300);
    EXPECT_LT(shared, 2700);
    EXPECT_FALSE(shareMemory(canvas, canvas.clone()));
    EXPECT_FALSE(shareMemory(canvas, cv::Mat()));
}

} // namespace
} // namespace altiro3D::test
