#include "base/checks.hpp"
#include "base/owned.hpp"
#include "base/pixel_rows.hpp"
#include "base/srgb_light.hpp"
#include "image/colour.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <lcms2.h>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

using Chromaticities = std::array<double, 8>; // x and y of white, red, green, blue

constexpr Chromaticities kSrgb = {0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
constexpr Chromaticities kRec2020 = {0.3127, 0.3290, 0.708, 0.292, 0.170, 0.797, 0.131, 0.046};
constexpr Chromaticities kDisplayP3 = {0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
constexpr Chromaticities kDciP3 = {0.314, 0.351, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
constexpr Chromaticities kRec601Pal = {0.3127, 0.3290, 0.64, 0.33, 0.29, 0.60, 0.15, 0.06};
constexpr Chromaticities kRec601Ntsc = {0.3127, 0.3290, 0.630, 0.340, 0.310, 0.595, 0.155, 0.070};
constexpr double kUsualGamma = 0.45455; // PNG's gAMA beside sRGB, and taken as sRGB
constexpr int kMaxSameLevels = 2;       // levels of 255 by which equal profiles may differ

constexpr int kPq = 16;
constexpr int kHlg = 18;

using Profile = std::unique_ptr<void, Free<cmsCloseProfile>>;
using Transform = std::unique_ptr<void, Free<cmsDeleteTransform>>;
using Curve = std::unique_ptr<cmsToneCurve, Free<cmsFreeToneCurve>>;

Chromaticities chromaticitiesOf(int primaries) {
    return primaries == 5                     ? kRec601Pal
           : primaries == 6 || primaries == 7 ? kRec601Ntsc
           : primaries == 9                   ? kRec2020
           : primaries == 11                  ? kDciP3
           : primaries == 12                  ? kDisplayP3
                                              : kSrgb;
}

// exponent: of the decoding; 0 = that of sRGB
Curve curveOf(double exponent) {
    if (exponent > 0) return Curve(cmsBuildGamma(nullptr, exponent));
    const double srgb[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    return Curve(cmsBuildParametricToneCurve(nullptr, 4, srgb));
}

Profile profileOf(const Chromaticities& c, double exponent) {
    for (std::size_t i = 1; i < 8; i += 2) { // the blue of ACES has a y below 0
        const double y = i == 1 ? c[i] : std::abs(c[i]);
        if (!(y > 0.001) || !(c[i - 1] >= 0) || !(y + c[i - 1] <= 1.5)) return nullptr;
    }
    const cmsCIExyY white{c[0], c[1], 1};
    const cmsCIExyYTRIPLE primaries{{c[2], c[3], 1}, {c[4], c[5], 1}, {c[6], c[7], 1}};
    const Curve curve = curveOf(exponent);
    if (!curve) return nullptr;
    cmsToneCurve* const curves[3] = {curve.get(), curve.get(), curve.get()};
    return Profile(cmsCreateRGBProfile(&white, &primaries, curves));
}

} // namespace

std::vector<unsigned char> srgbProfile() {
    const Profile profile(cmsCreate_sRGBProfile());
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(profile.get(), nullptr, &size);
    std::vector<unsigned char> bytes(size);
    cmsSaveProfileToMem(profile.get(), bytes.data(), &size);
    constexpr unsigned char kDate[] = {7, 208, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0}; // fixed, not today's
    std::copy(std::begin(kDate), std::end(kDate), bytes.begin() + 24);
    return bytes;
}

namespace {

// The exponent of H.273's transfer characteristics; videos are treated as sRGB, as usual.
double exponentOf(int transfer) {
    return transfer == 4 ? 2.2 : transfer == 5 ? 2.8 : transfer == 8 ? 1 : 0;
}

Transform transformOf(const Profile& from, cmsUInt32Number input, cmsUInt32Number output,
                      cmsUInt32Number flags = 0) {
    const Profile srgb(cmsCreate_sRGBProfile());
    // without a cache, threads may share a transform
    return Transform(
        cmsCreateTransform(from.get(), input, srgb.get(), output, INTENT_RELATIVE_COLORIMETRIC,
                           cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_NOCACHE | flags));
}

// Whether a transform leaves a grid of colours nearly as they are.
bool changesLittle(const Profile& profile, bool isGrey) {
    const int steps = isGrey ? 52 : 9;
    std::vector<std::uint8_t> from;
    std::vector<std::uint8_t> wanted;
    const int count = isGrey ? steps : steps * steps * steps;
    for (int i = 0; i < count; ++i) {
        const auto level = [&](int index) {
            return static_cast<std::uint8_t>(index % steps * 255 / (steps - 1));
        };
        const std::uint8_t colour[3] = {level(i), isGrey ? level(i) : level(i / steps),
                                        isGrey ? level(i) : level(i / steps / steps)};
        wanted.insert(wanted.end(), colour, colour + 3);
        from.insert(from.end(), colour, colour + (isGrey ? 1 : 3));
    }
    const Transform transform = transformOf(profile, isGrey ? TYPE_GRAY_8 : TYPE_BGR_8, TYPE_BGR_8);
    if (!transform) return true;
    std::vector<std::uint8_t> to(wanted.size());
    cmsDoTransform(transform.get(), from.data(), to.data(), static_cast<cmsUInt32Number>(count));
    for (std::size_t i = 0; i < to.size(); ++i) {
        if (std::abs(int{to[i]} - int{wanted[i]}) > kMaxSameLevels) return false;
    }
    return true;
}

// Converts all rows on all threads to a depth. Empty if the profile cannot be used.
cv::Mat converted(const cv::Mat& picture, const Profile& profile, cmsUInt32Number input,
                  int depth) {
    const cmsUInt32Number output = depth == CV_32F   ? TYPE_BGR_FLT
                                   : depth == CV_16U ? TYPE_BGR_16
                                                     : TYPE_BGR_8;
    const Transform transform = transformOf(profile, input, output);
    if (!transform) return {};
    cv::Mat result(picture.size(), CV_MAKETYPE(depth, 3));
    cv::parallel_for_(cv::Range(0, picture.rows), [&](const cv::Range& rows) {
        cmsDoTransformLineStride(transform.get(), picture.ptr(rows.start), result.ptr(rows.start),
                                 static_cast<cmsUInt32Number>(picture.cols),
                                 static_cast<cmsUInt32Number>(rows.size()),
                                 static_cast<cmsUInt32Number>(picture.step[0]),
                                 static_cast<cmsUInt32Number>(result.step[0]), 0, 0);
    });
    return result;
}

// NaN becomes 0, and infinite values become the largest half float.
float finite(float value) {
    constexpr float kLargest = 65504;
    return std::isnan(value) ? 0 : std::clamp(value, -kLargest, kLargest);
}

Profile profileOf(std::string_view icc) {
    return Profile(cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
}

// (1 - ink) (1 - black)
cv::Mat usualColours(const cv::Mat& inks, bool isInverted) {
    cv::Mat colours(inks.size(), CV_8UC3);
    const int invert = isInverted ? 0 : 255;
    for (int y = 0; y < inks.rows; ++y) {
        const std::uint8_t* from = inks.ptr(y);
        std::uint8_t* to = colours.ptr(y);
        for (int x = 0; x < inks.cols; ++x, from += 4, to += 3) {
            for (int c = 0; c < 3; ++c) // yellow takes blue
                to[c] = static_cast<std::uint8_t>(
                    ((from[2 - c] ^ invert) * (from[3] ^ invert) + 127) / 255);
        }
    }
    return colours;
}

void convertByProfile(cv::Mat& picture, const Profile& profile, Notes* notes) {
    const bool isGreyProfile = profile && cmsGetColorSpace(profile.get()) == cmsSigGrayData;
    if (!profile || (!isGreyProfile && cmsGetColorSpace(profile.get()) != cmsSigRgbData)) {
        addNote(notes, NoteCode::AsItIs,
                profile ? "the colour profile is not for RGB: the colours are read as sRGB"
                        : "the colour profile is damaged: the colours are read as sRGB");
        return;
    }
    if (isGreyProfile && picture.channels() == 3) return; // the profile is for another picture
    if (changesLittle(profile, isGreyProfile)) return;
    if (!isGreyProfile && picture.channels() == 1)
        cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    constexpr cmsUInt32Number kGrey[] = {TYPE_GRAY_8, TYPE_GRAY_16, TYPE_GRAY_FLT};
    constexpr cmsUInt32Number kColours[] = {TYPE_BGR_8, TYPE_BGR_16, TYPE_BGR_FLT};
    const int depth = picture.depth();
    const int type = depth == CV_8U ? 0 : depth == CV_16U ? 1 : 2;
    if (depth == CV_32F) picture = mapped<float, float>(picture, finite);
    const cv::Mat result =
        converted(picture, profile, isGreyProfile ? kGrey[type] : kColours[type], depth);
    if (result.empty())
        addNote(notes, NoteCode::AsItIs,
                "the colour profile cannot be used: the colours are read as sRGB");
    else
        picture = result;
}

constexpr double kPqPeak = 10000; // cd/m²
constexpr double kHlgPeak = 1000; // cd/m², peak of the display that HLG is shown on
constexpr double kSourcePeak = 1000;
constexpr double kWhite = 203; // cd/m², BT.2408
constexpr double kM1 = 2610.0 / 16384;
constexpr double kM2 = 2523.0 / 4096 * 128;
constexpr double kC1 = 3424.0 / 4096;
constexpr double kC2 = 2413.0 / 4096 * 32;
constexpr double kC3 = 2392.0 / 4096 * 32;

double pqOf(double light) { // cd/m²; BT.2100
    const double y = std::pow(std::max(light, 0.0) / kPqPeak, kM1);
    return std::pow((kC1 + kC2 * y) / (1 + kC3 * y), kM2);
}

double lightOfPq(double value) { // in units of the peak
    const double root = std::pow(value, 1 / kM2);
    return std::pow(std::max(root - kC1, 0.0) / (kC2 - kC3 * root), 1 / kM1);
}

cv::Matx33d toXyz(const Chromaticities& c) {
    const auto column = [&](std::size_t i) {
        return cv::Vec3d(c[i] / c[i + 1], 1, (1 - c[i] - c[i + 1]) / c[i + 1]);
    };
    const cv::Vec3d red = column(2);
    const cv::Vec3d green = column(4);
    const cv::Vec3d blue = column(6);
    const cv::Matx33d primaries(red[0], green[0], blue[0], red[1], green[1], blue[1], red[2],
                                green[2], blue[2]);
    const cv::Vec3d share = primaries.inv() * column(0);
    return primaries * cv::Matx33d::diag(share);
}

constexpr int kSteps = 65536;
using Table = std::vector<float>;

template <class Function>
Table tableOf(const Function& function) {
    Table table(kSteps);
    for (int i = 0; i < kSteps; ++i)
        table[static_cast<std::size_t>(i)] = static_cast<float>(function(i / (kSteps - 1.0)));
    return table;
}

float looked(const Table& table, float share) {
    const float inRange = share > 0 ? (share < 1 ? share : 1.0F) : 0.0F;
    return table[static_cast<std::size_t>(inRange * (kSteps - 1) + 0.5F)];
}

// Reads encoded px, writes sRGB px; bound by the look-ups, some 20 a px.
class ToneMapper {
  public:
    ToneMapper(int primaries, int transfer)
        : isHlg_(transfer == kHlg),
          toSrgb_(toXyz(kSrgb).inv() * toXyz(chromaticitiesOf(primaries))),
          luminance_(cv::Matx33f(toXyz(chromaticitiesOf(primaries))).row(1)),
          linear_(tableOf([&](double v) { return linearLight(v, transfer); })),
          // light is looked up by its square root, which spends more steps on the dark
          system_(tableOf([](double root) { return std::pow(root * root, 0.2); })),
          factor_(tableOf([](double root) {
              const double light = root * root * kPqPeak;
              return light > 0 ? toneMapped(light) / light * kPqPeak / kWhite : kPqPeak / kWhite;
          })),
          encoded_(tableOf([](double root) { return srgbOf(root * root); })) {}

    template <typename T>
    void row(const T* from, T* to, int columns) const {
        constexpr float kLargest = sizeof(T) == 1 ? 255.0F : 65535.0F;
        constexpr std::size_t kStep = sizeof(T) == 1 ? 257 : 1;
        for (int x = 0; x < columns; ++x, from += 3, to += 3) {
            float r = linear_[from[2] * kStep];
            float g = linear_[from[1] * kStep];
            float b = linear_[from[0] * kStep];
            if (isHlg_) { // BT.2100: the display's light is L^(gamma - 1) times the scene's
                const float y = luminance_(0) * r + luminance_(1) * g + luminance_(2) * b;
                const float system =
                    looked(system_, std::sqrt(y)) * static_cast<float>(kHlgPeak / kPqPeak);
                r *= system;
                g *= system;
                b *= system;
            }
            const float factor = looked(factor_, std::sqrt(std::max({r, g, b})));
            const cv::Vec3f light(r * factor, g * factor, b * factor);
            for (int c = 0; c < 3; ++c) {
                const float value = toSrgb_(2 - c, 0) * light[0] + toSrgb_(2 - c, 1) * light[1] +
                                    toSrgb_(2 - c, 2) * light[2];
                to[c] = static_cast<T>(
                    looked(encoded_, std::sqrt(std::max(value, 0.0F))) * kLargest + 0.5F);
            }
        }
    }

  private:
    bool isHlg_;
    cv::Matx33f toSrgb_;
    cv::Matx13f luminance_;
    Table linear_;
    Table system_;
    Table factor_;
    Table encoded_;
};

void toneMap(cv::Mat& picture, int primaries, int transfer) {
    if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    const ToneMapper mapper(primaries, transfer);
    cv::Mat result(picture.size(), picture.type());
    overRows(picture.rows, [&](int y) {
        if (picture.depth() == CV_8U) {
            mapper.row(picture.ptr<std::uint8_t>(y), result.ptr<std::uint8_t>(y), picture.cols);
        } else {
            mapper.row(picture.ptr<std::uint16_t>(y), result.ptr<std::uint16_t>(y), picture.cols);
        }
    });
    picture = result;
}

} // namespace

bool isCmykProfile(std::string_view icc) {
    const Profile profile = profileOf(icc);
    return profile && cmsGetColorSpace(profile.get()) == cmsSigCmykData;
}

cv::Mat inksToSrgb(const cv::Mat& inks, const std::string& icc, bool isInverted) {
    if (icc.empty()) return usualColours(inks, isInverted);
    return converted(inks, profileOf(icc), isInverted ? TYPE_CMYK_8_REV : TYPE_CMYK_8, CV_8U);
}

cv::Mat labToSrgb(const cv::Mat& lab) {
    return converted(lab, Profile(cmsCreateLab4Profile(nullptr)), TYPE_Lab_FLT, CV_16U);
}

cv::Mat xyzToRgb(const cv::Mat& light) {
    const cv::Matx33d toRgb = toXyz(kSrgb).inv();
    const cv::Matx33d toBgr = cv::Matx33d(0, 0, 1, 0, 1, 0, 1, 0, 0) * toRgb;
    cv::Mat rgb;
    cv::transform(light, rgb, toBgr);
    return rgb;
}

double linearLight(double value, int transfer) {
    if (transfer == kPq) return lightOfPq(value);
    constexpr double kA = 0.17883277;
    constexpr double kB = 1 - 4 * kA;
    const double c = 0.5 - kA * std::log(4 * kA);
    return value <= 0.5 ? value * value / 3 : (std::exp((value - c) / kA) + kB) / 12;
}

cv::Matx33d toSrgbLight(int primaries) {
    const cv::Matx33d matrix = toXyz(kSrgb).inv() * toXyz(chromaticitiesOf(primaries));
    const cv::Vec3d white = matrix * cv::Vec3d::all(1);
    return cv::Matx33d::diag({1 / white[0], 1 / white[1], 1 / white[2]}) * matrix;
}

double toneMapped(double light) {
    const double peak = pqOf(kSourcePeak);
    const double largest = pqOf(kWhite) / peak;
    const double knee = 1.5 * largest - 0.5;
    const double e = std::min(pqOf(light) / peak, 1.0);
    if (e < knee) return light;
    const double t = (e - knee) / (1 - knee);
    const double mapped = (2 * t * t * t - 3 * t * t + 1) * knee +
                          (t * t * t - 2 * t * t + t) * (1 - knee) +
                          (-2 * t * t * t + 3 * t * t) * largest;
    return lightOfPq(mapped * peak) * kPqPeak;
}

void convertToSrgb(cv::Mat& picture, const ColourFacts& facts, Notes* notes) {
    const int depth = picture.depth();
    if (picture.empty() || (depth != CV_8U && depth != CV_16U && depth != CV_32F)) return;
    if (facts.code) {
        const int transfer = facts.code->transfer;
        if (transfer == kPq || transfer == kHlg) {
            toneMap(picture, facts.code->primaries, transfer);
            addNote(notes, NoteCode::Converted,
                    std::string("the picture is HDR (") + (transfer == kPq ? "PQ" : "HLG") +
                        "): its bright parts are compressed");
            return;
        }
        const bool isSrgb = facts.code->primaries <= 2 && exponentOf(transfer) <= 0;
        if (isSrgb) return;
        convertByProfile(picture,
                         profileOf(chromaticitiesOf(facts.code->primaries), exponentOf(transfer)),
                         notes);
    } else if (!facts.icc.empty()) {
        convertByProfile(picture, profileOf(facts.icc), notes);
    } else if (!facts.isSrgb && (facts.gamma > 0 || facts.chromaticities)) {
        const bool isUsual = facts.gamma <= 0 || std::abs(facts.gamma / kUsualGamma - 1) < 0.01;
        if (!isUsual && (facts.gamma < 0.1 || facts.gamma > 10)) return;
        const double exponent = isUsual ? 0 : 1 / facts.gamma;
        Profile profile = profileOf(facts.chromaticities.value_or(kSrgb), exponent);
        if (!profile) {
            addNote(notes, NoteCode::AsItIs,
                    "the primaries that the file states are damaged: those of sRGB are used");
            profile = profileOf(kSrgb, exponent);
        }
        convertByProfile(picture, profile, notes);
    }
}

} // namespace altiro3D
