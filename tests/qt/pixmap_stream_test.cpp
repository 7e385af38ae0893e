#include "viewer/show/presentation.hpp"

#include "altiro3D/error.hpp"

#include <chrono>
#include <future>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {
namespace {

using viewer::readPixmap;

std::string pixmap(int number) { // larger than a block of stdio and of FFmpeg
    std::string text = "P6\n48 32\n255\n";
    for (int i = 0; i < 48 * 32 * 3; ++i)
        text += static_cast<char>((i * 7 + number) % 251);
    return text;
}

// A pipe whose reading end is a file.
struct Pipe {
    Pipe() {
        int ends[2] = {-1, -1};
        if (pipe(ends) != 0) return;
        file = fdopen(ends[0], "rb");
        end = ends[1];
    }
    ~Pipe() {
        finish();
        if (file != nullptr) std::fclose(file);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    void write(const std::string& bytes) const {
        EXPECT_EQ(::write(end, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    }
    void finish() {
        if (end >= 0) close(end);
        end = -1;
    }

    std::FILE* file = nullptr;
    int end = -1;
};

TEST(PixmapStream, APictureIsThereWithItsLastByte) {
    Pipe pipe;
    cv::Mat picture;
    cv::Mat before;
    for (int number = 0; number < 5; ++number) {
        pipe.write(pixmap(number));
        std::promise<void> read;
        bool waits = false;
        std::thread watch([&, isRead = read.get_future()] {
            waits = isRead.wait_for(std::chrono::seconds(20)) != std::future_status::ready;
            if (waits) pipe.write(pixmap(number + 1)); // so that the test ends
        });
        const bool isThere = readPixmap(*pipe.file, picture);
        read.set_value();
        watch.join();
        ASSERT_FALSE(waits) << "waits for the next picture";
        ASSERT_TRUE(isThere);
        ASSERT_EQ(picture.size(), cv::Size(48, 32));
        for (int i = 0; i < 48 * 32 * 3; ++i) {
            const int channel = 2 - i % 3; // red comes first in the file
            ASSERT_EQ(picture.at<cv::Vec3b>(i / 3 / 48, i / 3 % 48)[channel],
                      (i * 7 + number) % 251);
        }
        EXPECT_NE(picture.data, before.data); // its receiver may keep it
        before = picture;
    }
    pipe.finish();
    EXPECT_FALSE(readPixmap(*pipe.file, picture));
}

TEST(PixmapStream, WhatIsNoPictureIsRefused) {
    const std::string whole = pixmap(1);
    for (const std::string& bytes :
         {std::string("P"), std::string("P5\n2 2\n255\nabcd"), std::string("P6\n0 2\n255\n"),
          std::string("P6\n-1 2\n255\n"), std::string("P6\n99999999999999999999 2\n255\n"),
          std::string("P6\n16385 2\n255\n"), std::string("P6\n2 2\n65535\n"),
          std::string("P6\n2x2\n255\n"), whole.substr(0, 9), whole.substr(0, whole.size() - 1)}) {
        Pipe pipe;
        pipe.write(bytes);
        pipe.finish();
        cv::Mat picture;
        EXPECT_THROW(readPixmap(*pipe.file, picture), Error) << bytes.substr(0, 20);
    }
}

} // namespace
} // namespace altiro3D::test
