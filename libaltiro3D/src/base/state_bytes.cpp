#include "base/state_bytes.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15; // odd, with well-mixed bits

std::uint64_t wordAt(const char* bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

} // namespace

std::uint64_t mixIn(std::uint64_t sum, std::uint64_t value) {
    sum = (sum ^ value) * kFactor;
    return sum ^ sum >> 29U;
}

// Reads the bytes once into four sums; multiplications limit the speed to about 8 bytes a cycle.
std::uint64_t checksum(std::string_view bytes) {
    std::array<std::uint64_t, 4> sums{1, 2, 3, 4};
    constexpr std::size_t kWord = sizeof(std::uint64_t);
    constexpr std::size_t kBlock = kWord * 4;
    const std::uint64_t size = bytes.size();
    while (bytes.size() >= kBlock) {
        for (std::size_t i = 0; i < sums.size(); ++i)
            sums[i] = mixIn(sums[i], wordAt(bytes.data() + i * kWord));
        bytes.remove_prefix(kBlock);
    }
    std::array<char, kBlock> rest{};
    std::copy(bytes.begin(), bytes.end(), rest.begin());
    std::uint64_t total = size;
    for (std::size_t i = 0; i < sums.size(); ++i)
        total = mixIn(total, mixIn(sums[i], wordAt(rest.data() + i * kWord)));
    return total;
}

Error damagedState() {
    return {ErrorCode::BadFormat, "state", "is damaged, expected the state of an earlier run"};
}

void append(std::string& bytes, std::uint64_t value) {
    std::array<char, sizeof value> text{};
    std::memcpy(text.data(), &value, sizeof value);
    bytes.append(text.data(), text.size());
}

void append(std::string& bytes, const cv::Mat& picture) {
    append(bytes, static_cast<std::uint64_t>(picture.rows));
    append(bytes, static_cast<std::uint64_t>(picture.cols));
    const std::size_t rowBytes = static_cast<std::size_t>(picture.cols) * picture.elemSize();
    for (int y = 0; y < picture.rows; ++y)
        bytes.append(reinterpret_cast<const char*>(picture.ptr(y)), rowBytes);
}

bool take(std::string_view& bytes, std::uint64_t& value) {
    if (bytes.size() < sizeof value) return false;
    value = wordAt(bytes.data());
    bytes.remove_prefix(sizeof value);
    return true;
}

bool take(std::string_view& bytes, int type, cv::Mat& picture) {
    std::uint64_t rows = 0;
    std::uint64_t cols = 0;
    if (!take(bytes, rows) || !take(bytes, cols)) return false;
    picture = cv::Mat();
    if (rows == 0 && cols == 0) return true;
    constexpr std::uint64_t kMax = 1U << 20U;
    const std::uint64_t size = rows * cols * static_cast<std::uint64_t>(CV_ELEM_SIZE(type));
    if (rows == 0 || cols == 0 || rows > kMax || cols > kMax || size > bytes.size()) return false;
    picture.create(static_cast<int>(rows), static_cast<int>(cols), type);
    std::memcpy(picture.data, bytes.data(), size);
    bytes.remove_prefix(size);
    return true;
}

} // namespace altiro3D
