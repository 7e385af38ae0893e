#pragma once

#include "altiro3D/error.hpp"
#include "base/image_format.hpp"
#include "image/heif_file.hpp"

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// What a picture file states about its colours. A member counts only if none before it is set;
/// `gamma` and `chromaticities` count together.
struct ColourFacts {
    std::optional<ColourCode> code; ///< PNG's cICP, nclx of HEIC and AVIF.
    std::string icc;                ///< ICC profile.
    bool isSrgb = false;            ///< PNG's sRGB chunk.
    /// PNG's gAMA: exponent of the encoding, mostly 0.45455; 1 = light (EXR, HDR); 0 = not stated.
    double gamma = 0;
    /// PNG's cHRM, and what EXR and HDR state: x and y of white, red, green, blue.
    std::optional<std::array<double, 8>> chromaticities;
};

/// What a PNG, JPEG, TIFF, WebP, HEIC, AVIF, EXR or HDR file states; other bytes state nothing.
ColourFacts readColourFacts(std::string_view bytes, ImageFormat format);

/// The same for a picture of a HEIC or AVIF file.
/// @param item its number; not given: the main picture
/// @throws PictureFailure (no such picture)
ColourFacts readColourFacts(const HeifFile& file, std::optional<std::uint32_t> item = std::nullopt);

/// The ICC profile of sRGB; always the same bytes.
std::vector<unsigned char> srgbProfile();

/// Converts a picture to sRGB: relative colorimetric with black point compensation (lcms2). PQ and
/// HLG are tone-mapped to the range of sRGB by the curve of ITU-R BT.2390 for a source of 1000
/// cd/m² and a white of 203 cd/m², applied to the largest of red, green and blue.
///
/// Pictures whose profile is sRGB in all but name (at most 2 of 255 levels of difference) keep
/// their bytes, and so do pictures with profiles that are not for RGB or grey. Floats above 1 stay
/// above 1; those without a number become 0.
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3, CV_32FC1 or CV_32FC3, BGR];
///        grey pictures become BGR where a profile changes them
/// @param facts what the file states
/// @param notes if given, receives remarks (damaged profile, tone mapping)
void convertToSrgb(cv::Mat& picture, const ColourFacts& facts, Notes* notes);

/// Whether a profile is for CMYK.
bool isCmykProfile(std::string_view icc);

/// Converts inks to sRGB as convertToSrgb() does.
/// @param inks [CV_8UC4] cyan, magenta, yellow, black
/// @param icc a profile for CMYK; empty: colours by the usual formula, (1 - ink) (1 - black)
/// @param isInverted 0 means full ink, as Adobe's programs write it; otherwise 255 does
/// @return [CV_8UC3, BGR]; empty if the profile is damaged
cv::Mat inksToSrgb(const cv::Mat& inks, const std::string& icc, bool isInverted);

/// @param lab [CV_32FC3] L* 0..100, a*, b*, relative to D50 @return [CV_16UC3, BGR] sRGB
cv::Mat labToSrgb(const cv::Mat& lab);

/// @param light [CV_32FC3] X, Y, Z
/// @return [CV_32FC3, BGR] the same light in the primaries of sRGB, not encoded
cv::Mat xyzToRgb(const cv::Mat& light);

/// The light of an HDR picture as sRGB, in plain formulas: the reference of convertToSrgb() for PQ
/// and HLG, whose tables it fills.
/// @param value 0..1, as encoded @param transfer 16 (PQ) or 18 (HLG)
/// @return PQ: light in units of 10000 cd/m²; HLG: light of the scene, 0..1
double linearLight(double value, int transfer);

/// The matrix from linear red, green and blue of other primaries to those of sRGB. White stays.
/// @param primaries code of H.273
cv::Matx33d toSrgbLight(int primaries);

/// The curve of BT.2390 from 1000 cd/m² to 203 cd/m².
/// @param light cd/m², from 0 @return cd/m², 0..203
double toneMapped(double light);

} // namespace altiro3D
