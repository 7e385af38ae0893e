#include "altiro3D/stereo_views.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/enum_table.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/srgb_light.hpp"
#include "image/picture_halves.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

constexpr EyesPictureName kNames[] = {
    {"sbs", "side by side", "LRF"},
    {"sbs-half", "side by side, half width", "HSBS"},
    {"cross", "crossed eyes", "RLF"},
    {"tb", "top and bottom", "TBF"},
    {"tb-half", "top and bottom, half height", "HTAB"},
    {"anaglyph", "red-cyan anaglyph", "anaglyph"},
    {"anaglyph-half", "red-cyan anaglyph, half colour", "anaglyph"},
    {"anaglyph-grey", "red-cyan anaglyph, grey", "anaglyph"},
    {"rows", "interlaced rows", ""},
    {"columns", "interlaced columns", ""},
    {"checkerboard", "a checkerboard of px", ""},
};

// Where the picture of an eye lies in one of whole or half pictures. @param index 0: the first one
cv::Rect placeOf(cv::Size joined, bool isBeside, int index) {
    const cv::Size half = isBeside ? cv::Size(joined.width / 2, joined.height)
                                   : cv::Size(joined.width, joined.height / 2);
    return {isBeside ? index * half.width : 0, isBeside ? 0 : index * half.height, half.width,
            half.height};
}

// Light of red, green and blue through each of the filters, E. Dubois 2001 (CRT primaries).
constexpr std::array<std::array<float, 3>, 3> kDuboisLeft{
    {{0.437F, 0.449F, 0.164F}, {-0.062F, -0.062F, -0.024F}, {-0.048F, -0.050F, -0.017F}}};
constexpr std::array<std::array<float, 3>, 3> kDuboisRight{
    {{-0.011F, -0.032F, -0.007F}, {0.377F, 0.761F, 0.009F}, {-0.026F, -0.093F, 1.234F}}};

float through(const std::array<float, 3>& filter, const std::uint8_t* bgr, const SrgbLight& srgb) {
    const float light = filter[0] * srgb.ofCode(bgr[2]) + filter[1] * srgb.ofCode(bgr[1]) +
                        filter[2] * srgb.ofCode(bgr[0]);
    return std::clamp(light, 0.0F, 1.0F);
}

void duboisPixel(const std::uint8_t* left, const std::uint8_t* right, std::uint8_t* out) {
    const SrgbLight& srgb = SrgbLight::instance();
    for (std::size_t c = 0; c < 3; ++c) {
        out[2 - c] =
            srgb.code(through(kDuboisLeft[c], left, srgb) + through(kDuboisRight[c], right, srgb));
    }
}

// Luma of ITU-R BT.601.
std::uint8_t grey(const std::uint8_t* bgr) {
    return static_cast<std::uint8_t>((299 * bgr[2] + 587 * bgr[1] + 114 * bgr[0] + 500) / 1000);
}

void halfColourPixel(const std::uint8_t* left, const std::uint8_t* right, std::uint8_t* out) {
    out[0] = right[0];
    out[1] = right[1];
    out[2] = grey(left);
}

void greyPixel(const std::uint8_t* left, const std::uint8_t* right, std::uint8_t* out) {
    out[0] = out[1] = grey(right);
    out[2] = grey(left);
}

template <class Pixel>
void joinPixels(const cv::Mat& left, const cv::Mat& right, const Pixel& pixel, cv::Mat& joined) {
    overRows(left.rows, [&](int y) {
        const auto* const l = left.ptr<std::uint8_t>(y);
        const auto* const r = right.ptr<std::uint8_t>(y);
        auto* const out = joined.ptr<std::uint8_t>(y);
        for (int x = 0; x < 3 * left.cols; x += 3)
            pixel(l + x, r + x, out + x);
    });
}

// Each px is that of one eye. Reads and writes 3 bytes per px; memory limits the speed.
void interlace(const cv::Mat& left, const cv::Mat& right, EyesPicture picture, cv::Mat& joined) {
    const int across = picture == EyesPicture::Rows ? 0 : 1;
    const int down = picture == EyesPicture::Columns ? 0 : 1;
    overRows(left.rows, [&](int y) {
        const std::uint8_t* const eyes[] = {left.ptr(y), right.ptr(y)};
        std::uint8_t* const out = joined.ptr(y);
        for (int x = 0; x < left.cols; ++x)
            std::memcpy(out + 3 * x, eyes[(across * x + down * y) % 2] + 3 * x, 3);
    });
}

} // namespace

EyesPictureName nameOf(EyesPicture picture) {
    return entryOf(kNames, picture);
}

bool hasEyesTag(const std::filesystem::path& file, EyesPicture picture) {
    const std::string tag = nameOf(picture).tag;
    if (tag.empty()) return true;
    if (tag == "anaglyph") {
        const std::string stem = lowerCase(file.stem().string());
        return stem.find(tag) != std::string::npos || stem.find("redcyan") != std::string::npos;
    }
    const auto found = parseSceneName(file);
    const auto usual = parseSceneName("x_" + tag);
    if (!found || found->contents != SceneName::Contents::Eyes || found->layout != usual->layout)
        return false;
    const bool isHalf =
        picture == EyesPicture::SideBySideHalf || picture == EyesPicture::TopBottomHalf;
    return found->halves == StereoHalves::Automatic ||
           (found->halves == StereoHalves::Squeezed) == isHalf;
}

std::optional<EyesPicture> eyesPictureOf(StereoLayout layout, StereoHalves halves, cv::Size whole) {
    const bool isHalf = squeezeOf(whole, liesBeside(layout), halves) != Squeeze::None;
    switch (layout) {
    case StereoLayout::LeftRight:
        return isHalf ? EyesPicture::SideBySideHalf : EyesPicture::SideBySide;
    case StereoLayout::TopBottom:
        return isHalf ? EyesPicture::TopBottomHalf : EyesPicture::TopBottom;
    case StereoLayout::RightLeft:
        if (!isHalf) return EyesPicture::Crossed;
        break;
    case StereoLayout::BottomTop:
        break;
    }
    return std::nullopt;
}

cv::Size eyesSize(cv::Size eye, EyesPicture picture) {
    switch (picture) {
    case EyesPicture::SideBySide:
    case EyesPicture::Crossed:
        return {2 * eye.width, eye.height};
    case EyesPicture::SideBySideHalf:
        return {(eye.width + 1) / 2 * 2, eye.height};
    case EyesPicture::TopBottom:
        return {eye.width, 2 * eye.height};
    case EyesPicture::TopBottomHalf:
        return {eye.width, (eye.height + 1) / 2 * 2};
    default:
        return eye;
    }
}

void joinEyes(const cv::Mat& left, const cv::Mat& right, EyesPicture picture, cv::Mat& joined) try {
    checkType(left, {CV_8UC3}, "left", "CV_8UC3 (8-bit BGR)");
    checkType(right, {CV_8UC3}, "right", "CV_8UC3 (8-bit BGR)");
    checkSize(right.size(), left.size(), "right", "the left picture's ");
    checkApart(joined, left, "joined", "left picture");
    checkApart(joined, right, "joined", "right picture");
    const cv::Size size = eyesSize(left.size(), picture);
    orOutOfMemory("joined", "no memory for " + sizeText(size) + ", expected smaller pictures",
                  [&] { joined.create(size, CV_8UC3); });
    switch (picture) {
    case EyesPicture::Anaglyph:
        return joinPixels(left, right, duboisPixel, joined);
    case EyesPicture::AnaglyphHalf:
        return joinPixels(left, right, halfColourPixel, joined);
    case EyesPicture::AnaglyphGrey:
        return joinPixels(left, right, greyPixel, joined);
    case EyesPicture::Rows:
    case EyesPicture::Columns:
    case EyesPicture::Checkerboard:
        return interlace(left, right, picture, joined);
    default:
        break;
    }
    const bool isBeside =
        picture != EyesPicture::TopBottom && picture != EyesPicture::TopBottomHalf;
    const bool isCrossed = picture == EyesPicture::Crossed;
    for (int i = 0; i < 2; ++i) {
        const cv::Mat& eye = (i == 0) != isCrossed ? left : right;
        cv::Mat place = joined(placeOf(size, isBeside, i));
        if (place.size() == eye.size()) {
            eye.copyTo(place);
        } else {
            cv::resize(eye, place, place.size(), 0, 0, cv::INTER_AREA);
        }
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

StereoPair renderEyes(const Scene& scene, const ViewOptions& views, EyesFrom from) try {
    checkScene(scene);
    const cv::Range shown = shownColumns(scene);
    const cv::Size size(shown.size(), scene.photo.rows);
    StereoPair eyes;
    if (from == EyesFrom::KeepLeft) {
        Depth2Quilt({1, 1, size, 1}, views).renderView(scene, 2, eyes.right);
        eyes.left = scene.photo.colRange(shown).clone();
        return eyes;
    }
    const QuiltLayout beside{2, 1, size, 2};
    cv::Mat quilt;
    Depth2Quilt(beside, views).render(scene, quilt);
    eyes.left = quilt(beside.tile(0));
    eyes.right = quilt(beside.tile(1));
    return eyes;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
