#include "altiro3D/video_conversion.hpp"

#include "video/conversion/conversion_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace altiro3D {

struct VideoConverter::Impl : ConversionRun {
    using ConversionRun::ConversionRun;
};

VideoConverter::VideoConverter(VideoConversion conversion)
    : impl_(std::make_unique<Impl>(std::move(conversion))) {}
VideoConverter::~VideoConverter() = default;
VideoConverter::VideoConverter(VideoConverter&&) noexcept = default;
VideoConverter& VideoConverter::operator=(VideoConverter&&) noexcept = default;

const VideoFacts& VideoConverter::facts() const {
    return impl_->reader->facts();
}

cv::Size VideoConverter::size() const {
    return impl_->renderer->size();
}

const VideoProgress& VideoConverter::progress() const {
    return impl_->progress;
}

const Notes& VideoConverter::notes() const {
    static const Notes kNone;
    return impl_->sink ? impl_->sink->notes() : kNone;
}

bool VideoConverter::keepsWork() const {
    return impl_->sink && impl_->sink->keepsWork();
}

VideoConversionResult VideoConverter::run(const VideoProgressFunction& goOn) {
    return impl_->run(goOn);
}

std::string clockText(double seconds) {
    char text[48];
    const auto tenths = std::llround(std::max(seconds, 0.0) * 10);
    const long long hours = tenths / 36000;
    const int minutes = static_cast<int>(tenths / 600 % 60);
    const double rest = static_cast<double>(tenths % 600) / 10;
    if (hours > 0) {
        std::snprintf(text, sizeof text, "%lld:%02d:%04.1f", hours, minutes, rest);
    } else {
        std::snprintf(text, sizeof text, "%d:%04.1f", minutes, rest);
    }
    return text;
}

} // namespace altiro3D
