#pragma once

#include "altiro3D/error.hpp" // IWYU pragma: export
#include "base/text.hpp"      // IWYU pragma: export

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <new>
#include <opencv2/core.hpp>
#include <string>

/// Checks of the arguments of image functions, errors and remarks.
namespace altiro3D {

/// Throws InvalidArgument unless the condition holds.
inline void check(bool condition, const char* subject, const std::string& problem) {
    if (!condition) throw Error(ErrorCode::InvalidArgument, subject, problem);
}

/// Throws InvalidArgument with the value ("is 1.5, expected 0..1") unless the condition holds.
inline void checkNumber(bool condition, const std::string& field, double value,
                        const std::string& expected) {
    if (condition) return;
    throw Error(ErrorCode::InvalidArgument, field,
                "is " + numberText(value) + ", expected " + expected);
}

/// Throws InvalidArgument ("is 1.5, expected 0..1 px") unless the value is within the limits.
inline void checkRange(const std::string& field, double value, double low, double high,
                       const std::string& unit = {}) {
    checkNumber(value >= low && value <= high, field, value,
                numberText(low) + ".." + numberText(high) + unit);
}

/// Throws InvalidArgument if a function that the caller gives is empty.
template <class Signature>
void checkFunction(const std::function<Signature>& function, const char* subject) {
    check(static_cast<bool>(function), subject, "is empty, expected a function");
}

/// "is 640 x 480 px of CV_8UC3"
inline std::string shapeText(const cv::Mat& picture) {
    if (picture.empty()) return "is empty";
    if (picture.dims != 2) return "has " + std::to_string(picture.dims) + " dimensions";
    return "is " + sizeText(picture.size()) + " of " + cv::typeToString(picture.type());
}

/// Throws InvalidArgument unless the picture has at least one px and one of the types.
inline void checkType(const cv::Mat& picture, std::initializer_list<int> types, const char* subject,
                      const char* expected) {
    const bool fits = !picture.empty() && picture.dims == 2 &&
                      std::find(types.begin(), types.end(), picture.type()) != types.end();
    check(fits, subject, shapeText(picture) + ", expected " + expected);
}

/// Throws Mismatch unless a picture has the expected size.
/// @param whose "the photo's ", for the message
inline void checkSize(cv::Size size, cv::Size expected, const std::string& subject,
                      const std::string& whose = {}) {
    if (size == expected) return;
    throw Error(ErrorCode::Mismatch, subject,
                "has " + sizeText(size) + ", expected " + whose + sizeText(expected));
}

/// Throws unless photo and depth (or distance) have the same size and views can be made of it.
/// @param subject "depth" or "distance"
/// @param expected the type of `depth`, for the message
inline void checkPhotoAndDepth(const cv::Mat& photo, const cv::Mat& depth, const char* subject,
                               const char* expected) {
    constexpr int kMaxViewSide = 32766; // cv::remap's limit
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkType(depth, {CV_32FC1}, subject, expected);
    checkSize(depth.size(), photo.size(), subject, "the photo's ");
    if (photo.cols > kMaxViewSide || photo.rows > kMaxViewSide) {
        throw Error(ErrorCode::TooLarge, "photo",
                    "has " + sizeText(photo.size()) + ", expected at most 32766 px a side");
    }
}

/// Whether two pictures have bytes in common. Disjoint regions of one canvas have none, although
/// their rows alternate in memory.
inline bool shareMemory(const cv::Mat& a, const cv::Mat& b) {
    if (a.empty() || b.empty()) return false;
    struct Rows { // more than two dimensions count as one row
        explicit Rows(const cv::Mat& m)
            : count(m.dims > 2 ? 1 : m.rows), step(static_cast<std::ptrdiff_t>(m.step[0])),
              bytes(m.dims > 2 ? m.dataend - m.data
                               : static_cast<std::ptrdiff_t>(m.elemSize()) * m.cols) {}
        std::ptrdiff_t count, step, bytes;
    };
    const Rows rows(a);
    const Rows others(b);
    const std::less<> before; // defined also for pointers into different pictures
    for (std::ptrdiff_t y = 0; y < rows.count; ++y) {
        const uchar* const begin = a.data + y * rows.step;
        const uchar* const end = begin + rows.bytes;
        if (!before(b.data, end)) continue;
        // the last row of b that begins before the end
        const std::ptrdiff_t last = std::min((end - 1 - b.data) / others.step, others.count - 1);
        if (before(begin, b.data + last * others.step + others.bytes)) return true;
    }
    return false;
}

/// Throws InvalidArgument if a result is an input of the same call or shares memory with it. Call
/// it before the result is allocated, which could release an input's memory.
/// @param subject name of the result
/// @param inputName name of the input, for example "photo"
inline void checkApart(const cv::Mat& result, const cv::Mat& input, const char* subject,
                       const char* inputName) {
    check(&result != &input && !shareMemory(result, input), subject,
          std::string("shares its memory with the ") + inputName +
              ", expected a picture of its own");
}

/// Runs `work`; a failed allocation, in the language or OpenCV, becomes Error OutOfMemory.
/// @param subject file or argument for the error
/// @param problem "does not fit into memory, expected ..."
/// @param work called once
/// @return the result of `work`
template <class Work>
auto orOutOfMemory(const std::string& subject, const std::string& problem, const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::OutOfMemory, subject, problem);
    } catch (const cv::Exception& exception) {
        if (exception.code != cv::Error::StsNoMem) throw;
        throw Error(ErrorCode::OutOfMemory, subject, problem);
    }
}

/// For the end of a public function: converts OpenCV's exception to one that may leave the library.
/// @throws std::bad_alloc; Error InvalidArgument for what our own checks have missed
[[noreturn]] inline void leaveAsOurs(const cv::Exception& exception) {
    if (exception.code == cv::Error::StsNoMem) throw std::bad_alloc();
    throw Error(ErrorCode::InvalidArgument, "OpenCV",
                exception.func + ": " + exception.err +
                    ", expected pictures that it can work with");
}

/// orOutOfMemory() for a picture file.
template <class Work>
auto withinMemory(const std::filesystem::path& file, const Work& work) {
    return orOutOfMemory(file.string(), "does not fit into memory, expected a smaller picture",
                         work);
}

/// Adds a remark for a caller who wants remarks.
inline void addNote(Notes* notes, NoteCode code, const std::string& text) {
    if (notes != nullptr) notes->push_back({code, text});
}
inline void addNotes(Notes* notes, const Notes& more) {
    if (notes != nullptr) notes->insert(notes->end(), more.begin(), more.end());
}

/// Begins each remark with the name of a file.
inline void putNameBefore(Notes& notes, const std::filesystem::path& file) {
    for (Note& note : notes)
        note.text = file.string() + ": " + note.text;
}

/// Calls a reader, and begins each of its remarks with the name of its file.
/// @param read takes `Notes*`
template <class Read>
auto withNamedNotes(const std::filesystem::path& file, Notes* notes, const Read& read) {
    Notes own;
    auto result = read(&own);
    putNameBefore(own, file);
    addNotes(notes, own);
    return result;
}

} // namespace altiro3D
