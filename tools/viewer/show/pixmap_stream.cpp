#include "viewer/show/pixmap_stream.hpp"

#include "altiro3D/error.hpp"

#include <cctype>
#include <opencv2/imgproc.hpp>

namespace altiro3D::viewer {

namespace {

constexpr int kMaxSide = 16384;

[[noreturn]] void fail() {
    throw Error(ErrorCode::BadFormat, "standard input",
                "holds something else, expected whole pictures (PPM of 8 bits, P6)");
}

// A number of the head and the character after it.
int readNumber(std::FILE& file) {
    int next = std::fgetc(&file);
    while (std::isspace(next) != 0)
        next = std::fgetc(&file);
    int number = 0;
    for (; std::isdigit(next) != 0 && number <= kMaxSide; next = std::fgetc(&file))
        number = 10 * number + next - '0';
    if (number < 1 || number > kMaxSide || std::isspace(next) == 0) fail();
    return number;
}

} // namespace

bool readPixmap(std::FILE& file, cv::Mat& picture) {
    const int first = std::fgetc(&file);
    if (first == EOF) return false;
    if (first != 'P' || std::fgetc(&file) != '6') fail();
    const int width = readNumber(file);
    const int height = readNumber(file);
    if (readNumber(file) != 255) fail();
    picture = cv::Mat(height, width, CV_8UC3);
    const std::size_t bytes = picture.total() * picture.elemSize();
    if (std::fread(picture.data, 1, bytes, &file) != bytes) fail();
    cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
    return true;
}

} // namespace altiro3D::viewer
